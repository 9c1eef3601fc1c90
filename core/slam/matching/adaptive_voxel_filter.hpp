// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/slam/matching/sweep.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/slam/grid_matching_config.hpp"

namespace swiftlet {

/// Thins points with the largest voxel edge that leaves at least points_min of them, found by bisection to 10 % of the
/// edge. If even voxels of 1 % of edge_max_m leave fewer, these are used. Any frame, the same for all arguments; ranges
/// are measured from its origin.
class AdaptiveVoxelFilter {
 public:
  /// Returns the edge [m]; 0 if the range contains no more than points_min points, which are then all kept. Points
  /// beyond the range are removed.
  double thin(std::span<const Eigen::Vector3f> points_m, const AdaptiveVoxelConfig& config,
              std::vector<Eigen::Vector3f>& kept_m);

 private:
  VoxelThinner thinner_;
  std::vector<Eigen::Vector3f> near_m_;
};

}  // namespace swiftlet
