// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/slam/cell_keys.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/slam/local_slam_config.hpp"

namespace swiftlet {

/// [m] Largest standard deviation of a pole's points across its axis: that of points on the visible half of a stem 0.5
/// m in diameter. A cell without a plane whose points scatter more contains several objects. Larger values accept tree
/// crowns and corners as poles.
inline constexpr double kPoleSigma_m = 0.15;

/// The points of one cell as a Gaussian, and their plane if they have one.
///
/// Any frame, the same for all arguments.
struct SurfaceCell {
  // Sums over the points, relative to the cell's corner: small values, for which single precision suffices.
  float count = 0.0F;
  Eigen::Vector3f sum_m = Eigen::Vector3f::Zero();
  float sum_xx = 0.0F, sum_xy = 0.0F, sum_xz = 0.0F, sum_yy = 0.0F, sum_yz = 0.0F, sum_zz = 0.0F;
  // Results of the last fit.
  float count_fitted = 0.0F;
  bool planar = false;
  bool settled = false;  ///< permanently planar: finer cells below take no further points
  Eigen::Vector3f mean_m = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< direction of least variance, towards the sensor
  float variance_m2 = 0.0F;                          ///< along the normal
  float narrow_variance_m2 = 0.0F;                   ///< the smaller variance within the plane
  float wide_variance_m2 = 0.0F;                     ///< the larger variance, along the axis
  Eigen::Vector3f axis = Eigen::Vector3f::Zero();    ///< direction of largest variance
  bool pole = false;  ///< not planar, but thin across a nearly vertical axis, such as a stem

  /// Third direction, within the plane and perpendicular to the axis.
  Eigen::Vector3f aside() const { return axis.cross(normal); }
};

/// Map of surfaces: cells of several sizes, each with the plane through its points (adaptive voxels as in C. Yuan et
/// al., "Efficient and probabilistic adaptive voxel mapping for accurate online LiDAR odometry", RA-L 2022). A point is
/// passed from the largest cell to smaller ones until a cell is planar. Cells keep their first points, so that early
/// observations stay the reference and the map does not creep along with the estimate. The two faces of a thin wall are
/// surfaces of their own: points seen from behind a plane go to another cell at the same place.
///
/// Any frame, the same for all arguments, its z axis up (only poles require it). Equal points in equal order
/// give equal results.
class SurfaceMap {
 public:
  explicit SurfaceMap(const SurfaceMapConfig& config);

  /// @param origin_m  origin of the rays
  void insert(std::span<const Vector3> points_m, const Vector3& origin_m);
  /// Largest planar cell around a point, otherwise the smallest cell with enough points; nullptr if there is none.
  /// @param origin_m  origin of the ray that ends at the point
  const SurfaceCell* find(const Vector3& p_m, const Vector3& origin_m) const;
  /// Largest pole cell around a point; nullptr if there is none.
  const SurfaceCell* find_pole(const Vector3& p_m) const;
  /// True when the cell takes no further points.
  bool is_full(const SurfaceCell& cell) const { return cell.count >= static_cast<float>(config_.points_per_cell); }
  /// Drops cells farther than the configured radius.
  void keep_around(const Vector3& center_m);
  void clear();

  std::size_t num_cells() const;
  std::size_t bytes() const;

 private:
  /// Cells of one edge, in the order of their creation.
  struct Level {
    double edge_m = 0.0;
    KeyTable table;
    std::vector<SurfaceCell> cells;

    std::uint64_t key_of(const Vector3& p_m) const;
    const SurfaceCell* find(std::uint64_t key) const;
    std::uint32_t find_or_make(std::uint64_t key);
  };

  void add(Level& level, std::uint64_t key, SurfaceCell& cell, const Vector3& p_m) const;
  /// True when rays from this origin meet the plane of the cell from behind: their points belong to its other face.
  bool is_behind(const SurfaceCell& cell, const Vector3& origin_m) const;
  void fit(const Level& level, std::uint64_t key, SurfaceCell& cell, const Vector3& origin_m) const;

  SurfaceMapConfig config_;
  std::vector<Level> levels_;  // largest cells first
  struct Touched {
    std::uint32_t level = 0, cell = 0;
  };
  std::vector<Touched> touched_;  // cells to be fitted again after an insertion
};

}  // namespace swiftlet
