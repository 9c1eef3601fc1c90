// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/sim/physics/flight.hpp"

namespace swiftlet::sim {
namespace {

PhysicsConfig contact_physics() {
  PhysicsConfig config = bare_physics();
  config.contacts = true;
  return config;
}

std::shared_ptr<const StaticScene> slope(double angle_rad) {
  TestScene builder;
  const float x = static_cast<float>(20 * std::cos(angle_rad));
  const float z = static_cast<float>(20 * std::sin(angle_rad));
  builder.add_wall({-x, -20, -z}, {x, -20, z}, {x, 20, z}, {-x, 20, -z}, SurfaceClass::kGround);
  return std::make_shared<StaticScene>(builder.scene());
}

TEST(Landing, BringsDroppedVehiclesToRestUpright) {
  PhysicsConfig config;  // every effect on
  config.crash_speed_mps = 3.0;
  const Airframe airframe = test_quad();
  PhysicsVehicle vehicle = vehicle_at({0.3, 0.4, airframe.leg_height_m + 0.2}, airframe);
  vehicle.start.q_world_body = Eigen::AngleAxisd(0.15, Vector3(1, 0.5, 0).normalized());
  Flight flight(config, {vehicle}, flat_ground());
  flight.run(4.0);
  EXPECT_TRUE(flight.crashes.empty());
  EXPECT_TRUE(flight.world.in_contact(0));
  EXPECT_NEAR(flight.state().p_world_m.z(), airframe.leg_height_m, 0.002);
  EXPECT_LT(tilt_rad(flight.state()), 0.01);
  EXPECT_EQ(flight.state().v_world_mps.norm(), 0.0);
  const Vector3 rest = flight.state().p_world_m;
  flight.run(30.0);
  EXPECT_LT((flight.state().p_world_m - rest).norm(), 1e-9);
}

TEST(Landing, StandsWithIdlingRotorsWithoutDrift) {
  const Airframe airframe = test_quad();
  Flight flight(PhysicsConfig{}, {vehicle_at({1, 2, airframe.leg_height_m}, airframe)}, flat_ground());
  flight.command(0, 0.0);
  flight.run(0.2);  // too short to be frozen: the contacts alone hold it
  const Vector3 early = flight.state().p_world_m;
  EXPECT_LT((early - Vector3(1, 2, airframe.leg_height_m)).norm(), 0.001);
  flight.run(20.0);
  EXPECT_LT((flight.state().p_world_m - early).norm(), 0.001);
  EXPECT_FALSE(flight.state().crashed);
}

TEST(Landing, SurvivesSlowTouchdown) {
  const Airframe airframe = test_quad();
  PhysicsVehicle vehicle = vehicle_at({0, 0, airframe.leg_height_m + 0.05}, airframe);
  vehicle.motors_on = true;
  vehicle.start.v_world_mps = {0, 0, -0.3};
  PhysicsConfig config = contact_physics();
  config.motor_lag = true;
  Flight flight(config, {vehicle}, flat_ground());
  const double hover = command_for(airframe, airframe.hover_rotor_speed_radps());
  flight.command(0, 0.95 * hover);
  flight.run(1.5);
  EXPECT_TRUE(flight.world.in_contact(0));
  flight.command(0, 0.0);
  flight.run(3.0);
  EXPECT_TRUE(flight.crashes.empty());
  EXPECT_NEAR(flight.state().p_world_m.z(), airframe.leg_height_m, 0.002);
  flight.command(0, 1.3 * hover);
  flight.run(1.0);
  EXPECT_GT(flight.state().p_world_m.z(), 1.0);
  EXPECT_FALSE(flight.world.in_contact(0));
  EXPECT_LT(tilt_rad(flight.state()), 0.02);
}

TEST(Friction, SlidesOnSteepSlopesOnly) {
  const Airframe airframe = test_quad();
  PhysicsConfig config = contact_physics();
  config.crash_speed_mps = 10.0;
  for (const auto& [angle, mu] : {std::pair(0.25, 0.6), std::pair(0.5, 0.2)}) {
    config.contact_friction = mu;
    PhysicsVehicle vehicle = vehicle_at({0, 0, 0}, airframe);
    vehicle.start.q_world_body = Eigen::AngleAxisd(-angle, Vector3::UnitY());
    vehicle.start.p_world_m = vehicle.start.q_world_body * Vector3(0, 0, airframe.leg_height_m);
    Flight flight(config, {vehicle}, slope(angle));
    flight.run(1.0);
    const double slid_m = (flight.state().p_world_m - vehicle.start.p_world_m).norm();
    if (std::tan(angle) < mu) {
      EXPECT_LT(slid_m, 0.002);
    } else {
      // Coulomb: s = 1/2 g (sin - mu cos) t^2.
      EXPECT_NEAR(slid_m, 0.5 * kGravity * (std::sin(angle) - mu * std::cos(angle)), 0.03);
    }
  }
}

TEST(Impact, NeverPenetratesAndNeverGainsEnergy) {
  const Airframe airframe = test_quad();
  PhysicsConfig config = contact_physics();
  config.crash_speed_mps = 100.0;
  for (const double restitution : {0.0, 0.5, 1.0}) {
    config.contact_restitution = restitution;
    const double drop = 1.0;
    Flight flight(config, {vehicle_at({0, 0, airframe.leg_height_m + drop}, airframe)}, flat_ground());
    double lowest = 1.0;
    double top_after = 0.0;
    bool touched = false;
    for (int k = 0; k < 900; ++k) {
      flight.run(0.001, 0.001);
      lowest = std::min(lowest, flight.state().p_world_m.z() - airframe.leg_height_m);
      touched |= flight.world.in_contact(0);
      if (touched) top_after = std::max(top_after, flight.state().p_world_m.z() - airframe.leg_height_m);
    }
    EXPECT_TRUE(touched);
    EXPECT_GT(lowest, -0.003) << restitution;
    // Bounces to the square of the restitution, from four feet at once.
    EXPECT_NEAR(top_after, restitution * restitution * drop, 0.08) << restitution;
    EXPECT_LT(top_after, 1.02 * drop);
  }
}

std::shared_ptr<const StaticScene> wall_at_2m() {
  TestScene builder;
  builder.add_box({2, -5, -5}, {2.2F, 5, 5}, SurfaceClass::kPillar, 7);
  builder.add_wall({-50, -50, -6}, {50, -50, -6}, {50, 50, -6}, {-50, 50, -6}, SurfaceClass::kGround, 1);
  return std::make_shared<StaticScene>(builder.scene());
}

TEST(Crash, ReportsWallImpactAndStopsMotors) {
  const Airframe airframe = test_quad();
  PhysicsConfig config = contact_physics();
  config.motor_lag = true;
  PhysicsVehicle vehicle = vehicle_at({0, 0, 0}, airframe);
  vehicle.start.v_world_mps = {5, 0, 0};
  vehicle.motors_on = true;
  Flight flight(config, {vehicle}, wall_at_2m());
  flight.command(0, command_for(airframe, airframe.hover_rotor_speed_radps()));
  flight.run(0.5);
  ASSERT_EQ(flight.crashes.size(), 1U);
  const Crash& crash = flight.crashes.front();
  // The front propellers reach 0.25 / sqrt 2 + 0.15 m ahead.
  const double expected_s = (2.0 - airframe.arm_length_m / std::numbers::sqrt2 - airframe.propeller_radius_m) / 5.0;
  EXPECT_NEAR(to_seconds(crash.t), expected_s, 0.003);
  EXPECT_EQ(crash.vehicle, 0);
  EXPECT_EQ(crash.other_vehicle, kNoVehicle);
  EXPECT_EQ(crash.surface_class, SurfaceClass::kPillar);
  EXPECT_EQ(crash.instance, 7);
  EXPECT_NEAR(crash.p_world_m.x(), 2.0, 0.02);
  EXPECT_NEAR(crash.speed_mps, 5.0, 0.05);
  EXPECT_TRUE(flight.state().crashed);

  flight.run(6.0);
  EXPECT_LT(flight.state().rotor_speed_radps[0], 1e-3);
  EXPECT_LT(flight.state().p_world_m.z(), -5.5);  // fell to the ground and lies there
  EXPECT_GT(flight.state().p_world_m.z(), -6.1);
  EXPECT_LT(flight.state().v_world_mps.norm(), 0.05);
  EXPECT_EQ(flight.crashes.size(), 1U);  // one event a vehicle
}

TEST(Crash, KeepsMotorsRunningWhenConfigured) {
  PhysicsConfig config = contact_physics();
  config.stop_motors_on_crash = false;
  PhysicsVehicle vehicle = vehicle_at({0, 0, 0});
  vehicle.start.v_world_mps = {5, 0, 0};
  Flight flight(config, {vehicle}, wall_at_2m());
  flight.command(0, 0.5);
  flight.run(0.6);
  EXPECT_TRUE(flight.state().crashed);
  EXPECT_GT(flight.state().rotor_speed_radps[0], 100.0);
}

TEST(Crash, BreaksTurningPropellersAtAnySpeed) {
  PhysicsConfig config = contact_physics();
  config.gravity_world_mps2.setZero();
  for (const bool strict : {true, false}) {
    config.propeller_contact_is_crash = strict;
    PhysicsVehicle vehicle = vehicle_at({1.5, 0, 0});
    vehicle.start.v_world_mps = {0.2, 0, 0};
    vehicle.start.rotor_speed_radps.fill(300.0);
    PhysicsConfig lagging = config;
    lagging.motor_lag = true;
    Airframe weak = test_quad();
    weak.thrust_constant_N_per_radps2 = 1e-12;
    vehicle.airframe = weak;
    Flight flight(lagging, {vehicle}, wall_at_2m());
    flight.command(0, command_for(weak, 300.0));
    flight.run(2.0);
    EXPECT_EQ(flight.state().crashed, strict);
    EXPECT_LT(flight.state().v_world_mps.x(), 0.05);  // the wall stopped it in both cases
  }
}

TEST(Crash, ConservesMomentumOfBothVehicles) {
  PhysicsConfig config = contact_physics();
  config.gravity_world_mps2.setZero();
  PhysicsVehicle left = vehicle_at({-1, 0, 0}, test_quad(), "left");
  PhysicsVehicle right = vehicle_at({1, 0.05, 0}, test_quad(), "right");
  left.start.v_world_mps = {3, 0, 0};
  right.start.v_world_mps = {-1, 0, 0};
  right.airframe.mass_kg = 3.0;
  Flight flight(config, {left, right});
  flight.run(1.0);
  ASSERT_EQ(flight.crashes.size(), 2U);
  EXPECT_EQ(flight.crashes[0].vehicle, 0);
  EXPECT_EQ(flight.crashes[0].other_vehicle, 1);
  EXPECT_EQ(flight.crashes[1].vehicle, 1);
  EXPECT_EQ(flight.crashes[1].other_vehicle, 0);
  EXPECT_EQ(flight.crashes[0].t, flight.crashes[1].t);
  EXPECT_EQ(flight.crashes[0].surface_class, SurfaceClass::kVehicle);
  // Two discs of 0.15 m radius whose centers pass 0.05 m apart.
  EXPECT_NEAR(flight.crashes[0].speed_mps, 4.0 * std::sqrt(1.0 - std::pow(0.05 / 0.3, 2)), 0.1);
  const Vector3 momentum = 2.0 * flight.state(0).v_world_mps + 3.0 * flight.state(1).v_world_mps;
  EXPECT_NEAR((momentum - Vector3(3, 0, 0)).norm(), 0.0, 1e-6);
  EXPECT_LT(flight.state(0).v_world_mps.x(), 2.0);
}

TEST(Crash, IsIndependentOfAdvanceIntervals) {
  const auto fly = [](double tick_s) {
    PhysicsVehicle vehicle = vehicle_at({0, 0.3, 0});
    vehicle.start.v_world_mps = {4, 1, 0.5};
    vehicle.start.omega_body_radps = {0.3, 0.2, 0.1};
    Flight flight(contact_physics(), {vehicle}, wall_at_2m());
    flight.run(0.6, tick_s);
    return std::pair(flight.crashes.at(0).t, flight.state().p_world_m);
  };
  const auto [t_fine, p_fine] = fly(0.001);
  for (const double tick_s : {0.004, 0.02, 0.1}) {
    const auto [t, p] = fly(tick_s);
    EXPECT_EQ(t, t_fine);
    EXPECT_LT((p - p_fine).norm(), 1e-9);
  }
}

TEST(Crash, RequiresTheCrashSpeedForBodies) {
  for (const double speed_mps : {0.45, 0.55}) {  // 0.5 m/s by default
    PhysicsConfig config = contact_physics();
    config.gravity_world_mps2.setZero();
    PhysicsVehicle vehicle = vehicle_at({0, 0, test_quad().leg_height_m + 0.1});
    vehicle.start.v_world_mps = {0, 0, -speed_mps};
    Flight flight(config, {vehicle}, flat_ground());
    flight.run(0.5);
    EXPECT_EQ(flight.state().crashed, speed_mps > 0.5) << speed_mps;
  }
}

// The other vehicle's propeller turns, the own ones do not: both break.
TEST(Crash, BreaksBothAtATurningPropeller) {
  for (const bool turning : {false, true}) {
    PhysicsConfig config = contact_physics();
    config.motor_lag = true;
    config.gravity_world_mps2.setZero();
    Airframe weak = test_quad();
    weak.thrust_constant_N_per_radps2 = 1e-12;
    weak.rotor_speed_min_radps = 1.0;
    PhysicsVehicle still = vehicle_at({0, 0, 0}, weak, "still"), moving = vehicle_at({1.0, 0, 0}, weak, "moving");
    moving.start.v_world_mps = {-0.3, 0, 0};
    if (turning) moving.start.rotor_speed_radps.fill(200.0);
    Flight flight(config, {still, moving});
    flight.command(1, turning ? command_for(weak, 200.0) : kOff);
    flight.run(2.0);
    EXPECT_EQ(flight.crashes.size(), turning ? 2U : 0U);
    EXPECT_LT(flight.state(0).v_world_mps.x(), -0.05) << "they met";
  }
}

// The ground has no friction, and gravity is slightly oblique in some tests: a vehicle that is not held slides.
PhysicsConfig smooth_ground() {
  PhysicsConfig config = bare_physics();
  config.contacts = true;
  config.contact_friction = config.contact_restitution = 0.0;
  return config;
}

PhysicsVehicle standing(const Airframe& airframe = test_quad()) {
  return vehicle_at({0, 0, airframe.leg_height_m}, airframe);
}

TEST(Rest, IsNotFoundInTheAir) {
  PhysicsConfig config = smooth_ground();
  config.gravity_world_mps2.setZero();
  PhysicsVehicle vehicle = vehicle_at({0, 0, test_quad().leg_height_m + 0.1});
  vehicle.start.v_world_mps = {0.004, 0, 0};
  Flight flight(config, {vehicle}, flat_ground());
  flight.run(1.0);
  EXPECT_NEAR(flight.state().p_world_m.x(), 0.004, 1e-9);
}

TEST(Rest, EndsWhenAnotherVehicleComesNear) {
  PhysicsConfig config = smooth_ground();
  config.gravity_world_mps2 = {0.02, 0, -9.81};
  PhysicsVehicle resting = standing(),
                 coming = vehicle_at({9, 0.1, test_quad().leg_height_m + 1.0}, test_quad(), "coming");
  coming.motors_on = true;
  coming.start.v_world_mps = {-10, 0, 0};
  Flight flight(config, {resting, coming}, flat_ground());
  flight.command(1, command_for(test_quad(), test_quad().hover_rotor_speed_radps()));
  flight.run(0.5);
  const double x_m = flight.state().p_world_m.x();
  EXPECT_EQ(flight.state().v_world_mps.norm(), 0.0);
  flight.run(0.5);
  EXPECT_GT(flight.state().p_world_m.x(), x_m) << "while the other one flew over it";
  EXPECT_FALSE(flight.state().crashed);
}

}  // namespace
}  // namespace swiftlet::sim
