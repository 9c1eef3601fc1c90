// SPDX-License-Identifier: BSD-3-Clause
// When a vehicle is taken to stand still, and what rouses it. The ground has no friction, and gravity is a little
// oblique where something is to be seen: who is not held slides.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/physics/flight.hpp"

namespace swiftlet::sim {
namespace {

PhysicsConfig smooth_ground() {
  PhysicsConfig config = bare_physics();
  config.contacts = true;
  config.contact_friction = config.contact_restitution = 0.0;
  return config;
}

PhysicsVehicle standing(const Airframe& airframe = test_quad()) {
  return vehicle_at({0, 0, airframe.leg_height_m}, airframe);
}

TEST(Rest, BeginsBelowACentimeterASecondAndThirtyMilliradians) {
  for (const double speed_mps : {0.009, 0.011}) {
    PhysicsVehicle vehicle = standing();
    vehicle.start.v_world_mps = {speed_mps, 0, 0};
    Flight flight(smooth_ground(), {vehicle}, flat_ground());
    flight.run(1.0);
    EXPECT_EQ(flight.state().v_world_mps.x() == 0.0, speed_mps < 0.01) << speed_mps;
  }
  for (const double rate_radps : {0.027, 0.033}) {
    PhysicsVehicle vehicle = standing();
    vehicle.start.omega_body_radps = {0, 0, rate_radps};
    Flight flight(smooth_ground(), {vehicle}, flat_ground());
    flight.run(1.0);
    EXPECT_EQ(flight.state().omega_body_radps.z() == 0.0, rate_radps < 0.03) << rate_radps;
  }
}

TEST(Rest, BeginsAfterAQuarterOfASecond) {
  PhysicsVehicle vehicle = standing();
  vehicle.start.v_world_mps = {0.005, 0, 0};
  Flight flight(smooth_ground(), {vehicle}, flat_ground());
  flight.run(0.24, 0.001);
  EXPECT_GT(flight.state().v_world_mps.x(), 0.0);
  flight.run(0.03, 0.001);
  EXPECT_EQ(flight.state().v_world_mps.x(), 0.0);
  EXPECT_TRUE(flight.world.in_contact(0));
}

TEST(Rest, IsNotFoundInTheAir) {
  PhysicsConfig config = smooth_ground();
  config.gravity_mps2.setZero();
  PhysicsVehicle vehicle = vehicle_at({0, 0, test_quad().leg_height_m + 0.1});
  vehicle.start.v_world_mps = {0.004, 0, 0};
  Flight flight(config, {vehicle}, flat_ground());
  flight.run(1.0);
  EXPECT_NEAR(flight.state().p_world_m.x(), 0.004, 1e-9);
}

/// How far it has slid within half a second after its rotors were told other speeds.
double slid_m(const std::array<double, 4>& before_radps, const std::array<double, 4>& after_radps) {
  PhysicsConfig config = smooth_ground();
  config.gravity_mps2 = {0.02, 0, -9.81};
  const Airframe airframe = test_quad();
  Flight flight(config, {standing(airframe)}, flat_ground());
  const auto tell = [&](const std::array<double, 4>& speeds) {
    for (std::size_t i = 0; i < 4; ++i) flight.commands[0][i] = command_for(airframe, speeds[i]);
  };
  tell(before_radps);
  flight.run(0.6);
  EXPECT_EQ(flight.state().v_world_mps.norm(), 0.0) << "it rests";
  const double x_m = flight.state().p_world_m.x();
  flight.run(0.2);
  EXPECT_EQ(flight.state().p_world_m.x(), x_m) << "and stays";
  tell(after_radps);
  flight.run(0.5);
  return flight.state().p_world_m.x() - x_m;
}

TEST(Rest, EndsWhenTheForceChangesByATenthOfAMeterASecondSquared) {
  const Airframe airframe = test_quad();
  const double low = airframe.rotor_speed_min_radps + 1.0;
  for (const double change_mps2 : {0.09, 0.11}) {
    const double square = low * low + change_mps2 * airframe.mass_kg / (4.0 * airframe.thrust_constant_N_per_radps2);
    const double high = std::sqrt(square);
    const double way_m = slid_m({low, low, low, low}, {high, high, high, high});
    EXPECT_EQ(way_m > 1e-4, change_mps2 > 0.1) << way_m;
  }
}

// Two rotors up and two down: a torque about the vertical without any force.
TEST(Rest, EndsWhenTheTorqueChangesByHalfARadianASecondSquared) {
  const Airframe airframe = test_quad();
  const double low = airframe.rotor_speed_min_radps + 100.0;
  for (const double change_radps2 : {0.45, 0.55}) {
    const double torque_Nm = change_radps2 * airframe.inertia_diagonal_kgm2.z();
    const double square = torque_Nm / (4.0 * airframe.torque_to_thrust_m * airframe.thrust_constant_N_per_radps2);
    std::array<double, 4> after{};
    for (std::size_t i = 0; i < 4; ++i)
      after[i] = std::sqrt(low * low + (airframe.rotors[i].spin == Rotor::Spin::kCcw ? square : -square));
    const double way_m = slid_m({low, low, low, low}, after);
    EXPECT_EQ(way_m > 1e-4, change_radps2 > 0.5) << way_m;
  }
}

TEST(Rest, EndsWhenAnotherVehicleComesNear) {
  PhysicsConfig config = smooth_ground();
  config.gravity_mps2 = {0.02, 0, -9.81};
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

// A surface gives back the speed of what comes at more than 0.1 m/s.
TEST(Bounce, WhatComesSlowlyDoesNotBounce) {
  for (const double speed_mps : {0.09, 0.12}) {
    PhysicsConfig config = smooth_ground();
    config.contact_restitution = 1.0;
    config.gravity_mps2.setZero();
    PhysicsVehicle vehicle = vehicle_at({0, 0, test_quad().leg_height_m + 0.02});
    vehicle.start.v_world_mps = {0, 0, -speed_mps};
    Flight flight(config, {vehicle}, flat_ground());
    flight.run(0.4);
    EXPECT_NEAR(flight.state().v_world_mps.z(), speed_mps > 0.1 ? speed_mps : 0.0, 0.01) << speed_mps;
  }
}

}  // namespace
}  // namespace swiftlet::sim
