// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <span>

#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// How the local frame of another vehicle lies in one's own, by submaps that both have seen. Both frames have z up.
struct JoinedMap {
  VehicleId other = kNoVehicle;
  TimeNs joined = 0;  ///< when enough closures agreed for the first time
  Pose T_local_otherlocal = Pose::Identity();
  /// Of the place of the other's newest submap [m] and of the heading [rad], in the own local frame.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();
  int num_closures = 0;  ///< that agree
};

/// Who joins its map with those of others: an estimator, and the agent that it flies.
class JoinsMaps {
 public:
  virtual ~JoinsMaps() = default;
  /// As of now, in the order of the vehicles.
  virtual std::span<const JoinedMap> joined_maps() const = 0;
};

}  // namespace swiftlet
