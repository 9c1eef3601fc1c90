// SPDX-License-Identifier: BSD-3-Clause
#include "core/localization/ground_truth.hpp"

#include <cmath>

#include "core/localization/dead_reckoning.hpp"

namespace swiftlet {
namespace {

bool is_finite(const PoseSample& s) {
  return s.T_world_body.matrix().allFinite() && s.v_world_mps.allFinite() && s.omega_body_radps.allFinite();
}

class GroundTruthEstimator : public StateEstimator {
 public:
  GroundTruthEstimator(const GroundTruthConfig& config, const AgentSetup& setup)
      : timeout_(from_seconds(config.timeout_s)) {
    estimate_.valid = true;
    estimate_.T_world_body = setup.T_world_body_start;
    last_pose_.T_world_body = setup.T_world_body_start;
    NavState start;
    start.p_m = setup.T_world_body_start.translation();
    start.q = Eigen::Quaterniond(setup.T_world_body_start.linear());
    reckoning_.restart(start);
  }

  const StateEstimate& update(const Observation& observation) override {
    const PoseSample* newest = nullptr;
    for (const PoseSample& sample : observation.pose) {
      if (is_finite(sample) && (!started_ || sample.t > last_pose_.t)) newest = &sample;
    }
    if (newest != nullptr) {
      last_pose_ = *newest;
      started_ = true;
      reckoning_is_stale_ = true;
    }
    // Where a pose comes in every tick, nothing is ever carried forward.
    for (const ImuSample& sample : observation.imu) {
      reckoning_is_stale_ ? reckoning_.keep(sample) : reckoning_.push(sample);
    }

    estimate_.t = observation.t;
    if (last_pose_.t == observation.t && started_) {
      estimate_.T_world_body = last_pose_.T_world_body;
      estimate_.v_world_mps = last_pose_.v_world_mps;
      estimate_.omega_body_radps = last_pose_.omega_body_radps;
    } else {
      carry_forward(observation.t);
    }
    if (observation.t - last_pose_.t > timeout_)
      estimate_.valid = false;
    else
      estimate_.valid = estimate_.T_world_body.matrix().allFinite() && estimate_.v_world_mps.allFinite();
    return estimate_;
  }

  const char* fault() const override { return estimate_.valid ? "" : "no pose from outside"; }

 private:
  void carry_forward(TimeNs t) {
    if (reckoning_is_stale_) {
      reckoning_.restart({last_pose_.t, last_pose_.T_world_body.translation(), last_pose_.v_world_mps,
                          Eigen::Quaterniond(last_pose_.T_world_body.linear()), last_pose_.omega_body_radps});
      reckoning_is_stale_ = false;
    }
    const NavState now = reckoning_.at(t);
    estimate_.T_world_body = make_pose(now.p_m, now.q);
    estimate_.v_world_mps = now.v_mps;
    estimate_.omega_body_radps = now.omega_body_radps;
  }

  TimeNs timeout_;
  bool started_ = false;
  bool reckoning_is_stale_ = false;  // a newer pose is there than the one it started from
  PoseSample last_pose_;
  DeadReckoning reckoning_;
  StateEstimate estimate_;
};

}  // namespace

void GroundTruthConfig::visit(ConfigVisitor& v) {
  v.field("timeout_s", timeout_s, "[s] without a pose, after which the estimate is not valid", Range::positive());
}

std::unique_ptr<StateEstimator> make_ground_truth_estimator(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<GroundTruthEstimator>(dynamic_cast<const GroundTruthConfig&>(config), setup);
}

}  // namespace swiftlet
