// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/multirotor_model.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet::sim {

struct MultirotorModel::RotorLoad {
  std::array<double, kMaxRotors> speed{};
  double thrust_N = 0.0;
  Vector3 torque_body_Nm = Vector3::Zero();
  double momentum_z = 0.0;  // angular momentum of the rotors along body z
};

struct MultirotorModel::Motors {
  std::array<std::array<double, kMaxRotors>, 3> speed{};  // at 0, h/2, h
  std::array<double, 3> momentum_rate{};                  // d/dt of the rotors' angular momentum along body z
};

MultirotorModel::MultirotorModel(const Airframe& airframe, const PhysicsConfig& config)
    : airframe_(airframe),
      config_(config),
      num_rotors_(airframe.num_rotors()),
      half_step_decay_up_down_{elementary::exp(-0.5 * config.step_s / airframe.motor_time_constant_up_s),
                               elementary::exp(-0.5 * config.step_s / airframe.motor_time_constant_down_s)},
      inertia_(airframe.inertia_diagonal_kgm2),
      inertia_inverse_(airframe.inertia_diagonal_kgm2.cwiseInverse()),
      rotor_drag_(config.rotor_drag && airframe.rotor_drag_N_per_radps_mps > 0.0) {
  for (int i = 0; i < num_rotors_; ++i) direction_[i] = airframe.rotors[i].direction();
}

double MultirotorModel::thrust_N(const VehicleState& state) const {
  double sum_sq = 0.0;
  for (int i = 0; i < num_rotors_; ++i) sum_sq += state.rotor_speed_radps[i] * state.rotor_speed_radps[i];
  return airframe_.thrust_constant_N_per_radps2 * sum_sq;
}

MultirotorModel::Motors MultirotorModel::run_motors(VehicleState& state,
                                                    const std::array<double, kMaxRotors>& rotor_command) const {
  const double h = config_.step_s;
  const double span = airframe_.rotor_speed_max_radps - airframe_.rotor_speed_min_radps;
  Motors motors;
  for (int i = 0; i < num_rotors_; ++i) {
    const double u = rotor_command[i];
    const double target = u >= 0.0 ? airframe_.rotor_speed_min_radps + span * std::min(u, 1.0) : 0.0;
    const double angular_momentum = direction_[i] * airframe_.rotor_inertia_kgm2;
    double& speed = state.rotor_speed_radps[i];
    double angle = target * h;
    if (config_.motor_lag) {
      // Speed approaches its target monotonically, so one time constant applies to the whole step.
      const bool up = target > speed;
      const double tau = up ? airframe_.motor_time_constant_up_s : airframe_.motor_time_constant_down_s;
      const double half_decay = half_step_decay_up_down_[up ? 0 : 1];
      const double excess = speed - target;
      motors.speed[0][i] = speed;
      motors.speed[1][i] = target + excess * half_decay;
      motors.speed[2][i] = target + excess * half_decay * half_decay;
      for (int k = 0; k < 3; ++k) motors.momentum_rate[k] += angular_momentum * (target - motors.speed[k][i]) / tau;
      angle += excess * tau * (1.0 - half_decay * half_decay);
    } else {
      for (int k = 0; k < 3; ++k) motors.speed[k][i] = target;
    }
    speed = motors.speed[2][i];
    state.rotor_angle_rad[i] += direction_[i] * angle;
  }
  return motors;
}

void MultirotorModel::step_motors(VehicleState& state, const std::array<double, kMaxRotors>& rotor_command) const {
  run_motors(state, rotor_command);
}

MultirotorModel::RotorLoad MultirotorModel::load(const std::array<double, kMaxRotors>& speed, double momentum_rate,
                                                 const AirAtVehicle& air) const {
  RotorLoad load;
  load.speed = speed;
  for (int i = 0; i < num_rotors_; ++i) {
    const double aerodynamic = airframe_.thrust_constant_N_per_radps2 * speed[i] * speed[i];
    const double thrust = aerodynamic * (1.0 + air.ground_effect_gain[i]);
    const Vector3& arm = airframe_.rotors[i].position_m;
    load.thrust_N += thrust;
    load.torque_body_Nm.x() += arm.y() * thrust;
    load.torque_body_Nm.y() -= arm.x() * thrust;
    // Aerodynamic drag torque of the rotor acts on the body through the motor.
    load.torque_body_Nm.z() -= direction_[i] * airframe_.torque_to_thrust_m * aerodynamic;
    load.momentum_z += direction_[i] * airframe_.rotor_inertia_kgm2 * speed[i];
  }
  if (config_.gyroscopic_torque) {
    load.torque_body_Nm.z() -= momentum_rate;
  } else {
    load.momentum_z = 0.0;
  }
  return load;
}

MultirotorModel::Acceleration MultirotorModel::accelerate(const RotorLoad& load, const Matrix3& R_world_body,
                                                          const Vector3& v_world, const Vector3& omega_body,
                                                          const AirAtVehicle& air) const {
  Vector3 force_body(0.0, 0.0, load.thrust_N);
  Vector3 torque_body = load.torque_body_Nm;

  // Drag of the body by its velocity relative to the air: -1/2 rho C_d A_i |v| v_i. Without body drag, only the
  // additional drag due to the downwash of other vehicles applies.
  const auto drag = [&](const Vector3& v_air_body) -> Vector3 {
    return (-0.5 * PhysicsConfig::kAirDensity_kgpm3 * v_air_body.norm()) *
           airframe_.body_drag_area_m2.cwiseProduct(v_air_body);
  };
  const Vector3 v_air_body = R_world_body.transpose() * (v_world - air.wind_world_mps - air.downwash_world_mps);
  if (config_.body_drag) {
    force_body += drag(v_air_body);
  } else if (!air.downwash_world_mps.isZero(0.0)) {
    force_body += drag(v_air_body) - drag(R_world_body.transpose() * (v_world - air.wind_world_mps));
  }

  // H-force of each rotor, from the velocity of its hub in the rotor plane.
  if (rotor_drag_) {
    for (int i = 0; i < num_rotors_; ++i) {
      const Vector3& arm = airframe_.rotors[i].position_m;
      const Vector3 v_hub = v_air_body + omega_body.cross(arm);
      const double factor = -airframe_.rotor_drag_N_per_radps_mps * load.speed[i];
      const Vector3 h_force(factor * v_hub.x(), factor * v_hub.y(), 0.0);
      force_body += h_force;
      torque_body += arm.cross(h_force);
    }
  }

  // Euler: J w' = torque - w x (J w + H), H the rotors' angular momentum.
  Vector3 momentum = inertia_.cwiseProduct(omega_body);
  momentum.z() += load.momentum_z;
  return {config_.gravity_world_mps2 + R_world_body * force_body / airframe_.mass_kg,
          inertia_inverse_.cwiseProduct(torque_body - omega_body.cross(momentum))};
}

MultirotorModel::Acceleration MultirotorModel::acceleration(const VehicleState& state, const AirAtVehicle& air) const {
  return accelerate(load(state.rotor_speed_radps, 0.0, air), state.q_world_body.toRotationMatrix(), state.v_world_mps,
                    state.omega_body_radps, air);
}

void MultirotorModel::step(VehicleState& state, const std::array<double, kMaxRotors>& rotor_command,
                           const AirAtVehicle& air) const {
  const double h = config_.step_s;
  const Motors motors = run_motors(state, rotor_command);
  const RotorLoad load_begin = load(motors.speed[0], motors.momentum_rate[0], air);
  const RotorLoad load_middle = load(motors.speed[1], motors.momentum_rate[1], air);
  const RotorLoad load_end = load(motors.speed[2], motors.momentum_rate[2], air);

  // Runge-Kutta 4 on (q, v, w); the position is integrated with the same weights from the stages' velocities.
  struct Slope {
    Eigen::Vector4d q;
    Vector3 v, omega;
  };
  const Eigen::Vector4d q0 = state.q_world_body.coeffs();
  const Vector3 v0 = state.v_world_mps;
  const Vector3 w0 = state.omega_body_radps;
  Vector3 velocity_sum = Vector3::Zero();
  const auto slope = [&](const RotorLoad& load, const Eigen::Vector4d& q, const Vector3& v, const Vector3& w,
                         double weight) -> Slope {
    velocity_sum += weight * v;
    const Eigen::Quaterniond rotation(q);
    const Acceleration acceleration = accelerate(load, rotation.normalized().toRotationMatrix(), v, w, air);
    const Eigen::Quaterniond spin(0.0, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z());
    return {(rotation * spin).coeffs(), acceleration.linear_world_mps2, acceleration.angular_body_radps2};
  };
  const Slope k1 = slope(load_begin, q0, v0, w0, 1.0);
  const Slope k2 = slope(load_middle, q0 + 0.5 * h * k1.q, v0 + 0.5 * h * k1.v, w0 + 0.5 * h * k1.omega, 2.0);
  const Slope k3 = slope(load_middle, q0 + 0.5 * h * k2.q, v0 + 0.5 * h * k2.v, w0 + 0.5 * h * k2.omega, 2.0);
  const Slope k4 = slope(load_end, q0 + h * k3.q, v0 + h * k3.v, w0 + h * k3.omega, 1.0);

  state.p_world_m += h / 6.0 * velocity_sum;
  state.v_world_mps = v0 + h / 6.0 * (k1.v + 2.0 * (k2.v + k3.v) + k4.v);
  state.omega_body_radps = w0 + h / 6.0 * (k1.omega + 2.0 * (k2.omega + k3.omega) + k4.omega);
  state.q_world_body =
      Eigen::Quaterniond(Eigen::Vector4d(q0 + h / 6.0 * (k1.q + 2.0 * (k2.q + k3.q) + k4.q))).normalized();
}

}  // namespace swiftlet::sim
