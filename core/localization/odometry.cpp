// SPDX-License-Identifier: BSD-3-Clause
#include "core/localization/odometry.hpp"

#include <cmath>
#include <numbers>

#include "core/localization/dead_reckoning.hpp"

namespace swiftlet {
namespace {

bool is_finite(const OdometrySample& s) {
  return s.T_local_body.matrix().allFinite() && s.v_local_body_mps.allFinite();
}

/// Body rate that turns one attitude into the next.
Vector3 rate_between(const Eigen::Quaterniond& before, const Eigen::Quaterniond& after, double dt_s) {
  const Eigen::AngleAxisd turn(before.conjugate() * after);
  return turn.axis() * (std::remainder(turn.angle(), 2.0 * std::numbers::pi) / dt_s);
}

class OdometryEstimator : public StateEstimator {
 public:
  OdometryEstimator(const OdometryEstimatorConfig& config, const AgentSetup& setup)
      : config_(config), T_world_body_start_(setup.T_world_body_start) {
    base_.p_m = setup.T_world_body_start.translation();
    base_.q = Eigen::Quaterniond(setup.T_world_body_start.linear());
    reckoning_.restart(base_);
  }

  const StateEstimate& update(const Observation& observation) override {
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
    estimate_.T_world_body = make_pose(now.p_m, now.q);
    estimate_.v_world_mps = now.v_mps;
    estimate_.omega_body_radps = now.omega_body_radps;
    estimate_.valid = now.all_finite() && observation.t - base_.t <= from_seconds(config_.timeout_s);
    set_covariance();
    return estimate_;
  }

  const char* fault() const override { return estimate_.valid ? "" : "no odometry"; }

 private:
  void take(const OdometrySample& sample) {
    if (!aligned_) {
      // Position and heading of the local frame in the world; roll and pitch are measured against gravity anyway.
      const double yaw = yaw_of(T_world_body_start_.linear()) - yaw_of(sample.T_local_body.linear());
      T_world_local_.linear() = Eigen::AngleAxisd(yaw, Vector3::UnitZ()).toRotationMatrix();
      T_world_local_.translation() =
          T_world_body_start_.translation() - T_world_local_.linear() * sample.T_local_body.translation();
    }
    const Pose T_world_body = T_world_local_ * sample.T_local_body;
    NavState next;
    next.t = sample.t;
    next.p_m = T_world_body.translation();
    next.q = Eigen::Quaterniond(T_world_body.linear()).normalized();
    next.v_mps = T_world_local_.linear() * sample.v_local_body_mps;
    if (aligned_) {
      next.omega_body_radps = rate_between(base_.q, next.q, to_seconds(next.t - base_.t));
      distance_m_ += (next.p_m - base_.p_m).norm();
    }
    base_ = next;
    aligned_ = true;
  }

  void set_covariance() {
    const double sigma_p = config_.position_drift * distance_m_;
    const double sigma_yaw = config_.yaw_drift_degpm * std::numbers::pi / 180.0 * distance_m_;
    estimate_.covariance.setZero();
    estimate_.covariance.diagonal() << Vector3::Constant(sigma_p * sigma_p), 0.0, 0.0, sigma_yaw * sigma_yaw;
  }

  OdometryEstimatorConfig config_;
  Pose T_world_body_start_;
  Pose T_world_local_ = Pose::Identity();
  bool aligned_ = false;
  double distance_m_ = 0.0;
  NavState base_;  // at the newest odometry sample
  DeadReckoning reckoning_;
  StateEstimate estimate_;
};

}  // namespace

void OdometryEstimatorConfig::visit(ConfigVisitor& v) {
  v.field("timeout_s", timeout_s, "[s] without odometry, after which the estimate is not valid", Range::positive());
  v.field("position_drift", position_drift, "[-] sigma of the position told in the covariance, by distance flown",
          Range::non_negative());
  v.field("yaw_drift_degpm", yaw_drift_degpm, "[deg/m] sigma of the heading told in the covariance, by distance flown",
          Range::non_negative());
}

std::unique_ptr<StateEstimator> make_odometry_estimator(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<OdometryEstimator>(dynamic_cast<const OdometryEstimatorConfig&>(config), setup);
}

}  // namespace swiftlet
