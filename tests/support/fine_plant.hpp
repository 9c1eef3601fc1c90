// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/base/airframe.hpp"
#include "swiftlet/core/base/observation.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"

namespace swiftlet::testing {

/// A multirotor for tests of control: rigid body by Runge-Kutta 4 in fine steps, motors with exact first-order lag
/// (unequal up and down), body drag quadratic, rotor drag linear, gyroscopic torque of the rotors, wind. Independent of
/// sim/physics.
class FinePlant {
 public:
  explicit FinePlant(const Airframe& airframe) : airframe_(airframe) { start_hovering(); }

  Vector3 p = Vector3::Zero(), v = Vector3::Zero(), omega = Vector3::Zero();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Vector3 wind = Vector3::Zero();
  TimeNs t = 0;
  bool ground = false;  ///< a floor at ground_z that supports the vehicle
  double ground_z = 0.0;
  std::array<double, kMaxRotors> speed{};

  void start_hovering() {
    speed.fill(std::sqrt(airframe_.mass_kg * 9.81 / (airframe_.num_rotors() * airframe_.thrust_constant_N_per_radps2)));
  }

  void advance(const std::array<double, kMaxRotors>& command, double dt_s, double step_s = 0.0005) {
    const int steps = std::max(1, static_cast<int>(std::lround(dt_s / step_s)));
    for (int i = 0; i < steps; ++i) step(command, dt_s / steps);
    t += from_seconds(dt_s);
  }

  Pose T_world_body() const { return make_pose(p, q); }
  StateEstimate truth() const {
    StateEstimate e;
    e.t = t;
    e.valid = true;
    e.T_local_body = T_world_body();
    e.v_local_mps = v;
    e.omega_body_radps = omega;
    return e;
  }
  PoseSample pose_sample() const { return {t, T_world_body(), v, omega}; }
  double tilt_rad() const { return std::acos(std::clamp((q * Vector3::UnitZ()).z(), -1.0, 1.0)); }

 private:
  struct State {
    Vector3 p, v, omega;
    Eigen::Vector4d q;
  };

  State derivative(const State& s) const {
    const Eigen::Quaterniond q_now(s.q[0], s.q[1], s.q[2], s.q[3]);
    const Matrix3 R = q_now.normalized().toRotationMatrix();
    const Vector3 v_air = R.transpose() * (s.v - wind);
    const double rho = 1.225;
    Vector3 force = -0.5 * rho * v_air.norm() * airframe_.body_drag_area_m2.cwiseProduct(v_air);
    Vector3 torque = Vector3::Zero();
    Vector3 spin = Vector3::Zero();
    for (int i = 0; i < airframe_.num_rotors(); ++i) {
      const Rotor& rotor = airframe_.rotors[i];
      const double thrust = airframe_.thrust_constant_N_per_radps2 * speed[i] * speed[i];
      Vector3 f(0.0, 0.0, thrust);
      const Vector3 v_hub = v_air + s.omega.cross(rotor.position_m);
      f.head<2>() -= airframe_.rotor_drag_N_per_radps_mps * speed[i] * v_hub.head<2>();
      force += f;
      torque += rotor.position_m.cross(f);
      torque.z() -= rotor.direction() * airframe_.torque_to_thrust_m * thrust;
      spin.z() += rotor.direction() * airframe_.rotor_inertia_kgm2 * speed[i];
    }
    const Vector3& J = airframe_.inertia_diagonal_kgm2;
    State d;
    d.p = s.v;
    d.v = R * force / airframe_.mass_kg - 9.81 * Vector3::UnitZ();
    const Vector3 momentum = J.cwiseProduct(s.omega) + spin;
    d.omega = (torque - s.omega.cross(momentum)).cwiseQuotient(J);
    const Eigen::Quaterniond dq =
        q_now * Eigen::Quaterniond(0.0, 0.5 * s.omega.x(), 0.5 * s.omega.y(), 0.5 * s.omega.z());
    d.q << dq.w(), dq.x(), dq.y(), dq.z();
    return d;
  }

  static State plus(const State& s, const State& d, double h) {
    return {s.p + h * d.p, s.v + h * d.v, s.omega + h * d.omega, s.q + h * d.q};
  }

  void step(const std::array<double, kMaxRotors>& command, double h) {
    for (int i = 0; i < airframe_.num_rotors(); ++i) {
      const double u = std::clamp(command[i], 0.0, 1.0);
      const double wanted =
          airframe_.rotor_speed_min_radps + u * (airframe_.rotor_speed_max_radps - airframe_.rotor_speed_min_radps);
      const double tau = wanted > speed[i] ? airframe_.motor_time_constant_up_s : airframe_.motor_time_constant_down_s;
      speed[i] = wanted + (speed[i] - wanted) * std::exp(-h / tau);
    }
    const State s{p, v, omega, {q.w(), q.x(), q.y(), q.z()}};
    const State k1 = derivative(s), k2 = derivative(plus(s, k1, 0.5 * h)), k3 = derivative(plus(s, k2, 0.5 * h)),
                k4 = derivative(plus(s, k3, h));
    const auto mix = [h](auto a, auto b, auto c, auto d, auto e) {
      return (a + h / 6.0 * (b + 2.0 * c + 2.0 * d + e)).eval();
    };
    p = mix(s.p, k1.p, k2.p, k3.p, k4.p);
    v = mix(s.v, k1.v, k2.v, k3.v, k4.v);
    omega = mix(s.omega, k1.omega, k2.omega, k3.omega, k4.omega);
    const Eigen::Vector4d q_next = mix(s.q, k1.q, k2.q, k3.q, k4.q).normalized();
    q = Eigen::Quaterniond(q_next[0], q_next[1], q_next[2], q_next[3]);
    if (ground && p.z() <= ground_z) {  // stiff friction, no bounce
      p.z() = ground_z;
      v = Vector3(0.0, 0.0, std::max(v.z(), 0.0));
      omega.setZero();
      q = Eigen::Quaterniond(Eigen::AngleAxisd(yaw_of(q.toRotationMatrix()), Vector3::UnitZ()));
    }
  }

  Airframe airframe_;
};

}  // namespace swiftlet::testing
