// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/odometry.hpp"

#include <cmath>
#include <numbers>

#include "swiftlet/core/base/finite.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// Body rate that rotates one attitude into the next.
Vector3 rate_between(const Eigen::Quaterniond& before, const Eigen::Quaterniond& after, double dt_s) {
  const Eigen::AngleAxisd turn(before.conjugate() * after);
  return turn.axis() * (std::remainder(turn.angle(), 2.0 * std::numbers::pi) / dt_s);
}

class OdometryEstimator : public StateEstimator {
 public:
  OdometryEstimator(const OdometryEstimatorConfig& config, const AgentSetup& setup)
      : config_(config),
        T_local_body_start_(setup.T_local_body_start),
        heading_known_(setup.start_known == StartKnown::kPose) {
    base_.p_m = setup.T_local_body_start.translation();
    base_.q = Eigen::Quaterniond(setup.T_local_body_start.linear());
    reckoning_.restart(base_);
  }

  const StateEstimate& update(const Observation& observation, Outbox&) override {
    for (const ImuSample& sample : observation.imu) reckoning_.push(sample);
    bool moved_on = false;
    for (const OdometrySample& sample : observation.odometry) {
      if (!is_finite(sample) || (aligned_ && sample.t <= base_.t)) continue;
      take(sample);
      moved_on = true;
    }
    if (moved_on) reckoning_.restart(base_);

    const NavState now = reckoning_.at(observation.t);
    estimate_.t = observation.t;
    estimate_.T_local_body = make_pose(now.p_m, now.q);
    estimate_.v_local_mps = now.v_mps;
    estimate_.omega_body_radps = now.omega_body_radps;
    estimate_.valid = now.all_finite() && observation.t - base_.t <= from_seconds(config_.timeout_s);
    set_covariance();
    if (!heading_known_) learn_heading(observation);
    return estimate_;
  }

  const char* fault() const override { return estimate_.valid ? "" : "no odometry"; }

 private:
  void take(const OdometrySample& sample) {
    if (!aligned_) {
      // Aligns position and heading of the odometry's frame; roll and pitch refer to gravity already.
      const double yaw = yaw_of(T_local_body_start_.linear()) - yaw_of(sample.T_local_body.linear());
      T_local_odometry_ = level_alignment(yaw, T_local_body_start_.translation(), sample.T_local_body.translation());
    }
    const Pose T_local_body = T_local_odometry_ * sample.T_local_body;
    NavState next;
    next.t = sample.t;
    next.p_m = T_local_body.translation();
    next.q = Eigen::Quaterniond(T_local_body.linear()).normalized();
    next.v_mps = T_local_odometry_.linear() * sample.v_local_body_mps;
    if (aligned_) {
      next.omega_body_radps = rate_between(base_.q, next.q, to_seconds(next.t - base_.t));
      distance_m_ += (next.p_m - base_.p_m).norm();
    }
    base_ = next;
    aligned_ = true;
  }

  /// The first compass heading rotates the local frame about the start.
  void learn_heading(const Observation& observation) {
    for (const CompassSample& sample : observation.compass) {
      if (heading_known_ || !std::isfinite(sample.yaw_rad)) continue;
      const Vector3& start_m = T_local_body_start_.translation();
      const double yaw_rad = sample.yaw_rad - yaw_of(estimate_.T_local_body.linear());
      estimate_.correct(level_alignment(yaw_rad, start_m, start_m));
      heading_known_ = true;
    }
  }

  void set_covariance() {
    const double sigma_p = config_.position_drift * distance_m_;
    const double sigma_yaw = radians(config_.yaw_drift_degpm) * distance_m_;
    estimate_.covariance.setZero();
    estimate_.covariance.diagonal() << Vector3::Constant(sigma_p * sigma_p), 0.0, 0.0, sigma_yaw * sigma_yaw;
  }

  OdometryEstimatorConfig config_;
  Pose T_local_body_start_;
  bool heading_known_;
  Pose T_local_odometry_ = Pose::Identity();
  bool aligned_ = false;
  double distance_m_ = 0.0;
  NavState base_;  // at the newest odometry sample
  DeadReckoning reckoning_;
  StateEstimate estimate_;
};

}  // namespace

void OdometryEstimatorConfig::visit(ConfigVisitor& v) {
  v.field("timeout_s", timeout_s, "[s] time without odometry after which the estimate is not valid", Range::positive());
  v.field("position_drift", position_drift, "[-] reported standard deviation of the position per distance flown",
          Range::non_negative());
  v.field("yaw_drift_degpm", yaw_drift_degpm, "[deg/m] reported standard deviation of the heading per distance flown",
          Range::non_negative());
}

std::unique_ptr<StateEstimator> make_odometry_estimator(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<OdometryEstimator>(dynamic_cast<const OdometryEstimatorConfig&>(config), setup);
}

}  // namespace swiftlet
