// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/map/voxel_map.hpp"

namespace swiftlet {

/// How far rays travel in each voxel, summed over the rays of a sweep [Vrba 2025, sec. III-C]. The sums lie in a dense
/// window around the sensor that is no larger than the map. Any frame, the same for all arguments.
///
/// A ray is cut by the planes of its steepest axis. Between two of them it meets at most three voxels, and its two ends
/// alone tell which, and how long. So the pieces are computed side by side, not one after the other as in the walk of
/// Amanatides and Woo. The lengths are the same to the rounding of single precision.
class RayLengths {
 public:
  /// Starts a sweep whose rays begin in the box and are no longer than the reach. Lengths start from 0.
  /// @param within  what lies outside of it is not counted, so that the window is no larger; null: everything is
  void begin(const Eigen::AlignedBox3d& origins_m, double reach_m, double edge_m, const VoxelGrid* within = nullptr);
  /// One ray. Nothing happens when it is not finite, begins outside of the box or is longer than the reach.
  /// @param direction  unit vector
  void add(const Vector3& origin_m, const Vector3& direction, double length_m);
  /// These voxels are not touched by apply(), whatever went through them.
  void leave_out(std::span<const Cell> cells);
  /// Eqs. (9), (12), (22): every voxel met goes towards g_free by n = updates_per_edge * length / edge. Ends the sweep.
  void apply(double updates_per_edge, VoxelMap& map);

  /// Length in a voxel so far [m].
  double length_m(const Cell& cell) const;
  /// Every voxel met, in the order of the window.
  std::vector<Cell> cells() const;
  const VoxelGrid& window() const { return window_; }

 private:
  void clear();
  double exit_edges(const Vector3& origin, const Vector3& direction) const;

  VoxelGrid window_;
  bool cut_ = false;  // can rays leave the window?
  Eigen::AlignedBox3d origins_m_;
  double reach_m_ = 0.0, edges_per_m_ = 1.0;
  Vector3 first_cell_ = Vector3::Zero();  // of the window
  std::vector<float> lengths_;            // in edges; all 0 between sweeps
  std::vector<float> weights_;            // of a row, scratch
};

}  // namespace swiftlet
