// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/dataset/flight.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/dataset/flight_plan.hpp"
#include "sim/dataset/free_space.hpp"
#include "sim/dataset/hash.hpp"
#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/guidance/timed_path.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"
#include "swiftlet/sim/dataset/sequence_info.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/run/version.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {
namespace {

// [-] Bounds of a drawn reflectivity.
constexpr float kDarkest = 0.02F, kBrightest = 0.98F;

int draw_family(const std::vector<FamilyConfig>& families, std::uint64_t seed) {
  double sum = 0.0;
  for (const FamilyConfig& family : families) sum += family.weight;
  double place = sum * Random(seed, "dataset.family").uniform(0, 0);
  for (std::size_t i = 0; i + 1 < families.size(); ++i) {
    place -= families[i].weight;
    if (place < 0.0) return static_cast<int>(i);
  }
  return static_cast<int>(families.size()) - 1;
}

int draw_team(const FamilyConfig& family, int all, std::uint64_t seed) {
  if (family.vehicles_min <= 0 || family.vehicles_min >= all) return all;
  const double u = Random(seed, "dataset.team").uniform(0, 0);
  return family.vehicles_min + static_cast<int>(u * (all - family.vehicles_min + 1));
}

std::vector<double> draw_reflectivities(const Scene& scene, double spread, std::uint64_t seed, int attempt) {
  const Random random(seed, "dataset.reflectivity");
  std::vector<double> drawn;
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const double factor =
        elementary::exp(spread * random.normal(static_cast<std::uint32_t>(attempt), static_cast<std::uint32_t>(i)));
    const auto reflectivity = static_cast<float>(scene.materials[i].reflectivity * factor);
    drawn.push_back(static_cast<double>(std::clamp(reflectivity, kDarkest, kBrightest)));
  }
  return drawn;
}

World with_reflectivities(Scene scene, const std::vector<double>& reflectivities) {
  if (!reflectivities.empty() && reflectivities.size() != scene.materials.size()) {
    throw std::runtime_error("expected " + std::to_string(reflectivities.size()) +
                             " materials, as when the dataset was made, found a world of " +
                             std::to_string(scene.materials.size()));
  }
  for (std::size_t i = 0; i < reflectivities.size(); ++i) {
    scene.materials[i].reflectivity = static_cast<float>(reflectivities[i]);
  }
  auto shared = std::make_shared<const Scene>(std::move(scene));
  return {shared, std::make_shared<const StaticScene>(*shared)};
}

void fly(Scenario& scenario, const std::vector<SplineTrajectory>& paths) {
  for (std::size_t i = 0; i < paths.size(); ++i) {
    VehicleConfig& vehicle = scenario.vehicles[i];
    Module* guidance = guidance_of(vehicle.agent);
    if (guidance == nullptr) {
      throw InputError("vehicles[" + std::to_string(i) +
                       "].agent: expected an agent whose guidance a dataset can replace, such as stack, found " +
                       vehicle.agent.type);
    }
    const StartKnown known = vehicle.start.known;
    vehicle.start = StartConfig();
    vehicle.places.erase("start.position_m");  // its location in the file is of another value
    vehicle.start.known = known;
    vehicle.start.position_m = paths[i].control_points_m.front();
    vehicle.start.yaw_deg = degrees(paths[i].yaw_rad);
    *guidance = Module(guidance_module_types(), "timed_path");
    guidance->as<TimedPathConfig>().points_m = paths[i].control_points_m;
    guidance->as<TimedPathConfig>().interval_s = paths[i].interval_s;
  }
}

std::vector<std::pair<std::string, std::string>> overrides_of(const FamilyConfig& family, const Flight& flight,
                                                              int attempt) {
  auto overrides = draw_overrides(family, flight.num_vehicles, flight.seed, attempt);
  overrides.emplace_back("seed", std::to_string(flight.seed));
  return overrides;
}

}  // namespace

std::vector<LidarOfTeam> lidars_of(const Scenario& scenario) {
  std::vector<LidarOfTeam> lidars;
  for (std::size_t v = 0; v < scenario.vehicles.size(); ++v) {
    for (const Module& sensor : scenario.vehicles[v].sensors) {
      if (sensor.type != "lidar") continue;
      lidars.push_back({static_cast<VehicleId>(v), dynamic_cast<const SensorConfig&>(*sensor.config).name});
    }
  }
  return lidars;
}

DatasetPlan plan_dataset(const DatasetConfig& config) {
  DatasetPlan plan;
  plan.config = config;
  std::string content = std::string(version()) + "\n";
  DatasetConfig portable = config;  // scenarios contribute their content, not their location
  std::vector<Scenario> scenarios;
  for (std::size_t i = 0; i < config.families.size(); ++i) {
    const FamilyConfig& family = config.families[i];
    scenarios.push_back(load_scenario(family.scenario));
    content += write_scenario(scenarios.back());
    portable.families[i].scenario = "scenario.yaml";
    if (lidars_of(scenarios.back()).empty()) {
      throw InputError("families[" + std::to_string(i) + "].scenario: expected a vehicle with a lidar, found none in " +
                       family.scenario);
    }
    // Detects keys that are missing in a scenario now instead of after an hour.
    const int all = static_cast<int>(scenarios.back().vehicles.size());
    if (family.vehicles_min > all) {
      throw InputError("families[" + std::to_string(i) + "].vehicles_min: expected at most " + std::to_string(all) +
                       ", the vehicles of " + family.scenario + ", found " + std::to_string(family.vehicles_min));
    }
    try {
      (void)load_scenario(family.scenario, draw_overrides(family, all, 0, 0));
    } catch (const InputError& error) {
      throw InputError("families[" + std::to_string(i) + "].vary: " + error.what());
    }
  }
  content += write_dataset(portable);
  plan.fingerprint = hex(hash_of(content));

  int sequence = 0;
  for (const SplitConfig& split : config.splits) {
    for (int k = 0; k < split.flights; ++k) {
      Flight flight;
      flight.number = static_cast<int>(plan.flights.size());
      flight.split = split.name;
      flight.seed = split.first_seed + static_cast<std::uint64_t>(k);
      flight.family = draw_family(config.families, flight.seed);
      const FamilyConfig& family = config.families[static_cast<std::size_t>(flight.family)];
      Scenario team = scenarios[static_cast<std::size_t>(flight.family)];
      flight.num_vehicles = draw_team(family, static_cast<int>(team.vehicles.size()), flight.seed);
      team.vehicles.resize(static_cast<std::size_t>(flight.num_vehicles));
      flight.first_sequence = sequence;
      flight.num_sequences = static_cast<int>(lidars_of(team).size());
      flight.pictures = k < config.pictures.flights_per_split;
      sequence += flight.num_sequences;
      plan.flights.push_back(flight);
    }
  }
  return plan;
}

World make_flight_world(const Scenario& scenario, const std::vector<double>& reflectivities) {
  return with_reflectivities(make_world(scenario.world, scenario.seed), reflectivities);
}

PreparedFlight prepare_flight(const DatasetPlan& plan, const Flight& flight, int attempt) {
  const FamilyConfig& family = plan.config.families[static_cast<std::size_t>(flight.family)];
  PreparedFlight prepared;
  Scenario& scenario = prepared.scenario;
  scenario = load_scenario(family.scenario, overrides_of(family, flight, attempt));
  scenario.vehicles.resize(static_cast<std::size_t>(flight.num_vehicles));
  scenario.name = plan.config.name + "_" + sequence_name(flight.first_sequence);
  scenario.recorders.clear();
  if (!plan.config.content.snapshots) scenario.snapshots.clear();
  if (flight.pictures) {
    const auto& cameras = plan.config.pictures.cameras;
    scenario.snapshots.insert(scenario.snapshots.end(), cameras.begin(), cameras.end());
  }
  scenario.start_time_s = 0;  // times of all files of a sequence count from its start
  scenario.metrics.stop_on_crash = true;
  scenario.metrics.stop_when_done = false;

  Scene scene = make_world(scenario.world, scenario.seed);
  prepared.reflectivities = draw_reflectivities(scene, family.reflectivity_spread, flight.seed, attempt);
  prepared.world = with_reflectivities(std::move(scene), prepared.reflectivities);

  const StaticScene& world = *prepared.world.static_scene;
  prepared.has_interior = enclosed_share(world, family.flight.height_min_m) > 0.0;

  std::vector<double> radii_m;
  for (const VehicleConfig& vehicle : scenario.vehicles) radii_m.push_back(vehicle.airframe.circumscribed_radius_m());
  const auto paths =
      plan_flight(family.flight, prepared.world.static_scene, radii_m, scenario.duration_s, flight.seed, attempt);
  if (!paths) {
    throw NoPathFound(
        "no free paths for " + std::to_string(radii_m.size()) + " vehicles were found" +
        (stays_indoors(family.flight, world) ? " inside walls; flight.indoors: false flies outside, too" : ""));
  }
  fly(scenario, *paths);
  scenario = validated(scenario);
  return prepared;
}

}  // namespace swiftlet::sim
