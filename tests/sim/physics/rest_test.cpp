// SPDX-License-Identifier: BSD-3-Clause
// Conditions for a vehicle at rest, and events that wake it. The ground has no friction, and gravity is slightly
// oblique in some tests: a vehicle that is not held slides.
#include <gtest/gtest.h>

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

TEST(Rest, BeginsAfterQuarterSecond) {
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
