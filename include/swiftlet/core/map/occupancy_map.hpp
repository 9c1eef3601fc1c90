// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/time.hpp"
#include "swiftlet/core/map/block_log.hpp"
#include "swiftlet/core/map/block_occupancy.hpp"
#include "swiftlet/core/map/log_odds_blocks.hpp"
#include "swiftlet/core/map/occupied_changes.hpp"
#include "swiftlet/core/map/submap_cells.hpp"

namespace swiftlet {

/// Sensor model of OctoMap [Hornung 2013]; the defaults are its library's.
struct OccupancyMapConfig {
  /// [-] Limits of a cell's probability, as the library's. Wider limits let a cell change later.
  static constexpr double kProbabilityMin = 0.1192, kProbabilityMax = 0.971;

  double edge_m = 0.1;
  double p_hit = 0.7;
  double p_miss = 0.4;
  double p_occupied = 0.5;
  double range_max_m = 20.0;
  double keep_radius_m = 30.0;
  double distance_max_m = 1.5;

  void visit(ConfigVisitor& v);
  /// Estimated memory: the whole ball observed, a tenth of it near surfaces, distances requested in a quarter.
  double bytes() const;
  /// Capacity of the block table along an axis.
  double places_across() const;
};

/// Occupancy map around a vehicle, identical cell by cell to OctoMap's library after the same scans. Log-odds are in
/// single precision, rays are traversed as in the library, and each cell is updated once per scan.
class OccupancyMap : public BlockOccupancy {
 public:
  explicit OccupancyMap(const OccupancyMapConfig& config);

  /// One beam of a scan, in the local frame.
  struct Ray {
    Eigen::Vector3f origin_local_m;
    Eigen::Vector3f end_local_m;
    bool hit = true;  ///< false: free up to the end
  };

  /// Inserts one scan. A cell in which any ray ends is hit once; every other cell on a ray is missed once. A ray longer
  /// than range_max_m hits nothing and clears cells up to that range, as in the library. The library has one origin per
  /// scan; here each ray has its own.
  void insert(std::span<const Ray> rays, TimeNs now);
  /// Drops blocks farther than keep_radius_m from this position.
  void keep_around(const Vector3& center_local_m);

  void occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                       std::vector<Vector3>& centers_local_m) const override;
  bool changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const override;
  void append_voxels(MapVoxels& copy) const override;

  /// Copies the states of a block; false: all its cells are unknown.
  bool look_at(const Cell& block, CellBlock& states) const;
  /// All blocks. Cells count as occupied above this probability, and as free below p_occupied; those between are
  /// omitted.
  std::vector<CellBlock> blocks_above(double p) const;

  /// Log-odds of the cell with these coordinates; 0 when it is unknown.
  float log_odds(const Cell& cell) const;
  bool known(const Cell& cell) const { return state_of(cell) != CellState::kUnknown; }
  std::size_t num_blocks() const { return blocks_.num_used(); }

 private:
  using Block = LogOddsBlocks::Block;
  using Page = LogOddsBlocks::Page;

  int find_or_make(const Cell& block);
  void forget(int block);
  void miss(int i, const Bits& passed);
  void miss_valued(int i, int z, std::uint64_t cells);
  void hit(const Cell& cell);
  CellState state_of(const Cell& cell) const override;
  const Bits* occupied_of(const Cell& block) const override;
  void append_changes(const Cell& low, const Cell& high, std::uint64_t since,
                      std::vector<Change>& changes) const override {
    changes_.append(blocks_, low, high, since, changes);
  }

  OccupancyMapConfig config_;
  float hit_, miss_, occupied_, min_, max_;  // log-odds
  LogOddsBlocks::AfterMisses after_misses_;
  int most_misses_ = 0;  // miss count at which the log-odds are clamped or a value is needed
  RayCells rays_;
  LogOddsBlocks blocks_;
  OccupiedChanges changes_;
  std::uint32_t scan_ = 0;
  std::vector<TimeNs> scan_times_;  // times of the last scans, in a ring buffer
  BlockLog removed_;
  Vector3 kept_around_local_m_;
};

}  // namespace swiftlet
