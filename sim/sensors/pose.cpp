// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/pose.hpp"

#include "sim/sensors/noise.hpp"

namespace swiftlet::sim {

void PoseConfig::visit(ConfigVisitor& v) {
  v.model("model", model, "sensors", "preset: pose_mocap, pose_rtk");
  visit_common(v);
  v.field("rate_hz", rate_hz, "[Hz] poses per second; 0: one in every tick", Range::between(0.0, 1e5));
  v.check(rate_hz == 0.0 || rate_hz >= 1e-3, "rate_hz", "0, or at least 0.001");
  v.field("sigma_position_m", sigma_position_m, "[m] standard deviation of the position per axis of the world",
          Range::non_negative());
  v.field("sigma_rotation_deg", sigma_rotation_deg, "[deg] standard deviation of the rotation about each body axis",
          Range::non_negative());
  v.field("sigma_velocity_mps", sigma_velocity_mps, "[m/s] standard deviation of the velocity per axis",
          Range::non_negative());
  v.field("sigma_rate_radps", sigma_rate_radps, "[rad/s] standard deviation of the body rate per axis",
          Range::non_negative());
  v.field("correlation_time_s", correlation_time_s,
          "[s] correlation time of the noise of position and rotation; 0: white", Range::non_negative());
}

namespace {

/// Noise of one quantity: white, or correlated in time with the same standard deviation.
class PoseNoise {
 public:
  PoseNoise(Random random, const Vector3& sigma, double time_s)
      : random_(random), sigma_(sigma), none_(sigma == Vector3::Zero()), time_s_(time_s) {}

  Vector3 at(TimeNs t, std::uint32_t index) {
    if (none_) return Vector3::Zero();
    const Vector3 normals = normal3(random_, index);
    if (time_s_ <= 0.0) return sigma_.cwiseProduct(normals);
    if (index == 0) {
      process_ = GaussMarkov::stationary(sigma_, time_s_, normals);
    } else {
      process_.advance(to_seconds(t - t_last_), normals);
    }
    t_last_ = t;
    return process_.value();
  }

 private:
  Random random_;
  Vector3 sigma_;
  bool none_;
  double time_s_;
  GaussMarkov process_;
  TimeNs t_last_ = 0;
};

class PoseSensor final : public Sensor {
 public:
  PoseSensor(const PoseConfig& config, SensorSetup setup)
      : Sensor(std::move(setup)),
        every_tick_(config.rate_hz <= 0.0),
        schedule_(every_tick_ ? 1.0 : config.rate_hz),
        position_noise_(stream("pose.position"), config.sigma_position_m, config.correlation_time_s),
        rotation_noise_(stream("pose.rotation"), config.sigma_rotation_deg * kRadPerDeg, config.correlation_time_s),
        velocity_noise_(stream("pose.velocity"), Vector3::Constant(config.sigma_velocity_mps), 0.0),
        rate_noise_(stream("pose.rate"), Vector3::Constant(config.sigma_rate_radps), 0.0) {}

  void measure(TimeNs now, const StateHistory& truth, Observation& out) override {
    if (every_tick_) {
      out.pose.push_back(sample(now, num_ticks_++, truth));
      return;
    }
    TimeNs due = 0;
    std::uint32_t index = 0;
    while (schedule_.next(now, due, index)) out.pose.push_back(sample(due, index, truth));
  }

 private:
  PoseSample sample(TimeNs t, std::uint32_t index, const StateHistory& truth) {
    const VehicleState state = truth.at(setup_.vehicle, t);
    PoseSample sample;
    sample.t = t;
    sample.T_world_body = make_pose(state.p_world_m + position_noise_.at(t, index),
                                    state.q_world_body * rotation_exp(rotation_noise_.at(t, index)));
    sample.v_world_mps = state.v_world_mps + velocity_noise_.at(t, index);
    sample.omega_body_radps = state.omega_body_radps + rate_noise_.at(t, index);
    return sample;
  }

  bool every_tick_;
  Schedule schedule_;
  std::uint32_t num_ticks_ = 0;
  PoseNoise position_noise_, rotation_noise_, velocity_noise_, rate_noise_;
};

}  // namespace

std::unique_ptr<Sensor> make_pose_sensor(const ModuleConfig& config, SensorSetup setup) {
  return std::make_unique<PoseSensor>(dynamic_cast<const PoseConfig&>(config), std::move(setup));
}

}  // namespace swiftlet::sim
