// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <span>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Pose of another vehicle's local frame in the own one, from submaps of the same places. Both frames have z up.
struct JoinedMap {
  VehicleId other = kNoVehicle;
  TimeNs joined = 0;  ///< time at which enough closures agreed for the first time
  Pose T_local_otherlocal = Pose::Identity();
  /// Covariance of the position of the other's newest submap [m] and of the heading [rad], in the own local frame.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();
  int num_closures = 0;  ///< number of consistent closures
};

/// Interface of estimators, and their agents, that join their maps with those of others.
class JoinedMapProvider {
 public:
  virtual ~JoinedMapProvider() = default;
  /// Present joined maps, in the order of the vehicles.
  virtual std::span<const JoinedMap> joined_maps() const = 0;
};

}  // namespace swiftlet
