// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "swiftlet/core/map/voxel_map.hpp"

namespace swiftlet {

/// Ray length in each voxel, summed over the rays of a sweep [Vrba 2025, sec. III-C]. The sums are stored in a dense
/// window around the sensor, no larger than the map. Any frame, the same for all arguments.
///
/// A ray is cut by the planes of its steepest axis. Between two planes it crosses at most three voxels, determined by
/// the ends of that piece alone. So the pieces are computed in parallel, not sequentially as in the traversal of
/// Amanatides and Woo. The lengths are equal up to the rounding of single precision.
class RayLengths {
 public:
  /// Begins a sweep with rays that start in the box and are no longer than the reach. Resets the lengths to 0.
  /// @param within  region outside of which lengths are ignored, which limits the window; null: unlimited
  void begin(const Eigen::AlignedBox3d& origins_m, double reach_m, double edge_m, const VoxelGrid* within = nullptr);
  /// Adds one ray. Ignored when it is not finite, starts outside of the box or is longer than the reach.
  /// @param direction  unit vector
  void add(const Vector3& origin_m, const Vector3& direction, double length_m);
  /// Eqs. (9), (12), (22): updates every voxel on a ray toward g_free with n = updates_per_edge * length / edge. Ends
  /// the sweep.
  void apply(double updates_per_edge, VoxelMap& map);

  /// Accumulated length in a voxel [m].
  double length_m(const Cell& cell) const;
  /// All voxels on rays, in the order of the window.
  std::vector<Cell> cells() const;
  const VoxelGrid& window() const { return window_; }

 private:
  void clear();
  double exit_edges(const Vector3& origin, const Vector3& direction) const;

  VoxelGrid window_;
  bool cut_ = false;  // true: rays can leave the window
  Eigen::AlignedBox3d origins_m_;
  double reach_m_ = 0.0, edges_per_m_ = 1.0;
  Vector3 first_cell_ = Vector3::Zero();  // first cell of the window
  std::vector<float> lengths_;            // in voxel edges; all 0 between sweeps
  std::vector<float> weights_;            // scratch: weights of a row
};

}  // namespace swiftlet
