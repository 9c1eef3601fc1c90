// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/airframe.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/metrics/metrics_config.hpp"
#include "swiftlet/sim/physics/physics_config.hpp"
#include "swiftlet/sim/radio/radio_config.hpp"
#include "swiftlet/sim/render/render_config.hpp"
#include "swiftlet/sim/world/markers.hpp"

namespace swiftlet::sim {

/// [-] Maximum number of vehicles in a scenario; more are refused.
inline constexpr int kMaxVehicles = 10'000;

struct StartConfig {
  /// World frame; with `above_ground`, z is relative to the surface below
  Eigen::Vector3d position_m = {0.0, 0.0, 2.0};
  bool above_ground = false;
  double yaw_deg = 0.0;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  bool flying = true;                      ///< rotors turn at hover speed at the start
  StartKnown known = StartKnown::kPose;    ///< start state known to the vehicle's software
  Eigen::Vector2d spacing_m = {3.0, 3.0};  ///< distance along x and y between vehicles of a `count`
  int columns = 0;                         ///< vehicles of a `count` per row; 0: all

  void visit(ConfigVisitor& v);
};

struct VehicleConfig {
  std::string name;            ///< unique; empty: uav1, uav2, ...
  int count = 1;               ///< number of copies in a configuration file; 1 after reading, which creates them
  std::string model = "x500";  ///< assets/vehicles/<model>.yaml: airframe and controller gains
  Airframe airframe;
  MarkersConfig markers;
  StartConfig start;
  std::vector<Module> sensors;
  Module agent;
  /// Locations of keys in their file, for messages: "start.position_m" -> "a.yaml:3:9: vehicles[0].start.position_m: ".
  /// Contains keys of the start, the agent and the agent's destinations.
  std::map<std::string, std::string> places;

  VehicleConfig();
  void visit(ConfigVisitor& v);
};

/// Complete description of one run. Default-constructed: valid, one X500 hovering over an empty field.
struct Scenario {
  std::string name = "unnamed";
  std::string description;
  std::uint64_t seed = 1;
  std::uint64_t world_seed = 0;  ///< seed of the world alone; 0: as `seed`
  double duration_s = 10.0;
  double tick_s = 0.004;
  int start_time_s = 0;  ///< added to every recorded time, so that stamps may count from 1970
  PhysicsConfig physics;
  Module world;
  WindConfig wind;
  RadioConfig radio;
  std::vector<VehicleConfig> vehicles;
  std::vector<Module> recorders;
  std::vector<CameraConfig> snapshots;
  std::string snapshots_place = "snapshots: ";  ///< location in the file, for messages: "a.yaml:3:1: snapshots: "
  MetricsConfig metrics;

  Scenario();
  void visit(ConfigVisitor& v);
  std::uint64_t seed_of_world() const { return world_seed != 0 ? world_seed : seed; }
};

/// Reads a scenario, by path or by the name of one that is part of Swiftlet, with its `base:` chain and the overrides
/// ("vehicles[0].start.yaw_deg", "90").
/// Throws InputError.
Scenario load_scenario(const std::filesystem::path& file,
                       const std::vector<std::pair<std::string, std::string>>& overrides = {});
/// Adds an ideal `pose` or `neighbors` sensor to every vehicle without one whose agent needs truth by name
/// (`localization: ground_truth` and the like). No agent gets truth otherwise.
Scenario with_truth_sensors(Scenario scenario);
/// The complete scenario with every default and those sensors; load_scenario() of it gives the same scenario.
std::string write_scenario(const Scenario& scenario);
/// Checks a scenario created in code as if it had been read, and fills in empty names.
/// Throws InputError.
Scenario validated(const Scenario& scenario);

}  // namespace swiftlet::sim
