// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/build.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "sim/run/prior_map.hpp"
#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/slam/slam.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/physics/free_places.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/scenario/named_files.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"
#include "swiftlet/sim/slam_map/slam_map_file.hpp"

namespace swiftlet::sim {
namespace {

constexpr const char* kStart = "start.position_m";

/// Prefix of an error message about a key of a vehicle.
std::string place_of(const VehicleConfig& vehicle, const std::string& key) {
  const auto known = vehicle.places.find(key);
  return known != vehicle.places.end() ? known->second : "vehicles: " + vehicle.name + ": " + key + ": ";
}

/// A resolution of centimeters suffices for start positions.
std::string meters(double value) { return fmt::format("{:.2f} m", value); }

// Height of the ground or floor at (x, y): the first such surface on a ray from above, ignoring crowns and roofs.
double ground_height_m(const StaticScene& world, const VehicleConfig& vehicle) {
  const Vector3 at = vehicle.start.position_m;
  const double top_m = world.bounds_m().max().z() + 1.0;
  const double bottom_m = world.bounds_m().min().z() - 1.0;
  for (double z = top_m; z > bottom_m;) {
    const RayHit hit = world.trace({at.x(), at.y(), z}, -Vector3::UnitZ(), z - bottom_m);
    if (hit.range_m <= 0.0F) break;
    z -= hit.range_m;
    if (hit.surface_class == SurfaceClass::kGround) return z;
    z -= 1e-3;
  }
  throw InputError(place_of(vehicle, kStart) + "expected ground below the start of " + vehicle.name +
                   " (above_ground), found none at x " + meters(at.x()) + ", y " + meters(at.y()));
}

VehicleState start_state(const VehicleConfig& vehicle, const StaticScene& world) {
  VehicleState state;
  state.p_world_m = vehicle.start.position_m;
  if (vehicle.start.above_ground) state.p_world_m.z() += ground_height_m(world, vehicle);
  state.q_world_body = Eigen::AngleAxisd(vehicle.start.yaw_deg * kRadPerDeg, Vector3::UnitZ());
  state.v_world_mps = vehicle.start.velocity_mps;
  return state;
}

void require_apart(const Scenario& scenario, const std::vector<PhysicsVehicle>& vehicles) {
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double distance_m = (vehicles[i].start.p_world_m - vehicles[j].start.p_world_m).norm();
      const double least_m =
          vehicles[i].airframe.circumscribed_radius_m() + vehicles[j].airframe.circumscribed_radius_m();
      if (distance_m >= least_m) continue;
      throw InputError(place_of(scenario.vehicles[i], kStart) + "expected " + vehicles[i].name + " at least " +
                       meters(least_m) + " from " + vehicles[j].name + ", found " + meters(distance_m));
    }
  }
}

void require_room(const Scenario& scenario, const std::vector<PhysicsVehicle>& vehicles, const StaticScene& world) {
  if (!scenario.physics.contacts) return;  // without contacts there are no obstacles
  FreePlaces places(vehicles, scenario.physics, world);
  // `ground_m`: ground height if the z of a key is relative to it.
  const auto require = [&](std::size_t i, const std::string& key, const Vector3& p_world_m,
                           std::optional<double> ground_m) {
    const auto problem = places.check(i, p_world_m);
    if (!problem) return;
    const std::string surface(name_of(problem->surface_class));
    const std::string found = problem->depth_m > 0.0 ? surface + " in its place" : "a position below the ground";
    // Rounded up, so that the reported height is collision-free.
    const double least_z_m = std::ceil((problem->free_z_m - ground_m.value_or(0.0)) * 100.0 - 0.2) / 100.0;
    throw InputError(place_of(scenario.vehicles[i], key) + "expected room for " + vehicles[i].name + ", found " +
                     found + "; there is room from z = " + meters(least_z_m) + " upwards" +
                     (ground_m ? " (above the ground)" : ""));
  };
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    const StartConfig& start = scenario.vehicles[i].start;
    const Vector3& p_world_m = vehicles[i].start.p_world_m;
    std::optional<double> ground_m;
    if (start.above_ground) ground_m = p_world_m.z() - start.position_m.z();
    require(i, kStart, p_world_m, ground_m);
    if (start.known != StartKnown::kPose) continue;  // the vehicle's estimated world frame differs from the true one
    for (const NamedPlace& place : destinations_of(scenario.vehicles[i])) require(i, place.key, place.p_world_m, {});
  }
}

/// The start pose known to the vehicle; zero for unknown parts.
Pose known_start(const StartConfig& start, const VehicleState& truth) {
  if (start.known == StartKnown::kPose) return truth.T_world_body();
  Pose known = Pose::Identity();
  if (start.known == StartKnown::kPosition) known.translation() = truth.p_world_m;
  return known;
}

std::shared_ptr<const PriorMap> prior_map(const VehicleConfig& vehicle, std::size_t i, const Scene& world) {
  const AgentNeeds needs = needs_of(vehicle.agent);
  auto prior = make_prior_map(needs.prior, needs.prior_voxel_m, world,
                              "vehicles[" + std::to_string(i) + "].agent.detector.prior");
  if (prior != nullptr && vehicle.start.known != StartKnown::kPose) {
    throw InputError("vehicles: " + vehicle.name + ": start.known: expected pose, because the vehicle has a map of " +
                     "the world (prior), found " +
                     std::string(vehicle.start.known == StartKnown::kPosition ? "position" : "nothing"));
  }
  return prior;
}

/// The agent's configuration with the estimator's map for localization, loaded from its file.
Module with_loaded_map(const Module& agent) {
  Module loaded = agent;
  auto* stack = dynamic_cast<StackConfig*>(loaded.config.get());
  auto* slam = stack != nullptr ? dynamic_cast<SlamConfig*>(stack->localization.config.get()) : nullptr;
  if (slam == nullptr || slam->global.map.empty()) return loaded;
  if (!slam->global.enabled) {
    throw InputError(
        "localization.global.enabled: expected true, because the vehicle localizes itself in a map, found false");
  }
  try {
    slam->global.loaded_map = std::make_shared<const SavedMap>(read_slam_map(slam->global.map));
  } catch (const InputError& problem) {
    throw InputError(std::string("localization.global.map: ") + problem.what());
  }
  return loaded;
}

void require_sensors(const VehicleConfig& vehicle) {
  const std::vector<std::string> names = sensor_names(vehicle.sensors);
  for (const SensorNeed& need : needs_of(vehicle.agent).sensors) {
    std::vector<std::string> carried;  // sensors of the required type
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (vehicle.sensors[i].type == need.type) carried.push_back(names[i]);
    }
    if (carried.empty()) {
      throw std::invalid_argument(need.required_by + ": expected a sensor of type " + need.type + " on " +
                                  vehicle.name + ", found none");
    }
    if (need.name.empty() || std::find(carried.begin(), carried.end(), need.name) != carried.end()) continue;
    throw std::invalid_argument(need.required_by + ": expected the name of a sensor of type " + need.type + " on " +
                                vehicle.name + ", found \"" + need.name + "\"" + did_you_mean(need.name, carried));
  }
}

}  // namespace

World build_world(const Module& config, std::uint64_t seed) {
  auto scene = std::make_shared<const Scene>(make_world(config, seed));
  return {scene, std::make_shared<const StaticScene>(*scene)};
}

std::vector<std::string> vehicle_names(const Scenario& scenario) {
  std::vector<std::string> names;
  for (const VehicleConfig& vehicle : scenario.vehicles) names.push_back(vehicle.name);
  return names;
}

RunInfo make_run_info(const Scenario& scenario, const World& world) {
  RunInfo info;
  info.scenario = scenario.name;
  info.scene = world.scene.get();
  info.static_scene = world.static_scene;
  info.vehicle_names = vehicle_names(scenario);
  info.start_time = scenario.start_time_s * kNsPerSecond;
  for (const VehicleConfig& vehicle : scenario.vehicles) {
    info.airframes.push_back(&vehicle.airframe);
    info.vehicle_shapes.push_back(
        std::make_shared<const VehicleShape>(make_vehicle_shape(vehicle.airframe, vehicle.markers)));
  }
  return info;
}

std::vector<PhysicsVehicle> make_physics_vehicles(const Scenario& scenario, const StaticScene& world) {
  std::vector<PhysicsVehicle> vehicles;
  for (const VehicleConfig& vehicle : scenario.vehicles) {
    vehicles.push_back({vehicle.name, vehicle.airframe, start_state(vehicle, world), vehicle.start.flying});
  }
  require_apart(scenario, vehicles);
  require_room(scenario, vehicles, world);
  return vehicles;
}

std::vector<std::vector<std::unique_ptr<Sensor>>> make_sensors(
    const Scenario& scenario, const World& world, const std::vector<std::shared_ptr<const VehicleShape>>& shapes) {
  std::vector<std::vector<std::unique_ptr<Sensor>>> sensors(scenario.vehicles.size());
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    const VehicleConfig& vehicle = scenario.vehicles[i];
    for (const Module& module : vehicle.sensors) {
      SensorSetup setup;
      setup.seed = scenario.seed;
      setup.vehicle = static_cast<VehicleId>(i);
      setup.name = dynamic_cast<const SensorConfig&>(*module.config).name;
      if (setup.name.empty()) setup.name = module.type;
      setup.entity = vehicle.name + "/" + setup.name;
      setup.world = world.static_scene;
      setup.scene = world.scene;
      setup.vehicle_shapes = shapes;
      setup.vehicle_names = vehicle_names(scenario);
      sensors[i].push_back(make_sensor(module, std::move(setup)));
    }
  }
  return sensors;
}

std::vector<Perception> perception_of(const Scenario& scenario) {
  std::vector<Perception> perception;
  for (const VehicleConfig& vehicle : scenario.vehicles) {
    const AgentNeeds needs = needs_of(vehicle.agent);
    perception.push_back({needs.detects, needs.tracks, needs.net, needs.captures});
  }
  return perception;
}

std::vector<std::unique_ptr<Agent>> make_agents(const Scenario& scenario, const std::vector<PhysicsVehicle>& vehicles,
                                                const Scene& world) {
  std::vector<std::unique_ptr<Agent>> agents;
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    AgentSetup setup;
    setup.self = static_cast<VehicleId>(i);
    setup.num_vehicles = static_cast<int>(scenario.vehicles.size());
    setup.vehicle_names = vehicle_names(scenario);
    setup.airframe = scenario.vehicles[i].airframe;
    setup.start_known = scenario.vehicles[i].start.known;
    setup.T_local_body_start = known_start(scenario.vehicles[i].start, vehicles[i].start);
    setup.tick_s = scenario.tick_s;
    setup.prior_map = prior_map(scenario.vehicles[i], i, world);
    for (const Module& sensor : scenario.vehicles[i].sensors) {
      dynamic_cast<const SensorConfig&>(*sensor.config).describe(setup);
    }
    try {
      require_sensors(scenario.vehicles[i]);
      agents.push_back(make_agent(with_loaded_map(scenario.vehicles[i].agent), setup));
    } catch (const std::invalid_argument& problem) {
      throw InputError(place_of(scenario.vehicles[i], "agent") + problem.what());
    } catch (const InputError& problem) {
      throw InputError(place_of(scenario.vehicles[i], "agent") + problem.what());
    }
  }
  return agents;
}

}  // namespace swiftlet::sim
