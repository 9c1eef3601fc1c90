// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/ground_truth.hpp"

#include <cmath>

#include "swiftlet/core/base/finite.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/localization/local_poses.hpp"

namespace swiftlet {
namespace {

class GroundTruthEstimator : public StateEstimator {
 public:
  GroundTruthEstimator(const GroundTruthConfig& config, const AgentSetup& setup)
      : timeout_(from_seconds(config.timeout_s)),
        T_local_body_start_(setup.T_local_body_start),
        local_is_world_(setup.start_known == StartKnown::kPose) {
    estimate_.valid = true;
    estimate_.T_local_body = T_local_body_start_;
    last_.T = T_local_body_start_;
    NavState start;
    start.p_m = setup.T_local_body_start.translation();
    start.q = Eigen::Quaterniond(setup.T_local_body_start.linear());
    reckoning_.restart(start);
  }

  const StateEstimate& update(const Observation& observation, Outbox&) override {
    const PoseSample* newest = nullptr;
    for (const PoseSample& sample : observation.pose) {
      if (is_finite(sample) && (!started_ || sample.t > last_.t)) newest = &sample;
    }
    if (newest != nullptr) {
      take(*newest);
      reckoning_is_stale_ = true;
    }
    // With a pose in every tick there is nothing to propagate.
    for (const ImuSample& sample : observation.imu) {
      reckoning_is_stale_ ? reckoning_.keep(sample) : reckoning_.push(sample);
    }

    estimate_.t = observation.t;
    if (last_.t == observation.t && started_) {
      estimate_.T_local_body = last_.T;
      estimate_.v_local_mps = v_local_mps_;
      estimate_.omega_body_radps = omega_body_radps_;
    } else {
      carry_forward(observation.t);
    }
    if (observation.t - last_.t > timeout_)
      estimate_.valid = false;
    else
      estimate_.valid = estimate_.T_local_body.matrix().allFinite() && estimate_.v_local_mps.allFinite();
    return estimate_;
  }

  const char* fault() const override { return estimate_.valid ? "" : "no external pose"; }

 private:
  /// The first pose determines the local frame in the world unless the scenario gives the start pose.
  void take(const PoseSample& sample) {
    if (!started_ && !local_is_world_) {
      const double yaw_rad = yaw_of(sample.T_world_body.linear()) - yaw_of(T_local_body_start_.linear());
      estimate_.correct(level_alignment(yaw_rad, sample.T_world_body.translation(), T_local_body_start_.translation()));
    }
    const FrameChange to_local = FrameChange::to_local(estimate_);
    last_ = {sample.t, to_local.pose(sample.T_world_body)};
    v_local_mps_ = to_local.direction(sample.v_world_mps);
    omega_body_radps_ = sample.omega_body_radps;
    started_ = true;
  }

  void carry_forward(TimeNs t) {
    if (reckoning_is_stale_) {
      reckoning_.restart(
          {last_.t, last_.T.translation(), v_local_mps_, Eigen::Quaterniond(last_.T.linear()), omega_body_radps_});
      reckoning_is_stale_ = false;
    }
    const NavState now = reckoning_.at(t);
    estimate_.T_local_body = make_pose(now.p_m, now.q);
    estimate_.v_local_mps = now.v_mps;
    estimate_.omega_body_radps = now.omega_body_radps;
  }

  TimeNs timeout_;
  Pose T_local_body_start_;
  bool local_is_world_;  // the local frame equals the world frame from the start
  bool started_ = false;
  bool reckoning_is_stale_ = false;  // a pose newer than the start of dead reckoning has arrived
  TimedPose last_;                   // in the local frame
  Vector3 v_local_mps_ = Vector3::Zero(), omega_body_radps_ = Vector3::Zero();
  DeadReckoning reckoning_;
  StateEstimate estimate_;
};

}  // namespace

void GroundTruthConfig::visit(ConfigVisitor& v) {
  v.field("timeout_s", timeout_s, "[s] time without a pose after which the estimate is not valid", Range::positive());
}

std::unique_ptr<StateEstimator> make_ground_truth_estimator(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<GroundTruthEstimator>(dynamic_cast<const GroundTruthConfig&>(config), setup);
}

}  // namespace swiftlet
