// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/frames.hpp"

namespace swiftlet {

struct SurfaceMapConfig {
  double cell_m = 2.0;
  int levels = 4;
  double fineness = 0.01;
  int points_per_cell = 300;
  double plane_sigma_m = 0.06;
  double keep_radius_m = 150.0;

  void visit(ConfigVisitor& v);
};

/// The points of one cell as a Gaussian, and the plane through them where they have one.
///
/// Any frame, the same for all arguments.
struct SurfaceCell {
  // Sums over the points, relative to the cell's corner: kept small, so that single precision is enough.
  float count = 0.0F;
  Eigen::Vector3f sum_m = Eigen::Vector3f::Zero();
  float sum_xx = 0.0F, sum_xy = 0.0F, sum_xz = 0.0F, sum_yy = 0.0F, sum_yz = 0.0F, sum_zz = 0.0F;
  // As of the last fit.
  float count_fitted = 0.0F;
  bool planar = false;
  bool settled = false;  ///< planar for good: finer cells below take no further points
  Eigen::Vector3f mean_m = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< of least variance
  float variance_m2 = 0.0F;                          ///< along the normal
  float narrow_variance_m2 = 0.0F;                   ///< the smaller one within the plane
  float wide_variance_m2 = 0.0F;                     ///< the larger one, along the axis
  Eigen::Vector3f axis = Eigen::Vector3f::Zero();    ///< of largest variance
  bool pole = false;  ///< no plane, but thin across a direction near the z axis, as a stem is

  /// The third direction, within the plane and across the axis.
  Eigen::Vector3f aside() const { return axis.cross(normal); }
};

/// Where surfaces are: cells of several sizes, each of which knows the plane through its points (adaptive voxels as in
/// C. Yuan et al., "Efficient and probabilistic adaptive voxel mapping for accurate online LiDAR odometry", RA-L 2022).
/// A point goes down from the largest cell to smaller ones until a cell is a plane. Cells keep their first points, so
/// that what was seen early stays the reference and does not creep along with the estimate.
///
/// Any frame, the same for all arguments, its z axis up (only poles ask for that). Results hang on the order of the
/// points only.
class SurfaceMap {
 public:
  explicit SurfaceMap(const SurfaceMapConfig& config);

  /// @param origin_m  of the rays
  void insert(std::span<const Vector3> points_m, const Vector3& origin_m);
  /// The largest cell around a point that is a plane; else the smallest that has enough points; null: nothing known.
  const SurfaceCell* find(const Vector3& p_m) const;
  /// The largest cell around a point that is a pole; null: none is.
  const SurfaceCell* find_pole(const Vector3& p_m) const;
  /// Does it take no further points?
  bool is_full(const SurfaceCell& cell) const { return cell.count >= static_cast<float>(config_.points_per_cell); }
  /// Forgets what lies farther than the configured radius.
  void keep_around(const Vector3& center_m);
  void clear();

  std::size_t num_cells() const;
  std::size_t bytes() const;

 private:
  /// Cells of one edge in a table with open addressing; cells stay in the order in which they were made.
  struct Level {
    double edge_m = 0.0;
    std::vector<std::uint64_t> keys;  // of the cells
    std::vector<SurfaceCell> cells;
    std::vector<std::uint32_t> table;  // index + 1 of a cell; 0: empty

    std::uint64_t key_of(const Vector3& p_m) const;
    SurfaceCell* find(std::uint64_t key);
    const SurfaceCell* find(std::uint64_t key) const { return const_cast<Level*>(this)->find(key); }
    std::uint32_t find_or_make(std::uint64_t key);
    void rebuild(std::size_t table_size);
  };

  void add(Level& level, std::uint64_t key, SurfaceCell& cell, const Vector3& p_m) const;
  void fit(const Level& level, std::uint64_t key, SurfaceCell& cell) const;

  SurfaceMapConfig config_;
  std::vector<Level> levels_;  // from the largest cells down
  struct Touched {
    std::uint32_t level = 0, cell = 0;
  };
  std::vector<Touched> touched_;  // by one insertion: to be fitted anew
};

}  // namespace swiftlet
