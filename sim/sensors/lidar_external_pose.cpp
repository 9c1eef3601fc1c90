// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/lidar_external_pose.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet::sim {
namespace {

Vector3 normals_of(const Random& random, std::uint32_t sweep, std::uint32_t pose_in_sweep) {
  const auto n = random.normal3(sweep, pose_in_sweep);
  return {n[0], n[1], n[2]};
}

}  // namespace

void ExternalPoseConfig::visit(ConfigVisitor& v) {
  v.field("enabled", enabled, "[-] whether scans contain poses of an external localization");
  v.field("sigma_position_m", sigma_position_m, "[m] standard deviation of the position per axis",
          Range::non_negative());
  v.field("sigma_rotation_rad", sigma_rotation_rad, "[rad] standard deviation of each Euler angle",
          Range::non_negative());
  v.field("correlation_time_s", correlation_time_s,
          "[s] correlation time of Gauss-Markov noise; 0: white, one draw for each sweep", Range::non_negative());
  v.field("spacing_s", spacing_s, "[s] interval between the poses of a rolling sweep", Range::between(1e-5, 1e3));
}

ExternalPoses::ExternalPoses(const ExternalPoseConfig& config, bool ideal, std::uint64_t seed,
                             const std::string& entity)
    : config_(config),
      position_random_(seed, "lidar.pose.position", entity),
      rotation_random_(seed, "lidar.pose.rotation", entity) {
  if (ideal) config_.sigma_position_m = config_.sigma_rotation_rad = 0.0;
}

void ExternalPoses::advance(TimeNs t, std::uint32_t sweep, std::uint32_t pose_in_sweep) {
  const bool white = config_.correlation_time_s <= 0.0;
  if (white && pose_in_sweep > 0) return;
  const Vector3 position_normals = normals_of(position_random_, sweep, pose_in_sweep);
  const Vector3 rotation_normals = normals_of(rotation_random_, sweep, pose_in_sweep);
  if (white) {
    position_noise_ = config_.sigma_position_m * position_normals;
    rotation_noise_ = config_.sigma_rotation_rad * rotation_normals;
    return;
  }
  if (!started_) {
    position_process_ = GaussMarkov::stationary(Vector3::Constant(config_.sigma_position_m), config_.correlation_time_s,
                                                position_normals);
    rotation_process_ = GaussMarkov::stationary(Vector3::Constant(config_.sigma_rotation_rad),
                                                config_.correlation_time_s, rotation_normals);
    started_ = true;
  } else {
    position_process_.advance(to_seconds(t - t_last_), position_normals);
    rotation_process_.advance(to_seconds(t - t_last_), rotation_normals);
  }
  t_last_ = t;
  position_noise_ = position_process_.value();
  rotation_noise_ = rotation_process_.value();
}

void ExternalPoses::append_poses(const StateHistory& truth, VehicleId vehicle, const Pose& T_body_lidar, TimeNs stamp,
                                 TimeNs duration, std::uint32_t sweep, std::vector<StampedPose>& out) {
  out.clear();
  if (!config_.enabled) return;
  const int intervals =
      duration == 0 ? 0 : std::max(1, static_cast<int>(std::lround(to_seconds(duration) / config_.spacing_s)));
  const Pose T_lidar_body = T_body_lidar.inverse();
  for (int k = 0; k <= intervals; ++k) {
    const TimeNs t = intervals == 0 ? stamp : stamp + duration * k / intervals;
    advance(t, sweep, static_cast<std::uint32_t>(k));
    // [Vrba 2025, eqs. 40, 41], solved for the measured pose.
    const Pose T_world_lidar = truth.at(vehicle, t).T_world_body() * T_body_lidar;
    const Eigen::Matrix3d R_n = rotation_of_rpy(rotation_noise_).toRotationMatrix();
    Pose measured = Pose::Identity();
    measured.linear() = T_world_lidar.linear() * R_n.transpose();
    measured.translation() = T_world_lidar.translation() - position_noise_;
    out.push_back({t, measured * T_lidar_body});
  }
}

}  // namespace swiftlet::sim
