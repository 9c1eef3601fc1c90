// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "swiftlet/sim/physics/physics_world.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {

inline constexpr double kGravity = 9.81;

/// An X500-like quadrotor with round numbers.
inline Airframe test_quad() {
  Airframe airframe;
  const double side = airframe.arm_length_m / std::numbers::sqrt2;
  airframe.rotors = {{{side, -side, 0.05}, Rotor::Spin::kCcw},
                     {{-side, side, 0.05}, Rotor::Spin::kCcw},
                     {{side, side, 0.05}, Rotor::Spin::kCw},
                     {{-side, -side, 0.05}, Rotor::Spin::kCw}};
  return airframe;
}

/// Gravity and thrust only: no air, no lag, no obstacles.
inline PhysicsConfig bare_physics() {
  PhysicsConfig config;
  config.motor_lag = config.gyroscopic_torque = config.rotor_drag = config.body_drag = false;
  config.ground_effect = config.downwash = config.contacts = false;
  return config;
}

inline PhysicsVehicle vehicle_at(const Vector3& p_world, const Airframe& airframe = test_quad(),
                                 const std::string& name = "uav1") {
  PhysicsVehicle vehicle{name, airframe, {}, false};
  vehicle.start.p_world_m = p_world;
  return vehicle;
}

/// The command that holds a rotor speed.
inline double command_for(const Airframe& airframe, double speed_radps) {
  return (speed_radps - airframe.rotor_speed_min_radps) /
         (airframe.rotor_speed_max_radps - airframe.rotor_speed_min_radps);
}

inline constexpr double kOff = -1.0;

/// A physics world with its history and commands: Flight f(config, vehicles); f.command(0, 0.5); f.run(1.0).
struct Flight {
  Flight(const PhysicsConfig& config, std::vector<PhysicsVehicle> vehicles,
         std::shared_ptr<const StaticScene> scene = nullptr, const WindConfig& wind = {}, std::uint64_t seed = 1)
      : commands(vehicles.size()),
        history(static_cast<int>(vehicles.size()), 64),
        world(config, wind, std::move(vehicles), std::move(scene), seed) {
    for (auto& command : commands) command.fill(kOff);
  }

  void command(VehicleId vehicle, double u) { commands[vehicle].fill(u); }
  void run(double seconds, double tick_s = 0.004) {
    const TimeNs end = now + from_seconds(seconds);
    while (now < end) {
      now = std::min(now + from_seconds(tick_s), end);
      world.advance(now, commands, history);
      crashes.insert(crashes.end(), world.crashes().begin(), world.crashes().end());
    }
  }
  const VehicleState& state(VehicleId vehicle = 0) const { return world.state(vehicle); }

  TimeNs now = 0;
  std::vector<std::array<double, kMaxRotors>> commands;
  StateHistory history;
  PhysicsWorld world;
  std::vector<Crash> crashes;
};

inline std::shared_ptr<const StaticScene> flat_ground() {
  TestScene builder;
  builder.add_wall({-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0}, SurfaceClass::kGround);
  return std::make_shared<StaticScene>(builder.scene());
}

inline double tilt_rad(const VehicleState& state) {
  return std::acos(std::min(1.0, (state.q_world_body * Vector3::UnitZ()).z()));
}

}  // namespace swiftlet::sim
