// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/slam/map_sharing_config.hpp"

namespace swiftlet {

/// A submap as reported by its vehicle, in the local frame of that vehicle.
struct SubmapPlace {
  bool known = false;
  Pose T_local_submap = Pose::Identity();
  double path_length_m = 0.0;  ///< path length of the flight at the start of the submap
};

/// Pose of another vehicle's submap in an own submap.
struct MapClosure {
  int own = 0, other = 0;
  Pose T_own_other = Pose::Identity();
};

/// Residual of the loop through two closures and both trajectories between them: squared Mahalanobis distance with 6
/// degrees of freedom. From J. Mangelson et al., "Pairwise consistent measurement set maximization for robust
/// multi-robot map merging", ICRA 2018.
double loop_chi2(const MapClosure& a, const MapClosure& b, std::span<const SubmapPlace> own,
                 std::span<const SubmapPlace> others, const MapJoinConfig& config);

/// The largest set of pairwise consistent closures, as indices in rising order. Empty when it is too small, or when the
/// remaining closures have a consistent set more than half as large: then either might be right.
std::vector<int> agreeing_closures(std::span<const MapClosure> closures, std::span<const SubmapPlace> own,
                                   std::span<const SubmapPlace> others, const MapJoinConfig& config);

struct MapJoin {
  Pose T_local_otherlocal = Pose::Identity();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();  ///< as in JoinedMap
  std::vector<Pose> T_local_other;                           ///< poses of the other vehicle's submaps, where known
};

/// Optimizes both trajectories of submaps and the agreeing closures as one pose graph. The newest own submap is fixed
/// in the local frame. The newest submap of the other vehicle defines the transform between the frames.
MapJoin join_maps(std::span<const MapClosure> closures, std::span<const int> agreeing, std::span<const SubmapPlace> own,
                  std::span<const SubmapPlace> others, const MapJoinConfig& config);

}  // namespace swiftlet
