// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/time.hpp"
#include "swiftlet/core/map/cell_block.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// Sensor model of OctoMap [Hornung 2013]; the defaults are its library's.
struct OccupancyMapConfig {
  /// [-] Limits of a cell's probability, as the library's. Wider limits let a cell change later.
  static constexpr double kProbabilityMin = 0.1192, kProbabilityMax = 0.971;

  /// [cells] Upper limit of cached distances. Larger values take more memory around changed cells.
  static constexpr int kMaxDistance_cells = 64;
  /// [cells] Upper limit of range_max_m and keep_radius_m. Larger values take more memory.
  static constexpr int kMaxRadius_cells = 480;

  double edge_m = 0.1;
  double p_hit = 0.7;
  double p_miss = 0.4;
  double p_occupied = 0.5;
  double range_max_m = 20.0;
  double keep_radius_m = 30.0;
  /// [m] largest distance to the nearest occupied cell that is cached, at most kMaxDistance_cells; larger distances are
  /// searched on request
  double distance_max_m = 1.5;

  void visit(ConfigVisitor& v);
  /// Estimated memory: the whole ball observed, a tenth of it near surfaces, distances requested in a quarter.
  double bytes() const;
  /// Capacity of the block table along an axis.
  double places_across() const;
};

/// Occupancy map around a vehicle, identical cell by cell to OctoMap's library after the same scans. Log-odds are in
/// single precision, rays are traversed as in the library, and each cell is updated once per scan.
class OccupancyMap : public OccupancyView {
 public:
  /// One beam of a scan, in the local frame.
  struct Ray {
    Eigen::Vector3f origin_local_m;
    Eigen::Vector3f end_local_m;
    bool hit = true;  ///< false: free up to the end
  };

  /// Inserts one scan. A cell in which any ray ends is hit once; every other cell on a ray is missed once. A ray longer
  /// than range_max_m hits nothing and clears cells up to that range, as in the library. The library has one origin per
  /// scan; here each ray has its own.
  virtual void insert(std::span<const Ray> rays, TimeNs now) = 0;
  /// Drops blocks farther than keep_radius_m from this position.
  virtual void keep_around(const Vector3& center_local_m) = 0;

  /// Copies the states of a block; false: all its cells are unknown.
  virtual bool look_at(const Cell& block, CellBlock& states) const = 0;
  /// All blocks. Cells count as occupied above this probability, and as free below p_occupied; those between are
  /// omitted.
  virtual std::vector<CellBlock> blocks_above(double p) const = 0;

  /// Log-odds of the cell with these coordinates; 0 when it is unknown.
  virtual float log_odds(const Cell& cell) const = 0;
  virtual bool known(const Cell& cell) const = 0;
  virtual std::size_t num_blocks() const = 0;
};

std::unique_ptr<OccupancyMap> make_occupancy_map(const OccupancyMapConfig& config);

}  // namespace swiftlet
