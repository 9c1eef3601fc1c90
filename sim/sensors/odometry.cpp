// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/odometry.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "sim/sensors/noise.hpp"

namespace swiftlet::sim {

void OdometryConfig::visit(ConfigVisitor& v) {
  v.model("model", model, "sensors", "preset: odometry_vio, odometry_lio, odometry_perfect");
  visit_common(v);
  v.field("rate_hz", rate_hz, "[Hz] samples per second", Range::between(1e-3, 1e5));
  v.choice("frame", frame, {"start", "world", "random"},
           "[-] origin and heading of the local frame: those of the body at the start, those of the world, or random");
  v.field("initial_yaw_deg", initial_yaw_deg,
          "[deg] frame: random. Half-width of the uniform distribution of the heading relative to the world",
          Range::between(0.0, 180.0));
  v.field("drift_percent", drift_percent, "[%] RMS position error after a path of 100 m, relative to its length",
          Range::non_negative());
  v.field("drift_per_turn_m", drift_per_turn_m, "[m] RMS position error after a full turn", Range::non_negative());
  v.field("drift_m_psqrts", drift_m_psqrts,
          "[m/sqrt(s)] RMS position error after 1 s, also in hover; grows with the root of time",
          Range::non_negative());
  v.field("yaw_drift_deg", yaw_drift_deg, "[deg] RMS yaw error after a path of 100 m", Range::non_negative());
  v.field("yaw_drift_per_turn_deg", yaw_drift_per_turn_deg, "[deg] RMS yaw error after a full turn",
          Range::non_negative());
  v.field("yaw_drift_deg_psqrts", yaw_drift_deg_psqrts,
          "[deg/sqrt(s)] RMS yaw error after 1 s; grows with the root of time", Range::non_negative());
  v.field("scale_error_percent", scale_error_percent, "[%] standard deviation of the constant error of scale",
          Range::non_negative());
  v.field("sigma_position_m", sigma_position_m, "[m] white noise of the position per axis", Range::non_negative());
  v.field("sigma_tilt_deg", sigma_tilt_deg, "[deg] standard deviation of the error of roll and pitch",
          Range::non_negative());
  v.field("sigma_velocity_mps", sigma_velocity_mps, "[m/s] white noise of the velocity per axis",
          Range::non_negative());
}

namespace {

// [m] Length of path of the keys drift_percent and yaw_drift_deg.
constexpr double kDriftReference_m = 100.0;
// [m] Half-widths of the uniform distribution of the first position along x, y and z for the choice frame: random.
// Larger values start farther from the origin.
constexpr std::array kFirstPosition_m = {10.0, 10.0, 1.0};
// [s] Correlation time of the error of roll and pitch. Larger values keep an error longer.
constexpr double kTiltTime_s = 5.0;

/// Variance rates of a random walk over path length, turned angle and time.
struct WalkRates {
  double per_m = 0.0, per_rad = 0.0, per_s = 0.0;
  double variance(double path_m, double turn_rad, double dt_s) const {
    return per_m * path_m + per_rad * turn_rad + per_s * dt_s;
  }
};

double square(double x) { return x * x; }

class OdometrySensor final : public Sensor {
 public:
  OdometrySensor(const OdometryConfig& config, SensorSetup setup)
      : Sensor(std::move(setup)),
        config_(config),
        schedule_(config.rate_hz),
        position_walk_noise_(stream("odometry.walk.position")),
        yaw_walk_noise_(stream("odometry.walk.yaw")),
        white_position_(stream("odometry.position")),
        white_velocity_(stream("odometry.velocity")),
        tilt_noise_(stream("odometry.tilt")),
        scale_(1.0 + 0.01 * config.scale_error_percent * stream("odometry.scale").normal(0, 0)),
        tilt_(GaussMarkov::stationary(Vector3(1.0, 1.0, 0.0) * config.sigma_tilt_deg * kRadPerDeg, kTiltTime_s,
                                      normal3(stream("odometry.tilt.start"), 0))) {
    constexpr double kTurn = 2.0 * std::numbers::pi;
    position_rates_ = {square(0.01 * config.drift_percent) * kDriftReference_m, square(config.drift_per_turn_m) / kTurn,
                       square(config.drift_m_psqrts)};
    yaw_rates_ = {square(config.yaw_drift_deg * kRadPerDeg) / kDriftReference_m,
                  square(config.yaw_drift_per_turn_deg * kRadPerDeg) / kTurn,
                  square(config.yaw_drift_deg_psqrts * kRadPerDeg)};
  }

  void measure(TimeNs now, const StateHistory& truth, Observation& out) override {
    TimeNs due = 0;
    std::uint32_t index = 0;
    while (schedule_.next(now, due, index)) {
      const VehicleState state = truth.at(setup_.vehicle, due);
      if (index == 0) {
        start(state);
      } else {
        drift(state, index);
      }
      p_world_last_m_ = state.p_world_m;
      yaw_last_rad_ = yaw_of(state.q_world_body.toRotationMatrix());
      out.odometry.push_back(sample(due, index, state));
    }
  }

 private:
  void start(const VehicleState& state) {
    if (config_.frame == OdometryConfig::Frame::kStart) {
      yaw_local_world_rad_ = -yaw_of(state.q_world_body.toRotationMatrix());
      p_local_m_.setZero();
    } else if (config_.frame == OdometryConfig::Frame::kWorld) {
      yaw_local_world_rad_ = 0.0;
      p_local_m_ = state.p_world_m;
    } else {
      const Random random = stream("odometry.frame");
      const double limit_rad = config_.initial_yaw_deg * kRadPerDeg;
      yaw_local_world_rad_ = random.uniform(-limit_rad, limit_rad, 0, 0);
      for (int axis = 0; axis < 3; ++axis) {
        const double limit_m = kFirstPosition_m[axis];
        p_local_m_[axis] = random.uniform(-limit_m, limit_m, 0, 1 + axis);
      }
    }
  }

  /// Integrates the displacement since the last sample, rotated by the yaw error and scaled, plus a random-walk
  /// increment; then advances the yaw and tilt errors.
  void drift(const VehicleState& state, std::uint32_t index) {
    const Vector3 step_world = state.p_world_m - p_world_last_m_;
    const double path_m = step_world.norm();
    const double turn_rad = std::abs(wrap_angle(yaw_of(state.q_world_body.toRotationMatrix()) - yaw_last_rad_));
    const double dt_s = to_seconds(schedule_.period());

    p_local_m_ +=
        scale_ * (R_local_world() * step_world) +
        std::sqrt(position_rates_.variance(path_m, turn_rad, dt_s) / 3.0) * normal3(position_walk_noise_, index);
    // The yaw error is part of the rotation between the frames.
    yaw_local_world_rad_ += std::sqrt(yaw_rates_.variance(path_m, turn_rad, dt_s)) * yaw_walk_noise_.normal(index, 0);
    tilt_.advance(dt_s, normal3(tilt_noise_, index));
  }

  OdometrySample sample(TimeNs t, std::uint32_t index, const VehicleState& state) const {
    OdometrySample sample;
    sample.t = t;
    sample.T_local_body = make_pose(p_local_m_ + config_.sigma_position_m * normal3(white_position_, index),
                                    rotation_exp(tilt_.value()) * R_local_world() * state.q_world_body);
    sample.v_local_body_mps =
        scale_ * (R_local_world() * state.v_world_mps) + config_.sigma_velocity_mps * normal3(white_velocity_, index);
    return sample;
  }

  Eigen::Quaterniond R_local_world() const {
    return Eigen::Quaterniond(Eigen::AngleAxisd(yaw_local_world_rad_, Vector3::UnitZ()));
  }

  OdometryConfig config_;
  Schedule schedule_;
  Random position_walk_noise_, yaw_walk_noise_, white_position_, white_velocity_, tilt_noise_;
  WalkRates position_rates_, yaw_rates_;
  double scale_;
  GaussMarkov tilt_;
  Vector3 p_local_m_ = Vector3::Zero();
  double yaw_local_world_rad_ = 0.0;
  Vector3 p_world_last_m_ = Vector3::Zero();
  double yaw_last_rad_ = 0.0;
};

}  // namespace

std::unique_ptr<Sensor> make_odometry_sensor(const ModuleConfig& config, SensorSetup setup) {
  return std::make_unique<OdometrySensor>(dynamic_cast<const OdometryConfig&>(config), std::move(setup));
}

}  // namespace swiftlet::sim
