// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/slam/matching/sweep.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/slam/grid_matching_config.hpp"

namespace swiftlet {

/// Thins points by the largest voxels that leave at least points_min of them, by binary search of the edge to a tenth
/// of it. Any frame, the same for all arguments; ranges are measured from its origin.
class AdaptiveVoxelFilter {
 public:
  /// Returns the edge [m]; 0: too few points for thinning. Points beyond the range are removed.
  double thin(std::span<const Eigen::Vector3f> points_m, const AdaptiveVoxelConfig& config,
              std::vector<Eigen::Vector3f>& kept_m);

 private:
  VoxelThinner thinner_;
  std::vector<Eigen::Vector3f> near_m_;
};

}  // namespace swiftlet
