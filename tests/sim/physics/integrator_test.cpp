// SPDX-License-Identifier: BSD-3-Clause
// The integrator against a fine reference: other equations (world angular momentum), other variables, 10 us steps.
#include <gtest/gtest.h>

#include "tests/sim/physics/flight.hpp"

namespace swiftlet::sim {
namespace {

using State = Eigen::Matrix<double, 17, 1>;  // p 3, v 3, q (w x y z) 4, L_world 3, rotor speeds 4

struct Reference {
  Airframe airframe;
  PhysicsConfig config;
  Vector3 wind_mps;
  std::array<double, 4> target_radps;

  Vector3 rate_body(const State& s) const {
    double momentum_z = 0.0;
    for (int i = 0; i < 4; ++i) momentum_z += airframe.rotors[i].direction() * airframe.rotor_inertia_kgm2 * s[13 + i];
    const Vector3 momentum = rotation(s).transpose() * Vector3(s.segment<3>(10)) - Vector3(0, 0, momentum_z);
    return momentum.cwiseQuotient(airframe.inertia_diagonal_kgm2);
  }

  static Matrix3 rotation(const State& s) {
    return Eigen::Quaterniond(s[6], s[7], s[8], s[9]).normalized().toRotationMatrix();
  }

  State slope(const State& s) const {
    const Matrix3 R = rotation(s);
    const Vector3 w = rate_body(s);
    const Vector3 v_air = R.transpose() * (Vector3(s.segment<3>(3)) - wind_mps);
    Vector3 force = -0.5 * config.air_density_kgpm3 * v_air.norm() * airframe.body_drag_area_m2.cwiseProduct(v_air);
    Vector3 torque = Vector3::Zero();
    State d;
    for (int i = 0; i < 4; ++i) {
      const double speed = s[13 + i];
      const Vector3 arm = airframe.rotors[i].position_m;
      const double thrust = airframe.thrust_constant_N_per_radps2 * speed * speed;
      const Vector3 hub = v_air + w.cross(arm);
      const Vector3 f =
          Vector3(0, 0, thrust) - airframe.rotor_drag_N_per_radps_mps * speed * Vector3(hub.x(), hub.y(), 0.0);
      force += f;
      torque += arm.cross(f) - Vector3(0, 0, airframe.rotors[i].direction() * airframe.torque_to_thrust_m * thrust);
      const double tau =
          target_radps[i] > speed ? airframe.motor_time_constant_up_s : airframe.motor_time_constant_down_s;
      d[13 + i] = (target_radps[i] - speed) / tau;
    }
    d.segment<3>(0) = s.segment<3>(3);
    d.segment<3>(3) = config.gravity_mps2 + R * force / airframe.mass_kg;
    d[6] = -0.5 * (s[7] * w.x() + s[8] * w.y() + s[9] * w.z());
    d[7] = 0.5 * (s[6] * w.x() + s[8] * w.z() - s[9] * w.y());
    d[8] = 0.5 * (s[6] * w.y() + s[9] * w.x() - s[7] * w.z());
    d[9] = 0.5 * (s[6] * w.z() + s[7] * w.y() - s[8] * w.x());
    d.segment<3>(10) = R * torque;
    return d;
  }

  State run(State s, double seconds) const {
    const double h = 1e-5;
    for (int n = static_cast<int>(std::lround(seconds / h)); n > 0; --n) {
      const State k1 = slope(s);
      const State k2 = slope(s + 0.5 * h * k1);
      const State k3 = slope(s + 0.5 * h * k2);
      const State k4 = slope(s + h * k3);
      s += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    return s;
  }
};

struct Errors {
  double position_m, velocity_mps, attitude_rad, rate_radps;
};

Errors errors_at_step(double step_s) {
  Airframe airframe = test_quad();
  airframe.inertia_diagonal_kgm2 = {0.02, 0.03, 0.045};
  airframe.rotor_drag_N_per_radps_mps = 8e-5;
  airframe.body_drag_area_m2 = {0.05, 0.07, 0.11};
  PhysicsConfig config;
  config.contacts = false;
  config.step_s = step_s;
  WindConfig wind;
  wind.mean_mps = {2, 1, -0.5};
  PhysicsVehicle vehicle = vehicle_at({1, 2, 30}, airframe);
  vehicle.motors_on = true;
  vehicle.start.v_world_mps = {6, -2, 3};
  vehicle.start.omega_body_radps = {4, -6, 3};
  vehicle.start.q_world_body = Eigen::AngleAxisd(0.7, Vector3(1, 2, -1).normalized());
  Flight flight(config, {vehicle}, nullptr, wind);
  flight.commands[0] = {0.9, 0.3, 0.55, 0.1};
  const double seconds = 0.4;
  flight.run(seconds, 0.008);

  Reference reference{airframe, config, wind.mean_mps, {}};
  State s = State::Zero();
  s.segment<3>(0) = vehicle.start.p_world_m;
  s.segment<3>(3) = vehicle.start.v_world_mps;
  const Eigen::Quaterniond q = vehicle.start.q_world_body;
  s.segment<4>(6) = Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
  s.tail<4>().setConstant(airframe.hover_rotor_speed_radps());  // two senses of spin: no net momentum at the start
  s.segment<3>(10) = q * airframe.inertia_diagonal_kgm2.cwiseProduct(vehicle.start.omega_body_radps);
  for (int i = 0; i < 4; ++i) {
    reference.target_radps[i] =
        airframe.rotor_speed_min_radps +
        flight.commands[0][i] * (airframe.rotor_speed_max_radps - airframe.rotor_speed_min_radps);
  }
  s = reference.run(s, seconds);

  const VehicleState& state = flight.state();
  EXPECT_GT((state.p_world_m - vehicle.start.p_world_m).norm(), 1.0);
  return {(state.p_world_m - Vector3(s.segment<3>(0))).norm(), (state.v_world_mps - Vector3(s.segment<3>(3))).norm(),
          state.q_world_body.angularDistance(Eigen::Quaterniond(s[6], s[7], s[8], s[9]).normalized()),
          (state.omega_body_radps - reference.rate_body(s)).norm()};
}

TEST(Integrator, MatchesAFineReferenceWhileTumbling) {
  const Errors at_1ms = errors_at_step(0.001);
  EXPECT_LT(at_1ms.position_m, 1e-7);
  EXPECT_LT(at_1ms.velocity_mps, 1e-6);
  EXPECT_LT(at_1ms.attitude_rad, 1e-6);
  EXPECT_LT(at_1ms.rate_radps, 1e-5);
}

TEST(Integrator, ConvergesWithTheFourthOrder) {
  const Errors at_8ms = errors_at_step(0.008);
  const Errors at_4ms = errors_at_step(0.004);
  const Errors at_2ms = errors_at_step(0.002);
  EXPECT_LT(at_4ms.position_m, 1e-4);
  // 16 in the limit; the wake of lower orders leaves some room.
  EXPECT_GT(at_8ms.position_m / at_4ms.position_m, 10.0);
  EXPECT_GT(at_4ms.position_m / at_2ms.position_m, 10.0);
  EXPECT_GT(at_4ms.attitude_rad / at_2ms.attitude_rad, 10.0);
  EXPECT_GT(at_4ms.velocity_mps / at_2ms.velocity_mps, 10.0);
}

}  // namespace
}  // namespace swiftlet::sim
