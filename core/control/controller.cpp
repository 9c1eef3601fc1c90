// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/control/controller.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [kg/m^3] Density of air at sea level, for the compensation of drag.
constexpr double kAirDensity_kgpm3 = 1.225;
/// [m/s^2] Limit of the feedback of position and velocity errors together. Larger values return faster from large
/// errors, with more tilt.
constexpr double kFeedbackMax_mps2 = 6.0;
/// [-] Share of the motors' lag that is compensated. Larger values permit faster loops and command larger changes of
/// speed.
constexpr double kMotorLead = 0.5;
/// [ticks] Mean delay from a measurement to its effect: the age of the sample and half of the time that a command is
/// held. Larger values make the loops slower.
constexpr double kDelay_ticks = 1.5;
/// [-] Bandwidth of the rate loop times its delay. Larger values respond faster and overshoot.
constexpr double kRateDelay = 0.5;
/// [rad/s] Limits of the derived bandwidth of the rate loop. A higher upper limit amplifies noise of the gyroscope on
/// small vehicles.
constexpr double kSlowestRate_radps = 4.0, kFastestRate_radps = 35.0;
/// [-] Ratio of the bandwidths of the rate and the attitude loop; 4 damps them critically. Smaller values overshoot.
constexpr double kRatePerAttitude = 4.0;
/// [-] Ratio of the bandwidths of roll and pitch rate and of the yaw rate, for which little torque is available.
/// Smaller values saturate the rotors in turns.
constexpr double kRatePerYawRate = 4.0;
/// [-] Ratio of the bandwidths of the attitude and the position loop. Smaller values overshoot.
constexpr double kAttitudePerPosition = 2.5;
/// [rad/s] Limit of the derived bandwidth of the position loop. Larger values react to noise of the position.
constexpr double kFastestPosition_radps = 2.5;
/// [-] Least vertical part of the thrust, as a share of the weight. Smaller values descend faster and may turn over.
constexpr double kMinLift = 0.2;
/// [m/s^2] Limit of the compensated drag. Larger values let a wrong velocity command large tilts.
constexpr double kDragMax_mps2 = 5.0;
/// [s] Limits of the time step. Longer gaps between estimates count as the upper one, which bounds the integral part.
constexpr double kShortestTick_s = 1e-4, kLongestTick_s = 0.1;
/// [-] Cosine of the tilt error below which the heading is not corrected: upside down it is undefined.
constexpr double kUpsideDown = -0.99;

/// Gains derived from the airframe's motors; numbers in the configuration override them.
ControlGains derive_gains(const Airframe& airframe, const ControlGainsConfig& config, double tick_s) {
  const auto given_or = [](double given, double derived) { return given > 0.0 ? given : derived; };
  // Delay in the rate loop: the part of the motors' lag that is not compensated, and that of the samples.
  const double motor_lag_s = 0.5 * (airframe.motor_time_constant_up_s + airframe.motor_time_constant_down_s);
  const double lag_s = (1.0 - kMotorLead) * motor_lag_s + kDelay_ticks * tick_s;
  const double rate =
      given_or(config.rate_radps, std::clamp(kRateDelay / lag_s, kSlowestRate_radps, kFastestRate_radps));
  const double attitude = given_or(config.attitude_radps, rate / kRatePerAttitude);
  const double position =
      given_or(config.position_radps, std::min(attitude / kAttitudePerPosition, kFastestPosition_radps));
  const double yaw_rate = rate / kRatePerYawRate;
  const double yaw_attitude = yaw_rate / kRatePerAttitude;

  ControlGains gains;
  gains.position = position * position;
  gains.velocity = 2.0 * config.position_damping * position;
  gains.integral = config.integral_time_s > 0.0 ? gains.position / config.integral_time_s : 0.0;
  gains.attitude_body = {attitude, attitude, yaw_attitude};
  gains.rate_body = {rate, rate, yaw_rate};
  return gains;
}

Vector3 limit_norm(const Vector3& vector, double longest) {
  const double length = vector.norm();
  return length > longest ? Vector3(vector * (longest / length)) : vector;
}

/// Attitude with the body's z axis along a unit vector and heading `yaw` [rad] (Mellinger and Kumar 2011, sec. III).
Matrix3 attitude_for(const Vector3& thrust_direction, double yaw) {
  const Vector3 heading_left(-elementary::sin(yaw), elementary::cos(yaw), 0.0);
  Matrix3 R;
  R.col(2) = thrust_direction;
  R.col(0) = heading_left.cross(R.col(2)).normalized();  // nonzero, since the thrust points up
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}

/// Rotation vector from the body's attitude to the wanted one, body axes: tilt in x and y, heading in z.
Vector3 attitude_error(const Matrix3& R_local_body, const Matrix3& R_local_wanted) {
  const Matrix3 E = R_local_body.transpose() * R_local_wanted;
  // Tilt: the shortest turn that brings e3 onto the wanted thrust direction.
  const Vector3 b3 = E.col(2);
  const double sine = elementary::hypot(b3.x(), b3.y());
  const double angle = elementary::atan2(sine, b3.z());
  Vector3 error = Vector3::Zero();
  if (sine > 1e-9) {
    error.x() = -b3.y() * (angle / sine);
    error.y() = b3.x() * (angle / sine);
  } else if (b3.z() < 0.0) {
    error.x() = std::numbers::pi;  // exactly upside down: the axis is arbitrary
  }
  // Heading: the remaining twist about e3 (swing-twist of the quaternion of E); undefined when upside down.
  const double w2 = std::max(0.0, 1.0 + E.trace());
  const double twist = elementary::atan2(E(1, 0) - E(0, 1), w2);
  error.z() = b3.z() > kUpsideDown ? std::remainder(2.0 * twist, 2.0 * std::numbers::pi) : 0.0;
  return error;
}

}  // namespace

void ControlGainsConfig::visit(ConfigVisitor& v) {
  const Range range = Range::non_negative();
  v.field("position_radps", position_radps, "[rad/s] natural frequency of the position loop; 0: from the airframe",
          range);
  v.field("integral_max_mps2", integral_max_mps2, "[m/s^2] limit of the integral part, which compensates wind", range);
  v.field("attitude_radps", attitude_radps, "[rad/s] commanded rate per rad of tilt error; 0: from the airframe",
          range);
  v.field("rate_radps", rate_radps, "[1/s] angular acceleration per error of roll or pitch rate; 0: from the airframe",
          range);
  v.field("tilt_max_deg", tilt_max_deg, "[deg] limit of the angle between thrust and vertical",
          Range{0.0, 85.0, true, false});
}

MultirotorController::MultirotorController(const Airframe& airframe, const ControlGainsConfig& config, double tick_s)
    : airframe_(airframe), config_(config), mixer_(airframe), gains_(derive_gains(airframe, config, tick_s)) {
  tan_tilt_max_ = elementary::tan(config.tilt_max_deg * kRadPerDeg);
  max_acceleration_mps2_ = airframe.max_thrust_N() / airframe.mass_kg;
  // Initial rotor speeds are those of hovering.
  const double hover_speed_radps = airframe.hover_rotor_speed_radps(kGravity_mps2);
  rotor_speed_radps_.fill(hover_speed_radps);
  commanded_speed_radps_.fill(hover_speed_radps);
}

const MultirotorController::Commands& MultirotorController::idle(double dt_s) {
  predict_rotor_speeds(dt_s);
  integral_mps2_.setZero();
  wanted_ = {};
  saturated_ = false;
  commands_.fill(0.0);
  commanded_speed_radps_.fill(airframe_.rotor_speed_min_radps);
  return commands_;
}

const MultirotorController::Commands& MultirotorController::step(const StateEstimate& estimate,
                                                                 const Reference& reference,
                                                                 const Vector3& jerk_local_mps3, double dt_s) {
  const bool usable = estimate.valid && estimate.T_local_body.matrix().allFinite() &&
                      estimate.v_local_mps.allFinite() && estimate.omega_body_radps.allFinite() &&
                      reference.position_m.allFinite() && reference.velocity_mps.allFinite() &&
                      reference.acceleration_mps2.allFinite() && std::isfinite(reference.yaw_rad) &&
                      std::isfinite(reference.yaw_rate_radps) && jerk_local_mps3.allFinite() && std::isfinite(dt_s);
  if (!usable) return idle(std::isfinite(dt_s) ? dt_s : 0.0);
  dt_s = std::clamp(dt_s, kShortestTick_s, kLongestTick_s);
  predict_rotor_speeds(dt_s);

  // Specific thrust [m/s^2] in the local frame for the wanted acceleration and against gravity.
  const Matrix3& R = estimate.T_local_body.linear();
  Vector3 thrust_mps2 = wanted_acceleration(estimate, reference, dt_s) + kGravity_mps2 * Vector3::UnitZ();
  thrust_mps2.z() = std::clamp(thrust_mps2.z(), kMinLift * kGravity_mps2, max_acceleration_mps2_);
  const double level = elementary::hypot(thrust_mps2.x(), thrust_mps2.y());
  // With too little thrust for both, lift takes precedence over horizontal acceleration.
  const double level_max = std::min(
      tan_tilt_max_ * thrust_mps2.z(),
      std::sqrt(std::max(max_acceleration_mps2_ * max_acceleration_mps2_ - thrust_mps2.z() * thrust_mps2.z(), 1e-6)));
  saturated_ = level > level_max;
  if (saturated_) thrust_mps2.head<2>() *= level_max / level;
  const double thrust_norm = thrust_mps2.norm();
  const Matrix3 R_wanted = attitude_for(thrust_mps2 / thrust_norm, reference.yaw_rad);

  // Body rates of the reference, from its jerk, turned from the wanted attitude's axes into the body's.
  const Vector3 turn = (jerk_local_mps3 - R_wanted.col(2).dot(jerk_local_mps3) * R_wanted.col(2)) / thrust_norm;
  const Vector3 rate_wanted_axes(-turn.dot(R_wanted.col(1)), turn.dot(R_wanted.col(0)),
                                 reference.yaw_rate_radps * R_wanted(2, 2));
  Vector3 rate = R.transpose() * (R_wanted * rate_wanted_axes);
  rate += gains_.attitude_body.cwiseProduct(attitude_error(R, R_wanted));
  const double tilt_rate = elementary::hypot(rate.x(), rate.y());
  const double tilt_rate_max = config_.tilt_rate_max_degps * kRadPerDeg;
  if (tilt_rate > tilt_rate_max) rate.head<2>() *= tilt_rate_max / tilt_rate;
  rate.z() = std::clamp(rate.z(), -config_.yaw_rate_max_degps * kRadPerDeg, config_.yaw_rate_max_degps * kRadPerDeg);

  // Euler's equation with the wanted angular acceleration; thrust as projected on the body axis (Lee).
  const Vector3& omega = estimate.omega_body_radps;
  const Vector3& inertia = airframe_.inertia_diagonal_kgm2;
  wanted_.torque_body_Nm =
      inertia.cwiseProduct(gains_.rate_body.cwiseProduct(rate - omega)) + omega.cross(inertia.cwiseProduct(omega));
  wanted_.thrust_N = std::max(0.0, airframe_.mass_kg * thrust_mps2.dot(R.col(2)));
  command_rotors(mixer_.forces(wanted_, airframe_.mass_kg * kGravity_mps2));
  return commands_;
}

Vector3 MultirotorController::wanted_acceleration(const StateEstimate& estimate, const Reference& reference,
                                                  double dt_s) {
  const Vector3 p_error = reference.position_m - estimate.T_local_body.translation();
  const Vector3 v_error = reference.velocity_mps - estimate.v_local_mps;
  const Vector3 feedback = gains_.position * p_error + gains_.velocity * v_error;
  const Vector3 limited = limit_norm(feedback, kFeedbackMax_mps2);

  // Anti-windup: integrate only while neither the feedback nor the thrust is at its limit, and never beyond the bound.
  if (!saturated_ && feedback.squaredNorm() <= kFeedbackMax_mps2 * kFeedbackMax_mps2) {
    integral_mps2_ = limit_norm(integral_mps2_ + gains_.integral * dt_s * p_error, config_.integral_max_mps2);
  }
  Vector3 wanted = reference.acceleration_mps2 + limited + integral_mps2_;
  wanted -= drag_mps2(estimate.T_local_body.linear(), reference.velocity_mps);
  return wanted;
}

/// Acceleration [m/s^2] by the drag of body and rotors in still air at the present attitude and rotor speeds, local
/// axes; at most kDragMax_mps2.
Vector3 MultirotorController::drag_mps2(const Matrix3& R_local_body, const Vector3& v_local_mps) const {
  const Vector3 v_body = R_local_body.transpose() * v_local_mps;
  double speed_sum = 0.0;
  for (int i = 0; i < airframe_.num_rotors(); ++i) speed_sum += rotor_speed_radps_[i];
  Vector3 force_body = -0.5 * kAirDensity_kgpm3 * v_body.norm() * airframe_.body_drag_area_m2.cwiseProduct(v_body);
  force_body.head<2>() -= airframe_.rotor_drag_N_per_radps_mps * speed_sum * v_body.head<2>();
  return limit_norm(R_local_body * force_body / airframe_.mass_kg, kDragMax_mps2);
}

/// Predicts the rotor speeds under the last command (first-order lag, exact over the step).
void MultirotorController::predict_rotor_speeds(double dt_s) {
  if (dt_s != decay_dt_s_) {
    decay_dt_s_ = dt_s;
    decay_up_ = elementary::exp(-dt_s / airframe_.motor_time_constant_up_s);
    decay_down_ = elementary::exp(-dt_s / airframe_.motor_time_constant_down_s);
    // Factor of the commanded change of speed with which the motor's effective time constant is (1 - kMotorLead) times
    // its own.
    const auto lead = [&](double tau, double decay) {
      return (1.0 - elementary::exp(-dt_s / ((1.0 - kMotorLead) * tau))) / (1.0 - decay);
    };
    lead_up_ = dt_s > 0.0 ? lead(airframe_.motor_time_constant_up_s, decay_up_) : 1.0;
    lead_down_ = dt_s > 0.0 ? lead(airframe_.motor_time_constant_down_s, decay_down_) : 1.0;
  }
  for (int i = 0; i < airframe_.num_rotors(); ++i) {
    const double decay = commanded_speed_radps_[i] > rotor_speed_radps_[i] ? decay_up_ : decay_down_;
    rotor_speed_radps_[i] = commanded_speed_radps_[i] + (rotor_speed_radps_[i] - commanded_speed_radps_[i]) * decay;
  }
}

void MultirotorController::command_rotors(const Mixer::Forces& force_N) {
  const double least = airframe_.rotor_speed_min_radps;
  const double greatest = airframe_.rotor_speed_max_radps;
  for (int i = 0; i < airframe_.num_rotors(); ++i) {
    const double wanted = std::sqrt(force_N[i] / airframe_.thrust_constant_N_per_radps2);
    const double now = rotor_speed_radps_[i];
    const double lead = wanted > now ? lead_up_ : lead_down_;
    commanded_speed_radps_[i] = std::clamp(now + lead * (wanted - now), least, greatest);
    commands_[i] = (commanded_speed_radps_[i] - least) / (greatest - least);
  }
}

}  // namespace swiftlet
