// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "swiftlet/core/frames.hpp"
#include "swiftlet/core/slam/map_sharing_config.hpp"

namespace swiftlet {

/// A submap as its vehicle tells of it, in that vehicle's local frame.
struct SubmapPlace {
  bool known = false;
  Pose T_local_submap = Pose::Identity();
  double way_m = 0.0;  ///< of the flight when it began
};

/// Where a submap of the other lies in an own one.
struct MapClosure {
  int own = 0, other = 0;
  Pose T_own_other = Pose::Identity();
};

/// Around the loop of two closures and both trajectories between them: how far that leads from where it began. Squared
/// and by its covariance, with 6 degrees of freedom. From J. Mangelson et al., "Pairwise consistent measurement set
/// maximization for robust multi-robot map merging", ICRA 2018.
double loop_chi2(const MapClosure& a, const MapClosure& b, std::span<const SubmapPlace> own,
                 std::span<const SubmapPlace> others, const MapJoinConfig& config);

/// The largest set of closures of which any two agree, as indices in rising order. None when it is too small. None
/// either when those that are left have a set more than half as large: then either might be right.
std::vector<int> agreeing_closures(std::span<const MapClosure> closures, std::span<const SubmapPlace> own,
                                   std::span<const SubmapPlace> others, const MapJoinConfig& config);

struct MapJoin {
  Pose T_local_otherlocal = Pose::Identity();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();  ///< as JoinedMap has it
  std::vector<Pose> T_local_other;                           ///< of the other's submaps; where known
};

/// Both trajectories of submaps and these closures as one pose graph. The newest own submap stands still in the local
/// frame. The frames are told by where the newest submap of the other comes to lie.
MapJoin join_maps(std::span<const MapClosure> closures, std::span<const int> agreeing, std::span<const SubmapPlace> own,
                  std::span<const SubmapPlace> others, const MapJoinConfig& config);

}  // namespace swiftlet
