// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/imu.hpp"

#include <algorithm>
#include <optional>

#include "sim/sensors/noise.hpp"
#include "sim/sensors/rotor_vibration.hpp"
#include "swiftlet/core/base/gravity.hpp"

namespace swiftlet::sim {

void ImuConfig::visit(ConfigVisitor& v) {
  v.model("model", model, "sensors", "preset: imu_adis16448, imu_icm42688, imu_icm40609, imu_mrs, imu_perfect");
  visit_common(v);
  v.field("rate_hz", rate_hz, "[Hz] samples per second, up to the physics rate", Range::between(1e-3, 1e6));
  v.field("position_m", position_m, "[m] mounting position, body frame");
  v.field("rotation_rpy_deg", rotation_rpy_deg, "[deg] mounting attitude in the body frame: roll, pitch, yaw");
  v.field("gyro_noise_density_radps_psqrthz", gyro_noise_density_radps_psqrthz,
          "[rad/s/sqrt(Hz)] white noise of the rates", Range::non_negative());
  v.field("gyro_bias_walk_radps2_psqrthz", gyro_bias_walk_radps2_psqrthz, "[rad/s^2/sqrt(Hz)] random walk of the bias",
          Range::non_negative());
  v.field("gyro_bias_time_s", gyro_bias_time_s, "[s] correlation time of the bias; 0: a pure random walk",
          Range::non_negative());
  v.field("gyro_turn_on_bias_radps", gyro_turn_on_bias_radps, "[rad/s] standard deviation of the constant bias",
          Range::non_negative());
  v.field("gyro_max_radps", gyro_max_radps, "[rad/s] saturation per axis", Range::positive());
  v.field("accel_noise_density_mps2_psqrthz", accel_noise_density_mps2_psqrthz,
          "[m/s^2/sqrt(Hz)] white noise of the specific force", Range::non_negative());
  v.field("accel_bias_walk_mps3_psqrthz", accel_bias_walk_mps3_psqrthz, "[m/s^3/sqrt(Hz)] random walk of the bias",
          Range::non_negative());
  v.field("accel_bias_time_s", accel_bias_time_s, "[s] correlation time of the bias; 0: a pure random walk",
          Range::non_negative());
  v.field("accel_turn_on_bias_mps2", accel_turn_on_bias_mps2, "[m/s^2] standard deviation of the constant bias",
          Range::non_negative());
  v.field("accel_max_mps2", accel_max_mps2, "[m/s^2] saturation per axis", Range::positive());
  v.object("mount_error", mount_error, "true mounting relative to that known to the agent");
  v.object("vibration", vibration, "vibration by the rotors");
  v.field("dropout_probability", dropout_probability, "[-] probability that a sample is lost", Range::probability());
  v.list("outages", outages, "times without samples");
}

namespace {

/// White noise, bias process and saturation of three axes.
class NoisyTriad {
 public:
  NoisyTriad(const SensorSetup& setup, const std::string& what, double density, double walk, double time_s,
             double turn_on_bias, double limit)
      : white_(setup.seed, "imu." + what, setup.entity),
        walk_(setup.seed, "imu." + what + ".bias", setup.entity),
        turn_on_bias_(turn_on_bias * normal3(Random(setup.seed, "imu." + what + ".turn_on", setup.entity), 0)),
        bias_(GaussMarkov::walking(Vector3::Constant(walk), time_s)),
        density_(density),
        limit_(limit) {}

  Vector3 corrupt(const Vector3& truth, double dt_s, std::uint32_t index) {
    bias_.advance(dt_s, normal3(walk_, index));
    const Vector3 noise = density_ / std::sqrt(dt_s) * normal3(white_, index);
    return (truth + turn_on_bias_ + bias_.value() + noise).cwiseMax(-limit_).cwiseMin(limit_);
  }

 private:
  Random white_, walk_;
  Vector3 turn_on_bias_;
  GaussMarkov bias_;
  double density_, limit_;
};

class ImuSensor final : public Sensor {
 public:
  ImuSensor(const ImuConfig& config, SensorSetup setup)
      : Sensor(std::move(setup)),
        schedule_(config.rate_hz,
                  Schedule(config.rate_hz).period()),  // the first interval ends one period after the start
        p_body_imu_(config.position_m + config.mount_error.position_m),
        R_body_imu_(rotation_of_rpy(config.rotation_rpy_deg * kRadPerDeg)),
        true_R_body_imu_(config.mount_error.applied_to(R_body_imu_)),
        gravity_world_(0.0, 0.0, -kGravity_mps2),
        gyro_(setup_, "gyro", config.gyro_noise_density_radps_psqrthz, config.gyro_bias_walk_radps2_psqrthz,
              config.gyro_bias_time_s, config.gyro_turn_on_bias_radps, config.gyro_max_radps),
        accel_(setup_, "accel", config.accel_noise_density_mps2_psqrthz, config.accel_bias_walk_mps3_psqrthz,
               config.accel_bias_time_s, config.accel_turn_on_bias_mps2, config.accel_max_mps2),
        dropout_probability_(config.dropout_probability),
        dropout_(stream("imu.dropout")),
        outages_(config.outages) {
    if (!config.vibration.none()) vibration_.emplace(config.vibration, stream("imu.vibration"));
  }

  void measure(TimeNs now, const StateHistory& truth, Observation& out) override {
    TimeNs due = 0;
    std::uint32_t index = 0;
    while (schedule_.next(now, due, index)) {
      const ImuSample measured = sample(due, index, truth);
      if (!is_lost(due, index)) out.imu.push_back(measured);
    }
  }

  double look_back_s() const override { return to_seconds(schedule_.period()); }

 private:
  /// State at the mounting point at the end of an interval, which is the start of the next.
  struct MountState {
    TimeNs t = -1;
    Eigen::Quaterniond q_world_body = Eigen::Quaterniond::Identity();
    Vector3 v_world_mps = Vector3::Zero();
  };

  bool is_lost(TimeNs due, std::uint32_t index) const {
    return (dropout_probability_ > 0.0 && dropout_.uniform(index, 0) < dropout_probability_) ||
           std::ranges::any_of(outages_, [due](const OutageConfig& outage) { return outage.contains(due); });
  }

  ImuSample sample(TimeNs due, std::uint32_t index, const StateHistory& truth) {
    const TimeNs begin = due - schedule_.period();
    const MountState start = last_.t == begin ? last_ : state_of_mount(truth, begin);
    const MountState end = state_of_mount(truth, due);
    last_ = end;
    const double dt_s = to_seconds(schedule_.period());

    const Vector3 turn = rotation_log(start.q_world_body.conjugate() * end.q_world_body);
    const Eigen::Quaterniond q_world_body_mid = start.q_world_body * rotation_exp(0.5 * turn);
    const Vector3 acceleration_world = (end.v_world_mps - start.v_world_mps) / dt_s;
    const Vector3 force_body = q_world_body_mid.conjugate() * (acceleration_world - gravity_world_);

    Vector3 rate_imu = true_R_body_imu_.conjugate() * (turn / dt_s);
    Vector3 force_imu = true_R_body_imu_.conjugate() * force_body;
    if (vibration_) {
      const RotorVibration::Mean shaken =
          vibration_->mean(truth.at(setup_.vehicle, begin), truth.at(setup_.vehicle, due), dt_s);
      rate_imu += shaken.omega_sensor_radps;
      force_imu += shaken.accel_sensor_mps2;
    }
    return {due, R_body_imu_ * gyro_.corrupt(rate_imu, dt_s, index),
            R_body_imu_ * accel_.corrupt(force_imu, dt_s, index)};
  }

  MountState state_of_mount(const StateHistory& truth, TimeNs t) const {
    const VehicleState state = truth.at(setup_.vehicle, t);
    return {t, state.q_world_body, state.v_world_mps + state.q_world_body * state.omega_body_radps.cross(p_body_imu_)};
  }

  Schedule schedule_;
  Vector3 p_body_imu_;
  Eigen::Quaterniond R_body_imu_;       // as calibrated
  Eigen::Quaterniond true_R_body_imu_;  // with the mounting error
  Vector3 gravity_world_;
  NoisyTriad gyro_, accel_;
  std::optional<RotorVibration> vibration_;
  double dropout_probability_;
  Random dropout_;
  std::vector<OutageConfig> outages_;
  MountState last_;
};

}  // namespace

std::unique_ptr<Sensor> make_imu_sensor(const ModuleConfig& config, SensorSetup setup) {
  return std::make_unique<ImuSensor>(dynamic_cast<const ImuConfig&>(config), std::move(setup));
}

}  // namespace swiftlet::sim
