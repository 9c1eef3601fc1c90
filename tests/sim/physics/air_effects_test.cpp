// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/air_effects.hpp"

#include <gtest/gtest.h>

#include "tests/sim/physics/flight.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kAirDensity = 1.225;

Wake hover_wake(const Airframe& airframe) {
  return make_wake(airframe, {0, 0, 0}, Matrix3::Identity(), airframe.mass_kg * kGravity, kAirDensity);
}

TEST(Downwash, InducedSpeedMatchesMomentumTheory) {
  const Airframe airframe = test_quad();
  const Wake wake = hover_wake(airframe);
  const double area = 4 * std::numbers::pi * 0.15 * 0.15;
  const double induced = std::sqrt(2.0 * kGravity / (2 * kAirDensity * area));
  EXPECT_NEAR(wake.induced_mps, induced, 1e-12);
  EXPECT_NEAR(wake.axis_speed_mps(0.0), induced, 1e-12);
  // Developed and hardly spread a disc diameter below: nearly 2 v_i.
  EXPECT_GT(wake.axis_speed_mps(0.6) / induced, 1.5);
  EXPECT_LT(wake.axis_speed_mps(0.6) / induced, 2.0);
}

TEST(Downwash, ConservesThrustMomentumAtEveryDistance) {
  const Airframe airframe = test_quad();
  const Wake wake = hover_wake(airframe);
  for (const double z : {4.0, 8.0, 16.0}) {
    double force = 0.0;
    const double dr = 1e-3;
    for (double r = 0.5 * dr; r < 8.0; r += dr) {
      const double speed = wake.velocity_world_mps({r, 0, -z}).norm();
      force += kAirDensity * speed * speed * 2 * std::numbers::pi * r * dr;
    }
    EXPECT_NEAR(force / (airframe.mass_kg * kGravity), 1.0, 0.01) << z;
  }
}

TEST(Downwash, BlowsDownBelowAndNowhereElse) {
  const Wake wake = hover_wake(test_quad());
  EXPECT_LT(wake.velocity_world_mps({0, 0, -2}).z(), -4.0);
  EXPECT_TRUE(wake.velocity_world_mps({0, 0, 2}).isZero());
  EXPECT_TRUE(wake.velocity_world_mps({3, 0, -2}).isZero());
  EXPECT_TRUE(wake.velocity_world_mps({0, 0, -25}).isZero());
  // A cone: farther down it is slower on the axis and wider.
  EXPECT_LT(wake.velocity_world_mps({0, 0, -10}).norm(), wake.velocity_world_mps({0, 0, -3}).norm());
  EXPECT_GT(wake.velocity_world_mps({1.2, 0, -10}).norm(), wake.velocity_world_mps({1.2, 0, -3}).norm());
  // The wake rotates with the vehicle.
  const Wake tilted =
      make_wake(test_quad(), {0, 0, 0}, Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitY()).toRotationMatrix(),
                20.0, kAirDensity);
  EXPECT_LT(tilted.velocity_world_mps({-2, 0, 0}).x(), -4.0);
}

TEST(Downwash, PushesVehiclesBelowByWakeDrag) {
  PhysicsConfig config = bare_physics();
  config.downwash = true;
  const Airframe airframe = test_quad();
  PhysicsVehicle above = vehicle_at({0, 0, 13}, airframe, "above");
  PhysicsVehicle below = vehicle_at({0.1, 0, 10}, airframe, "below");
  PhysicsVehicle beside = vehicle_at({5, 0, 10}, airframe, "beside");
  above.motors_on = below.motors_on = beside.motors_on = true;
  const double w = hover_wake(airframe).velocity_world_mps({0.1, 0, -3}).norm();
  for (const bool body_drag : {false, true}) {
    config.body_drag = body_drag;
    Flight flight(config, {above, below, beside});
    for (int i = 0; i < 3; ++i) flight.command(i, command_for(airframe, airframe.hover_rotor_speed_radps()));
    flight.run(0.001, 0.001);
    const double force = 0.5 * kAirDensity * airframe.body_drag_area_m2.z() * w * w;
    EXPECT_NEAR(flight.state(1).v_world_mps.z(), -force / airframe.mass_kg * 0.001, 1e-6 * force);
    EXPECT_NEAR(flight.state(0).v_world_mps.z(), 0.0, 1e-15);
    EXPECT_NEAR(flight.state(2).v_world_mps.z(), 0.0, 1e-15);
    EXPECT_GT(force, 0.5);  // newtons: it matters
  }
}

TEST(GroundEffect, FollowsItsCurveAndIsClipped) {
  EXPECT_NEAR(ground_effect_gain(1.0, 0.2, 11.36859), 11.36859 * 0.05 * 0.05, 1e-12);
  EXPECT_NEAR(ground_effect_gain(0.2, 0.2, 1.0), 1.0 / 16.0, 1e-12);  // Cheeseman and Bennett, leading term, h = R
  EXPECT_NEAR(ground_effect_gain(0.01, 0.2, 11.36859), 4.0 / 15.0, 1e-12);
  EXPECT_NEAR(ground_effect_gain(-0.1, 0.2, 11.36859), 4.0 / 15.0, 1e-12);
  // Clipping height of gym-pybullet-drones: h = R / 4 sqrt(15 c / 4).
  const double clip_m = 0.25 * 0.2 * std::sqrt(15.0 * 11.36859 / 4.0);
  EXPECT_NEAR(ground_effect_gain(clip_m, 0.2, 11.36859), 4.0 / 15.0, 1e-12);
  EXPECT_LT(ground_effect_gain(1.01 * clip_m, 0.2, 11.36859), 4.0 / 15.0);
}

TEST(GroundEffect, LiftsHoveringVehiclesByRotorHeight) {
  PhysicsConfig config = bare_physics();
  config.ground_effect = true;
  const Airframe airframe = test_quad();
  for (const double rotor_height : {0.35, 0.6, 1.0, 2.0, 4.0}) {
    PhysicsVehicle vehicle = vehicle_at({0.3, 0.2, rotor_height - 0.05}, airframe);
    vehicle.motors_on = true;
    Flight flight(config, {vehicle}, flat_ground());
    flight.command(0, command_for(airframe, airframe.hover_rotor_speed_radps()));
    flight.run(0.001, 0.001);
    const double reach = kGroundEffectReachRadii * airframe.propeller_radius_m;
    const double gain = rotor_height < reach ? ground_effect_gain(rotor_height, 0.15, 11.36859) : 0.0;
    EXPECT_NEAR(flight.state().v_world_mps.z(), gain * kGravity * 0.001, 1e-8) << rotor_height;
  }
}

TEST(GroundEffect, LiftsOneSideOverTableEdge) {
  PhysicsConfig config = bare_physics();
  config.ground_effect = true;
  TestScene builder;
  builder.add_box({0, -2, 0}, {2, 2, 1}, SurfaceClass::kObject);  // its edge at x = 0, below the center
  const Airframe airframe = test_quad();
  PhysicsVehicle vehicle = vehicle_at({0, 0, 1.4}, airframe);
  vehicle.motors_on = true;
  Flight flight(config, {vehicle}, std::make_shared<StaticScene>(builder.scene()));
  flight.command(0, command_for(airframe, airframe.hover_rotor_speed_radps()));
  flight.run(0.001, 0.001);
  EXPECT_LT(flight.state().omega_body_radps.y(), -1e-4);  // nose up
}

}  // namespace
}  // namespace swiftlet::sim
