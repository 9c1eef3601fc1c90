// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "crossing.hpp"
#include "experiments.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/guidance/waypoints.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/stages/guidances.hpp"
#include "swiftlet/sim/plot/plot.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kHeight_m = 8.0;
constexpr double kEncumbrances_m = 1.0;  // the sum of two encumbrances

/// The vehicle of the document's crossing with the settings that rbl has by itself.
sim::Scenario pattern_of(std::uint64_t seed) {
  sim::Scenario pattern = scenario_with("reproduce/rbl_crossing.yaml", seed);
  pattern.metrics.stop_on_crash = true;
  pattern.duration_s = 60.0;
  RblConfig rbl;
  rbl.cells.step_m = 0.35;
  rbl.z_max_m = 2.0 * kHeight_m;
  pattern.vehicles.front().agent.as<StackConfig>().guidance.as<RblConfig>() = rbl;
  return pattern;
}

sim::NeighborsConfig& sight(sim::VehicleConfig& vehicle) { return vehicle.sensors.front().as<sim::NeighborsConfig>(); }
RblConfig& rbl_of(sim::VehicleConfig& vehicle) { return vehicle.agent.as<StackConfig>().guidance.as<RblConfig>(); }

/// Somebody who goes nobody's way: it stands where it is, or flies straight on whatever comes.
sim::VehicleConfig stranger(const sim::VehicleConfig& pattern, const std::string& name, const Vector3& from_m,
                            const Vector3& to_m, double speed_mps) {
  sim::VehicleConfig vehicle = pattern;
  vehicle.name = name;
  vehicle.start.position_m = from_m;
  Module& guidance = vehicle.agent.as<StackConfig>().guidance;
  if (speed_mps > 0.0) {
    guidance = Module(guidance_module_types(), "waypoints");
    guidance.as<WaypointsConfig>().waypoints_m = {to_m};
    guidance.as<WaypointsConfig>().speed_mps = speed_mps;
  } else {
    guidance = Module(guidance_module_types(), "hover");
  }
  return vehicle;
}

// --- what broke the document's cells ---

struct Case {
  const char* name;
  void (*set)(sim::VehicleConfig& pattern);                       // of every vehicle
  void (*change)(sim::Scenario& scenario, const Random& random);  // of the finished scene
  Formation formation = {};
};

void nothing(sim::VehicleConfig&) {}
void leave(sim::Scenario&, const Random&) {}

void occupy_goal(sim::Scenario& scenario, const Random&) {
  sim::VehicleConfig& vehicle = scenario.vehicles[5];
  vehicle = stranger(vehicle, vehicle.name, vehicle.start.position_m, {}, 0.0);
}

void intrude(sim::Scenario& scenario, const Random& random) {
  const double azimuth_rad = random.uniform(0.0, 2.0 * kPi, 0, 0), side_m = random.uniform(-2.0, 2.0, 0, 1);
  const double meeting_s = random.uniform(2.0, 8.0, 0, 2);
  const Vector3 ahead(std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0);
  const Vector3 across(-ahead.y(), ahead.x(), 0.0);
  const Vector3 middle = side_m * across + Vector3(0.0, 0.0, kHeight_m);
  scenario.vehicles.push_back(stranger(scenario.vehicles.front(), "intruder", middle - (20.0 + 4.0 * meeting_s) * ahead,
                                       middle + 30.0 * ahead, 4.0));
}

void swap_heights(sim::Scenario& scenario, const Random& random) {
  scenario.vehicles.resize(2);
  for (int i = 0; i < 2; ++i) {
    const double side = i == 0 ? -1.0 : 1.0;
    const Vector3 around(random.uniform(-0.1, 0.1, 0, 2U * i), random.uniform(-0.1, 0.1, 0, 2U * i + 1), 0.0);
    scenario.vehicles[i].start.position_m = around + Vector3(0.0, 0.0, kHeight_m + 3.0 * side);
    set_goal(scenario.vehicles[i], {0.0, 0.0, kHeight_m - 3.0 * side});
  }
}

constexpr auto kPlanarAndPerfect = [](sim::VehicleConfig& v) {
  rbl_of(v).variant = RblConfig::Variant::k2d;
  rbl_of(v).rules.beta_desired_m = 0.5;
  sight(v).ideal = true;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> kCases{
      {"ten on a circle", nothing, leave},
      {"fifteen on a circle", nothing, leave, {false, 15, 10.0}},
      {"a hovering vehicle in one goal", nothing, occupy_goal},
      {"one sample in 2 s", [](sim::VehicleConfig& v) { sight(v).rate_hz = 0.5; }, leave},
      {"90 % dropout", [](sim::VehicleConfig& v) { sight(v).dropout_probability = 0.9; }, leave},
      {"delay of 0.4 s", [](sim::VehicleConfig& v) { sight(v).latency_s = 0.4; }, leave},
      {"noise of 0.2 of the range", [](sim::VehicleConfig& v) { sight(v).sigma_range_relative = 0.2; }, leave},
      {"in a plane with beta 0.5 m", kPlanarAndPerfect, leave},
      {"in a plane with beta 0.5 m and radius 7 m",
       [](sim::VehicleConfig& v) {
         kPlanarAndPerfect(v);
         rbl_of(v).cells.sensing_radius_m = 7.0;
       },
       leave},
      {"two swap heights", [](sim::VehicleConfig& v) { sight(v).ideal = true; }, swap_heights},
      {"an intruder at 4 m/s", [](sim::VehicleConfig& v) { sight(v).ideal = true; }, intrude},
  };
  return kCases;
}

/// @param document  with the settings of the document (`rbl_thesis`) for comparison
sim::Scenario scene_of(const Case& c, std::uint64_t seed, bool document) {
  sim::Scenario pattern = pattern_of(seed);
  if (document) {
    RblConfig& rbl = rbl_of(pattern.vehicles.front());
    const double z_max_m = rbl.z_max_m;
    rbl = scenario_with("reproduce/rbl_crossing.yaml", seed)
              .vehicles.front()
              .agent.as<StackConfig>()
              .guidance.as<RblConfig>();
    rbl.z_max_m = z_max_m;
  }
  c.set(pattern.vehicles.front());
  sim::Scenario scenario = make_crossing(pattern, c.formation, kHeight_m);
  c.change(scenario, Random(seed, "rbl-safety.case"));
  return scenario;
}

// --- scenes drawn at random ---

/// Draws of one scene, each used once.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : random_(seed, "rbl-safety.scene") {}
  double uniform(double min, double max) { return random_.uniform(min, max, 0, next_++); }
  bool chance(double probability) { return uniform(0.0, 1.0) < probability; }
  int pick(int count) { return std::min(count - 1, static_cast<int>(uniform(0.0, count))); }

 private:
  Random random_;
  std::uint32_t next_ = 0;
};

/// Places in a box that keep a distance from each other.
std::vector<Vector3> scattered(Draws& draws, int count, double half_m, double distance_m, bool planar) {
  std::vector<Vector3> places;
  while (static_cast<int>(places.size()) < count) {
    const double x_m = draws.uniform(-half_m, half_m);
    const double y_m = draws.uniform(-half_m, half_m);
    const Vector3 place(x_m, y_m, planar ? kHeight_m : draws.uniform(4.0, 2.0 * kHeight_m - 4.0));
    const bool free = std::none_of(places.begin(), places.end(), [&](const Vector3& other) {
      return (other - place).head<2>().norm() < distance_m;  // nobody starts in another's wake
    });
    if (free) places.push_back(place);
    if (!free) half_m *= 1.001;
  }
  return places;
}

/// Anything a user may ask for: 2 to 60 vehicles, three layouts, and conditions from perfect to bad.
sim::Scenario random_scene(std::uint64_t seed) {
  Draws draws(seed);
  sim::Scenario pattern = pattern_of(seed);
  sim::VehicleConfig& vehicle = pattern.vehicles.front();
  RblConfig& rbl = rbl_of(vehicle);
  const int n = static_cast<int>(std::lround(2.0 * std::pow(30.0, draws.uniform(0.0, 1.0))));
  const int layout = draws.pick(3);
  const bool planar = layout != 1 && draws.chance(0.3);
  rbl.variant = planar ? RblConfig::Variant::k2d : RblConfig::Variant::k3dZ;
  rbl.rules.beta_desired_m = draws.uniform(0.1, 1.5);
  rbl.cells.sensing_radius_m = draws.uniform(2.5, 7.0);
  rbl.cells.step_m = rbl.cells.sensing_radius_m / 10.0;
  sim::NeighborsConfig& see = sight(vehicle);
  see.sigma_range_relative = draws.uniform(0.0, 0.2);
  see.latency_s = draws.uniform(0.0, 0.4);
  see.rate_hz = draws.chance(0.3) ? draws.uniform(0.5, 2.0) : 10.0;
  see.cameras = draws.chance(0.5) ? std::vector<sim::NeighborCamera>{{0.0, 0.0, 360.0}}
                                  : std::vector<sim::NeighborCamera>{{0.0, 0.0, 180.0}};
  pattern.wind.mean_mps = {draws.uniform(0.0, 8.0), 0.0, 0.0};
  MotionLimitsConfig& limits = vehicle.agent.as<StackConfig>().control.limits;
  limits.set = static_cast<MotionLimitsConfig::Set>(draws.pick(3));

  sim::Scenario scenario;
  if (layout == 2) {
    const double half_m = std::max(6.0, 1.6 * std::sqrt(n));
    const std::vector<Vector3> starts = scattered(draws, n, half_m, 2.5, planar);
    const std::vector<Vector3> goals = scattered(draws, n, half_m, 2.5, planar);
    scenario = make_crossing(pattern, {false, n, half_m}, kHeight_m);
    for (int i = 0; i < n; ++i) {
      scenario.vehicles[i].start.position_m = starts[i];
      set_goal(scenario.vehicles[i], goals[i]);
    }
  } else {
    // Neighbors start at least 2.5 m apart.
    const bool sphere = layout == 1;
    const double radius_m = std::max(5.0, sphere ? 0.75 * std::sqrt(n) + 3.0 : 2.5 * n / (2.0 * kPi));
    if (sphere) rbl.z_max_m = 2.0 * radius_m + 4.0;
    scenario = make_crossing(pattern, {sphere, n, radius_m}, sphere ? radius_m + 2.0 : kHeight_m);
  }
  const double reach_m = scenario.vehicles.front().start.position_m.head<2>().norm();
  if (draws.chance(0.3)) {
    scenario.vehicles.push_back(stranger(vehicle, "stopped", {0.0, 0.0, kHeight_m}, {}, 0.0));
  }
  if (draws.chance(0.3)) {
    const double azimuth_rad = draws.uniform(0.0, 2.0 * kPi), speed_mps = draws.uniform(1.0, 4.0);
    const Vector3 ahead(std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0);
    const Vector3 middle(-3.0 * ahead.y(), 3.0 * ahead.x(), kHeight_m);  // it does not hit the stopped vehicle itself
    scenario.vehicles.push_back(
        stranger(vehicle, "intruder", middle - (reach_m + 15.0) * ahead, middle + (reach_m + 15.0) * ahead, speed_mps));
  }
  return scenario;
}

}  // namespace

void rbl_safety(Experiment& experiment) {
  const int seeds = experiment.repetitions(20, 1);
  CsvTable csv({"case", "document", "success", "contacts", "least_m", "time_s"});
  for (const Case& c : cases()) {
    for (const bool document : {false, true}) {
      std::vector<sim::Scenario> scenarios;
      for (int seed = 1; seed <= seeds; ++seed)
        scenarios.push_back(scene_of(c, static_cast<std::uint64_t>(seed), document));
      const CrossingTable table =
          summarize(fly_crossings(experiment, scenarios), static_cast<int>(scenarios.front().vehicles.size()));
      csv.row(c.name, {document ? 1.0 : 0.0, table.success, table.crashed, table.min_separation_m, table.time_s.mean});
      const std::string what = fmt::format("{}{}: flights with contact [-]", c.name, document ? ", document" : "");
      experiment.row({what, fmt::format("{:.2f}", table.crashed), Verdict::kNotJudged,
                      fmt::format("least distance {:.2f} m, {:.1f} s", table.min_separation_m, table.time_s.mean),
                      table.crashed});
    }
  }
  experiment.write("cases.csv", csv);

  const int scenes = experiment.repetitions(1000, 4);
  std::vector<sim::Scenario> scenarios;
  for (int seed = 1; seed <= scenes; ++seed) scenarios.push_back(random_scene(static_cast<std::uint64_t>(seed)));
  const std::vector<CrossingResult> flights = fly_crossings(experiment, scenarios);
  CsvTable random({"seed", "vehicles", "noise", "delay_s", "rate_hz", "fov_deg", "wind_mps", "beta_m", "radius_m",
                   "contact", "least_m", "arrived"});
  std::vector<double> noise, least_m;
  double contacts = 0.0;
  for (int i = 0; i < scenes; ++i) {
    sim::Scenario& scene = scenarios[i];
    sim::VehicleConfig& vehicle = scene.vehicles.front();
    const sim::NeighborsConfig& see = sight(vehicle);
    const RblConfig& rbl = rbl_of(vehicle);
    const double row[] = {i + 1.0,
                          static_cast<double>(scene.vehicles.size()),
                          see.sigma_range_relative,
                          see.latency_s,
                          see.rate_hz,
                          see.cameras.front().fov_deg,
                          scene.wind.mean_mps.x(),
                          rbl.rules.beta_desired_m,
                          rbl.cells.sensing_radius_m,
                          flights[i].crashed ? 1.0 : 0.0,
                          flights[i].min_separation_m,
                          static_cast<double>(flights[i].num_arrived)};
    random.row(row);
    contacts += flights[i].crashed ? 1.0 : 0.0;
    noise.push_back(see.sigma_range_relative);
    least_m.push_back(flights[i].min_separation_m);
  }
  experiment.write("random.csv", random);
  experiment.claim("random scenes: no contact", fmt::format("{:g} of {} flights with contact", contacts, scenes),
                   contacts == 0.0,
                   fmt::format("least distance {:.2f} m; sum of the encumbrances {:g} m",
                               *std::min_element(least_m.begin(), least_m.end()), kEncumbrances_m));
  sim::plot::Figure figure("Random scenes", 1);
  sim::plot::Panel& panel = figure.add_panel("");
  panel.x.label = "noise of the range, share of it [-]";
  panel.y.label = "least distance [m]";
  panel.y.min = 0.0;
  panel.legend = sim::plot::Legend::kNone;
  panel.scatter("", noise, least_m);
  experiment.write("random.svg", figure);
}

}  // namespace swiftlet::tools
