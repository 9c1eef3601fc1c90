// SPDX-License-Identifier: BSD-3-Clause
// Effects of the world on each vehicle: wind, wake, ground, rest and crashes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/physics/air_effects.hpp"
#include "sim/physics/wind.hpp"
#include "swiftlet/core/math/random.hpp"
#include "tests/sim/physics/flight.hpp"

namespace swiftlet::sim {
namespace {

// Above six radii all rotors use the ground below the center, below that each rotor its own.
TEST(Air, SensesGroundForEachRotor) {
  TestScene builder;
  builder.add_box({0.05F, -9, 0}, {9, 9, 0.05F}, SurfaceClass::kObject);  // a step of 5 cm beside the center
  builder.add_wall({-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}, SurfaceClass::kGround);
  const auto world = std::make_shared<StaticScene>(builder.scene());
  PhysicsConfig config = bare_physics();
  config.ground_effect = true;
  const Airframe airframe = test_quad();
  for (const double radii : {5.7, 6.3}) {
    PhysicsVehicle vehicle = vehicle_at({0, 0, radii * airframe.propeller_radius_m}, airframe);
    vehicle.motors_on = true;
    Flight flight(config, {vehicle}, world);
    flight.command(0, command_for(airframe, airframe.hover_rotor_speed_radps()));
    flight.run(0.001, 0.001);
    EXPECT_EQ(std::abs(flight.state().omega_body_radps.y()) > 1e-7, radii < 6.0) << radii;
  }
}

TEST(Air, WeakensGroundEffectOnTiltedVehicles) {
  PhysicsConfig config = bare_physics();
  config.gravity_mps2.setZero();
  config.ground_effect = true;
  Airframe airframe = test_quad();
  for (Rotor& rotor : airframe.rotors) rotor.position_m.z() = 0.0;
  for (const double tilt : {0.0, 1.0, 1.7}) {
    PhysicsVehicle vehicle = vehicle_at({0, 0, 1.0}, airframe);
    vehicle.start.q_world_body = Eigen::AngleAxisd(tilt, Vector3::UnitX());
    Flight flight(config, {vehicle}, flat_ground());
    const double speed_radps = 400.0, plain_N = airframe.thrust_constant_N_per_radps2 * speed_radps * speed_radps;
    flight.command(0, command_for(airframe, speed_radps));
    flight.run(0.001, 0.001);
    double thrust_N = 0.0;
    for (const Rotor& rotor : airframe.rotors) {
      const double height_m = 1.0 + (vehicle.start.q_world_body * rotor.position_m).z();
      const double gain = std::cos(tilt) > 0.0
                              ? std::cos(tilt) * ground_effect_gain(height_m, airframe.propeller_radius_m,
                                                                    config.ground_effect_coefficient)
                              : 0.0;
      thrust_N += plain_N * (1.0 + gain);
    }
    EXPECT_NEAR(flight.state().v_world_mps.norm(), 0.001 * thrust_N / airframe.mass_kg, 1e-7) << tilt;
  }
}

// A propeller turns from 10 rad/s on.
TEST(Crash, AlmostStandingPropellersBreakNothing) {
  for (const double speed_radps : {9.0, 11.0}) {
    PhysicsConfig config = bare_physics();
    config.contacts = true;
    config.motor_lag = true;
    config.gravity_mps2.setZero();
    Airframe weak = test_quad();
    weak.thrust_constant_N_per_radps2 = 1e-12;
    weak.rotor_speed_min_radps = 1.0;
    PhysicsVehicle vehicle = vehicle_at({1.55, 0, 0}, weak);
    vehicle.start.v_world_mps = {0.2, 0, 0};
    vehicle.start.rotor_speed_radps.fill(speed_radps);
    TestScene builder;
    builder.add_box({2, -5, -5}, {2.2F, 5, 5}, SurfaceClass::kPillar, 7);
    Flight flight(config, {vehicle}, std::make_shared<StaticScene>(builder.scene()));
    flight.command(0, command_for(weak, speed_radps));
    flight.run(1.5);
    EXPECT_EQ(flight.state().crashed, speed_radps > 10.0) << speed_radps;
    EXPECT_LT(flight.state().v_world_mps.x(), 0.05) << "it met the wall";
  }
}

TEST(Crash, RequiresTheCrashSpeedForBodies) {
  for (const double speed_mps : {0.45, 0.55}) {  // 0.5 m/s by default
    PhysicsConfig config = bare_physics();
    config.contacts = true;
    config.gravity_mps2.setZero();
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
    PhysicsConfig config = bare_physics();
    config.contacts = true;
    config.motor_lag = true;
    config.gravity_mps2.setZero();
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

TEST(Start, RunningMotorsHoldTheVehicle) {
  PhysicsVehicle on = vehicle_at({0, 0, 5}), off = vehicle_at({0, 0, 5});
  on.motors_on = true;
  on.start.q_world_body.coeffs() *= 2.0;
  Flight flying(PhysicsConfig{}, {on}), standing(PhysicsConfig{}, {off});
  for (std::size_t i = 0; i < kMaxRotors; ++i) {
    const double hover_radps = i < 4 ? test_quad().hover_rotor_speed_radps() : 0.0;
    EXPECT_DOUBLE_EQ(flying.state().rotor_speed_radps[i], hover_radps);
    EXPECT_EQ(standing.state().rotor_speed_radps[i], 0.0);
  }
  EXPECT_NEAR(flying.state().q_world_body.norm(), 1.0, 1e-12);
  Airframe heavy = test_quad();
  heavy.mass_kg = 100.0;
  PhysicsVehicle too_heavy = vehicle_at({0, 0, 5}, heavy);
  too_heavy.motors_on = true;
  EXPECT_DOUBLE_EQ(Flight(PhysicsConfig{}, {too_heavy}).state().rotor_speed_radps[0], heavy.rotor_speed_max_radps);
}

// Every pair, and every surface, at any distance.
TEST(Clearance, IsThatOfAllVehiclePairs) {
  const Random random(4, "clearance");
  std::vector<PhysicsVehicle> vehicles;
  for (std::uint32_t i = 0; i < 24; ++i) {
    Airframe airframe = test_quad();
    airframe.propeller_radius_m = 0.05 + 0.2 * random.uniform(i, 0);
    vehicles.push_back(
        vehicle_at({12.0 * random.uniform(i, 1), 12.0 * random.uniform(i, 2), 20.0 + 12.0 * random.uniform(i, 3)},
                   airframe, "uav" + std::to_string(i)));
    const auto n = random.normal3(i, 4);
    vehicles.back().start.v_world_mps = 3.0 * Vector3(n[0], n[1], 0.3 * n[2]);
  }
  PhysicsConfig config = bare_physics();
  config.gravity_mps2 = {0, 0, -1.0};
  Flight flight(config, vehicles, flat_ground());
  for (int k = 0; k < 60; ++k) {
    flight.run(0.05);
    for (VehicleId i = 0; i < 24; ++i) {
      const double radius_m = vehicles[static_cast<std::size_t>(i)].airframe.circumscribed_radius_m();
      double nearest_m = std::numeric_limits<double>::infinity();
      VehicleId nearest = kNoVehicle;
      for (VehicleId j = 0; j < 24; ++j) {
        const double gap_m = (flight.state(i).p_world_m - flight.state(j).p_world_m).norm() - radius_m -
                             vehicles[static_cast<std::size_t>(j)].airframe.circumscribed_radius_m();
        if (j != i && gap_m < nearest_m) nearest_m = gap_m, nearest = j;
      }
      const double most_m = 5.0 + k % 7 * 4.0;
      const Clearance clearance = flight.world.clearance(i, most_m);
      EXPECT_NEAR(clearance.vehicle_m, nearest_m, 1e-9);
      EXPECT_EQ(clearance.nearest_vehicle, nearest);
      EXPECT_NEAR(clearance.surface_m, std::min(flight.state(i).p_world_m.z() - radius_m, most_m), 1e-4) << k;
    }
  }
}

TEST(Arguments, RefuseStepsOfZeroDuration) {
  PhysicsConfig config = bare_physics();
  config.step_s = 1e-10;
  EXPECT_THROW(Flight(config, {vehicle_at({0, 0, 0})}), std::invalid_argument);
  Airframe eight = test_quad();
  eight.rotors.resize(8, {{0.1, 0.1, 0.0}, Rotor::Spin::kCw});
  EXPECT_NO_THROW(Flight(bare_physics(), {vehicle_at({0, 0, 0}, eight)}));
}

}  // namespace
}  // namespace swiftlet::sim
