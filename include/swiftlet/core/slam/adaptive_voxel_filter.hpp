// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/slam/sweep.hpp"

namespace swiftlet {

struct AdaptiveVoxelConfig {
  double edge_max_m = 2.0;  ///< [m] largest edge of the cubes that keep one point each
  int points_min = 150;     ///< [-] the edge shrinks until at least this many points are left
  double range_max_m = 15.0;

  void visit(ConfigVisitor& v);
};

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
