// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "sim/sensors/noise.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"

namespace swiftlet::sim {

/// Generates Scan::external_poses (see ExternalPoseConfig). One per sensor; sweeps must be in order.
class ExternalPoses {
 public:
  ExternalPoses(const ExternalPoseConfig& config, bool ideal, std::uint64_t seed, const std::string& entity);

  void append_poses(const StateHistory& truth, VehicleId vehicle, const Pose& T_body_lidar, TimeNs stamp,
                    TimeNs duration, std::uint32_t sweep, std::vector<StampedPose>& out);

 private:
  void advance(TimeNs t, std::uint32_t sweep, std::uint32_t pose_in_sweep);

  ExternalPoseConfig config_;
  Random position_random_, rotation_random_;
  bool started_ = false;
  TimeNs t_last_ = 0;
  GaussMarkov position_process_, rotation_process_;
  Vector3 position_noise_ = Vector3::Zero();  // t_n [m]
  Vector3 rotation_noise_ = Vector3::Zero();  // alpha_n, beta_n, gamma_n [rad]
};

}  // namespace swiftlet::sim
