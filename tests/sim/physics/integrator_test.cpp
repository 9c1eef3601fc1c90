// SPDX-License-Identifier: BSD-3-Clause
// Order of the integrator: a tumbling vehicle with every effect of the air, at several steps.
#include <gtest/gtest.h>

#include "tests/sim/physics/flight.hpp"

namespace swiftlet::sim {
namespace {

VehicleState tumbled_with_steps_of(double step_s) {
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
  flight.run(0.4, 0.008);
  return flight.state();
}

TEST(Integrator, ConvergesWithTheFourthOrder) {
  const VehicleState fine = tumbled_with_steps_of(0.00025);
  struct Error {
    double position_m, velocity_mps, attitude_rad;
  };
  const auto error_at = [&](double step_s) -> Error {
    const VehicleState state = tumbled_with_steps_of(step_s);
    return {(state.p_world_m - fine.p_world_m).norm(), (state.v_world_mps - fine.v_world_mps).norm(),
            state.q_world_body.angularDistance(fine.q_world_body)};
  };
  const Error at_8ms = error_at(0.008), at_4ms = error_at(0.004), at_2ms = error_at(0.002), at_1ms = error_at(0.001);
  // 16 in the limit; the wake of lower orders leaves some room.
  EXPECT_GT(at_8ms.position_m / at_4ms.position_m, 10.0);
  EXPECT_GT(at_4ms.position_m / at_2ms.position_m, 10.0);
  EXPECT_GT(at_4ms.attitude_rad / at_2ms.attitude_rad, 10.0);
  EXPECT_GT(at_4ms.velocity_mps / at_2ms.velocity_mps, 10.0);
  EXPECT_LT(at_1ms.position_m, 1e-7) << "with the default step";
  EXPECT_LT(at_1ms.attitude_rad, 1e-6);
}

}  // namespace
}  // namespace swiftlet::sim
