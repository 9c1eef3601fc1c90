// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/base/airframe.hpp"
#include "swiftlet/core/control/mixer.hpp"
#include "swiftlet/core/control/motion_limits.hpp"

namespace swiftlet {

/// Gains of the cascade. A gain of 0 is derived from the airframe: the motor time constants bound the rate loop, which
/// bounds the attitude loop, which bounds the position loop. Gains act on accelerations, so mass and inertia cancel.
struct ControlGainsConfig {
  double position_radps = 0.0;    ///< natural frequency of the position loop
  double position_damping = 1.0;  ///< [-] damping ratio of the position loop; smaller values overshoot
  /// [s] integral time of the position loop; smaller values compensate wind sooner and overshoot; 0: no integral part
  double integral_time_s = 2.0;
  double integral_max_mps2 = 3.0;  ///< limit of the integral part; larger values compensate stronger wind
  double attitude_radps = 0.0;     ///< commanded rate per tilt error
  double rate_radps = 0.0;         ///< angular acceleration per error of roll or pitch rate
  double tilt_max_deg = 60.0;
  /// [deg/s] limit of the commanded roll and pitch rates together; smaller values turn the thrust later
  double tilt_rate_max_degps = 570.0;
  double yaw_rate_max_degps = 170.0;  ///< [deg/s] limit of the commanded yaw rate; smaller values turn more slowly

  void visit(ConfigVisitor& v);
};

/// Resolved gains.
struct ControlGains {
  double position = 0.0, velocity = 0.0, integral = 0.0;
  Vector3 attitude_body = Vector3::Zero();  ///< about the body axes
  Vector3 rate_body = Vector3::Zero();
};

/// Position -> acceleration -> attitude -> body rates -> torques -> rotors.
///
/// Structure and feed-forward terms are those of T. Lee, M. Leok, N. H. McClamroch, "Geometric tracking control of a
/// quadrotor UAV on SE(3)", CDC 2010: thrust along the body axis, and moment, eqs. (10), (11), (16). Deviations:
/// - The attitude error is the rotation angle instead of its sine, so that the controller also recovers an upside-down
///   vehicle.
/// - Tilt is controlled separately from heading, so that weak yaw torque never disturbs the thrust direction (D.
///   Brescianini, R. D'Andrea, "Tilt-prioritized quadrocopter attitude control", TCST 2020).
/// - Reference body rates follow from the reference jerk (D. Mellinger, V. Kumar, "Minimum snap trajectory generation
///   and control for quadrotors", ICRA 2011).
///
/// Rotor speeds are estimated by a motor model, which also gives the lead that compensates part of the motor lag.
class MultirotorController {
 public:
  using Commands = std::array<double, kMaxRotors>;

  /// Throws std::invalid_argument when the airframe cannot be controlled (see Mixer).
  MultirotorController(const Airframe& airframe, const ControlGainsConfig& config, double tick_s);

  /// Rotor commands 0..1 for the next `dt_s`. All zero when the estimate is not valid or not finite.
  /// @param jerk_local_mps3  jerk of the reference
  const Commands& step(const StateEstimate& estimate, const Reference& reference, const Vector3& jerk_local_mps3,
                       double dt_s);
  /// Sets the motors to idle and resets the integral part.
  const Commands& idle(double dt_s);

  const ControlGains& gains() const { return gains_; }
  const Mixer& mixer() const { return mixer_; }

 private:
  Vector3 wanted_acceleration(const StateEstimate& estimate, const Reference& reference, double dt_s);
  Vector3 drag_mps2(const Matrix3& R_local_body, const Vector3& v_local_mps) const;
  void command_rotors(const Mixer::Forces& force_N);
  void predict_rotor_speeds(double dt_s);

  Airframe airframe_;
  ControlGainsConfig config_;
  Mixer mixer_;
  ControlGains gains_;
  double tan_tilt_max_ = 1.7;
  double max_acceleration_mps2_ = 0.0;  ///< maximum thrust of all rotors over mass

  Vector3 integral_mps2_ = Vector3::Zero();
  Wrench wanted_;
  std::array<double, kMaxRotors> rotor_speed_radps_{};  ///< estimated by the motor model
  std::array<double, kMaxRotors> commanded_speed_radps_{};
  Commands commands_{};
  bool saturated_ = false;
  double decay_dt_s_ = -1.0;  ///< time step of the decays below
  double decay_up_ = 0.0, decay_down_ = 0.0, lead_up_ = 1.0, lead_down_ = 1.0;
};

}  // namespace swiftlet
