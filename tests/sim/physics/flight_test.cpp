// SPDX-License-Identifier: BSD-3-Clause
// Free flight against closed forms.
#include "tests/sim/physics/flight.hpp"

#include <gtest/gtest.h>

namespace swiftlet::sim {
namespace {

TEST(FreeFall, FollowsTheParabola) {
  PhysicsVehicle vehicle = vehicle_at({1, 2, 100});
  vehicle.start.v_world_mps = {3, -1, 4};
  Flight flight(bare_physics(), {vehicle});
  flight.run(2.0);
  EXPECT_NEAR((flight.state().p_world_m - Vector3(7, 0, 108 - 0.5 * kGravity * 4)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((flight.state().v_world_mps - Vector3(3, -1, 4 - 2 * kGravity)).norm(), 0.0, 1e-9);
  EXPECT_EQ(flight.state().t, from_seconds(2.0));
  EXPECT_EQ(flight.history.latest(0).t, from_seconds(2.0));
}

TEST(Hover, ThrustEqualsWeightAtHoverSpeed) {
  const Airframe airframe = test_quad();
  const double hover = airframe.hover_rotor_speed_radps();
  EXPECT_NEAR(4 * airframe.thrust_constant_N_per_radps2 * hover * hover, airframe.mass_kg * kGravity, 1e-12);

  PhysicsVehicle vehicle = vehicle_at({0, 0, 5});
  vehicle.motors_on = true;
  Flight flight(PhysicsConfig{}, {vehicle});  // every effect on
  flight.command(0, command_for(airframe, hover));
  flight.run(10.0);
  EXPECT_NEAR((flight.state().p_world_m - Vector3(0, 0, 5)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(tilt_rad(flight.state()), 0.0, 1e-9);
}

TEST(Hover, DoubleThrustClimbsWithOneG) {
  const Airframe airframe = test_quad();
  Flight flight(bare_physics(), {vehicle_at({0, 0, 0})});
  flight.command(0, command_for(airframe, airframe.hover_rotor_speed_radps() * std::numbers::sqrt2));
  flight.run(1.0);
  EXPECT_NEAR(flight.state().v_world_mps.z(), kGravity, 1e-9);
  EXPECT_NEAR(flight.state().p_world_m.z(), 0.5 * kGravity, 1e-9);
}

TEST(BodyDrag, FallApproachesTerminalVelocity) {
  PhysicsConfig config = bare_physics();
  config.body_drag = true;
  const Airframe airframe = test_quad();
  const double terminal =
      std::sqrt(2 * airframe.mass_kg * kGravity / (PhysicsConfig::kAirDensity_kgpm3 * airframe.body_drag_area_m2.z()));
  Flight flight(config, {vehicle_at({0, 0, 1000})});
  flight.run(2.0);
  EXPECT_NEAR(flight.state().v_world_mps.z(), -terminal * std::tanh(kGravity * 2.0 / terminal), 1e-8);
  flight.run(40.0);
  EXPECT_NEAR(flight.state().v_world_mps.z(), -terminal, 1e-6);
}

TEST(BodyDrag, ActsOnVelocityRelativeToAir) {
  PhysicsConfig config = bare_physics();
  config.body_drag = true;
  config.gravity_world_mps2.setZero();
  WindConfig wind;
  wind.mean_mps = {8, 0, 0};
  const Airframe airframe = test_quad();
  Flight flight(config, {vehicle_at({0, 0, 10})}, nullptr, wind);
  flight.run(5.0);
  // v' = k (8 - v)^2 from rest: 8 - v = 8 / (1 + 8 k t).
  const double k = 0.5 * PhysicsConfig::kAirDensity_kgpm3 * airframe.body_drag_area_m2.x() / airframe.mass_kg;
  EXPECT_NEAR(flight.state().v_world_mps.x(), 8.0 - 8.0 / (1.0 + 8.0 * k * 5.0), 1e-9);
  EXPECT_EQ(flight.world.wind_world_mps(0), Vector3(8, 0, 0));
}

TEST(RotorDrag, BrakesInTheRotorPlaneOnly) {
  PhysicsConfig config = bare_physics();
  config.rotor_drag = true;
  Airframe airframe = test_quad();
  airframe.rotor_drag_N_per_radps_mps = 8.06e-5;
  for (Rotor& rotor : airframe.rotors) rotor.position_m.z() = 0.0;  // no pitching moment
  const double hover = airframe.hover_rotor_speed_radps();
  PhysicsVehicle vehicle = vehicle_at({0, 0, 10}, airframe);
  vehicle.start.v_world_mps = {5, 0, 2};
  vehicle.motors_on = true;
  Flight flight(config, {vehicle});
  flight.command(0, command_for(airframe, hover));
  flight.run(1.0);
  // Four rotors: v' = -4 c w / m v.
  EXPECT_NEAR(flight.state().v_world_mps.x(),
              5.0 * std::exp(-4 * airframe.rotor_drag_N_per_radps_mps * hover / airframe.mass_kg), 1e-9);
  EXPECT_NEAR(flight.state().v_world_mps.z(), 2.0, 1e-9);
}

TEST(Motors, FollowStepsWithTwoTimeConstants) {
  PhysicsConfig config = bare_physics();
  config.motor_lag = true;
  const Airframe airframe = test_quad();
  Flight flight(config, {vehicle_at({0, 0, 0})});

  flight.command(0, 1.0);
  flight.run(0.02);
  const double top = airframe.rotor_speed_max_radps;
  const double up_tau = airframe.motor_time_constant_up_s;
  const double reached = top * (1 - std::exp(-0.02 / up_tau));
  EXPECT_NEAR(flight.state().rotor_speed_radps[0], reached, 1e-9);
  // Angles: the integral, positive for counter-clockwise rotors.
  const double turned = top * (0.02 - up_tau * (1 - std::exp(-0.02 / up_tau)));
  EXPECT_NEAR(flight.state().rotor_angle_rad[0], turned, 1e-9);
  EXPECT_NEAR(flight.state().rotor_angle_rad[2], -turned, 1e-9);

  flight.command(0, 0.0);
  flight.run(0.05);
  const double low = airframe.rotor_speed_min_radps;
  EXPECT_NEAR(flight.state().rotor_speed_radps[1],
              low + (reached - low) * std::exp(-0.05 / airframe.motor_time_constant_down_s), 1e-9);
  flight.command(0, kOff);
  flight.run(2.0);
  EXPECT_NEAR(flight.state().rotor_speed_radps[3], 0.0, 1e-9);
}

TEST(Motors, LimitCommandsAndStopOnNan) {
  const Airframe airframe = test_quad();
  Flight flight(bare_physics(), {vehicle_at({0, 0, 0})});
  flight.command(0, 7.0);
  flight.run(0.004);
  EXPECT_DOUBLE_EQ(flight.state().rotor_speed_radps[0], airframe.rotor_speed_max_radps);
  flight.command(0, 0.25);
  flight.run(0.004);
  EXPECT_DOUBLE_EQ(flight.state().rotor_speed_radps[0],
                   0.75 * airframe.rotor_speed_min_radps + 0.25 * airframe.rotor_speed_max_radps);
  flight.command(0, std::nan(""));
  flight.run(0.004);
  EXPECT_EQ(flight.state().rotor_speed_radps[0], 0.0);
  EXPECT_TRUE(flight.state().p_world_m.allFinite());
}

TEST(Yaw, TurnsAgainstTheFasterRotors) {
  const Airframe airframe = test_quad();
  Flight flight(bare_physics(), {vehicle_at({0, 0, 0})});
  const double fast = 500.0;
  const double slow = 400.0;
  for (int i = 0; i < 4; ++i) {
    flight.commands[0][i] = command_for(airframe, airframe.rotors[i].spin == Rotor::Spin::kCcw ? fast : slow);
  }
  flight.run(0.5);
  const double torque =
      -2 * airframe.torque_to_thrust_m * airframe.thrust_constant_N_per_radps2 * (fast * fast - slow * slow);
  EXPECT_NEAR(flight.state().omega_body_radps.z(), torque / airframe.inertia_diagonal_kgm2.z() * 0.5, 1e-9);
  EXPECT_NEAR(flight.state().omega_body_radps.head<2>().norm(), 0.0, 1e-12);
}

TEST(Roll, MoreLeftThrustRollsRight) {
  const Airframe airframe = test_quad();
  Flight flight(bare_physics(), {vehicle_at({0, 0, 0})});
  const double fast = 500.0;
  const double slow = 490.0;
  for (int i = 0; i < 4; ++i) {
    flight.commands[0][i] = command_for(airframe, airframe.rotors[i].position_m.y() > 0 ? fast : slow);
  }
  flight.run(0.1);
  const double arm = airframe.arm_length_m / std::numbers::sqrt2;
  const double torque = 2 * arm * airframe.thrust_constant_N_per_radps2 * (fast * fast - slow * slow);
  EXPECT_NEAR(flight.state().omega_body_radps.x(), torque / airframe.inertia_diagonal_kgm2.x() * 0.1, 1e-9);
}

Vector3 angular_momentum(const VehicleState& state, const Airframe& airframe) {
  Vector3 body = airframe.inertia_diagonal_kgm2.cwiseProduct(state.omega_body_radps);
  for (int i = 0; i < airframe.num_rotors(); ++i) {
    body.z() += airframe.rotors[i].direction() * airframe.rotor_inertia_kgm2 * state.rotor_speed_radps[i];
  }
  return state.q_world_body * body;
}

TEST(Momentum, IsKeptWithoutForces) {
  PhysicsConfig config = bare_physics();
  config.gravity_world_mps2.setZero();
  Airframe airframe = test_quad();
  airframe.inertia_diagonal_kgm2 = {0.02, 0.03, 0.045};  // tumbles about its middle axis
  PhysicsVehicle vehicle = vehicle_at({0, 0, 0}, airframe);
  vehicle.start.v_world_mps = {1, 2, 3};
  vehicle.start.omega_body_radps = {0.1, 8.0, 0.2};
  Flight flight(config, {vehicle});
  const Vector3 before = angular_momentum(flight.state(), airframe);
  const auto energy = [&] {
    return flight.state().omega_body_radps.dot(
        airframe.inertia_diagonal_kgm2.cwiseProduct(flight.state().omega_body_radps));
  };
  const double energy_before = energy();
  flight.run(20.0);
  EXPECT_NEAR((flight.state().v_world_mps - Vector3(1, 2, 3)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((flight.state().p_world_m - Vector3(20, 40, 60)).norm(), 0.0, 1e-9);
  EXPECT_LT((angular_momentum(flight.state(), airframe) - before).norm(), 1e-7 * before.norm());
  EXPECT_NEAR(energy() / energy_before, 1.0, 1e-7);
  // The vehicle tumbled: rotation about the middle axis is unstable.
  EXPECT_GT(std::abs(tilt_rad(flight.state())), 0.1);
}

/// Thrust so weak that rotors only carry angular momentum.
Airframe flywheel_quad() {
  Airframe airframe = test_quad();
  airframe.thrust_constant_N_per_radps2 = 1e-20;
  airframe.rotor_inertia_kgm2 = 3e-4;
  return airframe;
}

TEST(Momentum, PassesFromSpinningRotorsToBody) {
  PhysicsConfig config = bare_physics();
  config.gravity_world_mps2.setZero();
  config.motor_lag = config.gyroscopic_torque = true;
  Airframe airframe = flywheel_quad();
  PhysicsVehicle vehicle = vehicle_at({0, 0, 0}, airframe);
  vehicle.start.omega_body_radps = {1.0, -2.0, 0.5};
  Flight flight(config, {vehicle});
  const Vector3 before = angular_momentum(flight.state(), airframe);
  flight.commands[0] = {1.0, 0.8, 0.1, 0.2};
  flight.run(2.0);
  EXPECT_LT((angular_momentum(flight.state(), airframe) - before).norm(), 1e-6 * before.norm());
  EXPECT_LT(flight.state().omega_body_radps.z(), -1.0);
}

TEST(Gyroscope, SpinningRotorsMakeTheBodyPrecess) {
  PhysicsConfig config = bare_physics();
  config.gravity_world_mps2.setZero();
  config.gyroscopic_torque = true;
  Airframe airframe = flywheel_quad();
  for (Rotor& rotor : airframe.rotors) rotor.spin = Rotor::Spin::kCcw;
  PhysicsVehicle vehicle = vehicle_at({0, 0, 0}, airframe);
  vehicle.start.omega_body_radps = {0.5, 0, 0};
  Flight flight(config, {vehicle});
  const double speed = 600.0;
  flight.command(0, command_for(airframe, speed));
  flight.run(1.0);
  // J w' = -w x (J w + H z) with J_x = J_y: the rate turns with H / J_x in the body's x-y plane.
  const double angle = 4 * airframe.rotor_inertia_kgm2 * speed / airframe.inertia_diagonal_kgm2.x() * 1.0;
  EXPECT_NEAR(flight.state().omega_body_radps.x(), 0.5 * std::cos(angle), 1e-6);
  EXPECT_NEAR(flight.state().omega_body_radps.y(), 0.5 * std::sin(angle), 1e-6);
  EXPECT_NEAR(flight.state().omega_body_radps.z(), 0.0, 1e-9);
}

/// Each effect changes the end of this flight; switched off, it changes nothing.
TEST(Switches, ReallySwitch) {
  struct Case {
    const char* name;
    bool PhysicsConfig::*effect;
  };
  const Case cases[] = {{"motor_lag", &PhysicsConfig::motor_lag},
                        {"gyroscopic_torque", &PhysicsConfig::gyroscopic_torque},
                        {"rotor_drag", &PhysicsConfig::rotor_drag},
                        {"body_drag", &PhysicsConfig::body_drag},
                        {"ground_effect", &PhysicsConfig::ground_effect},
                        {"downwash", &PhysicsConfig::downwash},
                        {"contacts", &PhysicsConfig::contacts}};
  Airframe airframe = test_quad();
  airframe.rotor_drag_N_per_radps_mps = 8e-5;
  const auto fly = [&](const PhysicsConfig& config) {
    PhysicsVehicle low = vehicle_at({0, 0, 0.5}, airframe, "low");
    low.motors_on = true;
    low.start.v_world_mps = {2, 1, -0.2};
    low.start.omega_body_radps = {0.5, 1.0, 0};
    PhysicsVehicle above = vehicle_at({0.2, 0, 2.5}, airframe, "above");
    above.motors_on = true;
    Flight flight(config, {low, above}, flat_ground());
    flight.commands[0] = {0.5, 0.4, 0.35, 0.35};
    flight.command(1, 0.5);
    flight.run(1.0);
    return flight.state(0).p_world_m;
  };
  const Vector3 bare = fly(bare_physics());
  for (const Case& c : cases) {
    PhysicsConfig config = bare_physics();
    config.*c.effect = true;
    EXPECT_GT((fly(config) - bare).norm(), 1e-5) << c.name;
  }
  EXPECT_EQ(fly(bare_physics()), bare);
}

}  // namespace
}  // namespace swiftlet::sim
