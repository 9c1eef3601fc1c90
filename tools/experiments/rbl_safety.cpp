// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "crossing.hpp"
#include "experiments.hpp"
#include "rbl_prediction.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/guidance/waypoints.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/stages/guidances.hpp"
#include "swiftlet/sim/batch/batch_plan.hpp"
#include "swiftlet/sim/plot/plot.hpp"
#include "swiftlet/sim/sensors/neighbors.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kTeamHeight_m = 8.0;
constexpr int kFlights = 1000;  // flights drawn from the batch with six seeds a case

/// Vehicle of the document's crossing with the default settings of rbl.
sim::Scenario pattern_of(std::uint64_t seed) {
  sim::Scenario pattern = scenario_with("reproduce/rbl_crossing.yaml", seed);
  pattern.metrics.stop_on_crash = true;
  pattern.duration_s = 60.0;
  RblConfig rbl;
  rbl.cells.step_m = 0.35;
  rbl.z_max_m = 2.0 * kTeamHeight_m;
  pattern.vehicles.front().agent.as<StackConfig>().guidance.as<RblConfig>() = rbl;
  return pattern;
}

sim::NeighborsConfig& sight(sim::VehicleConfig& vehicle) { return vehicle.sensors.front().as<sim::NeighborsConfig>(); }
RblConfig& rbl_of(sim::VehicleConfig& vehicle) { return vehicle.agent.as<StackConfig>().guidance.as<RblConfig>(); }

/// A vehicle that does not yield: it hovers, or flies straight on.
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

// --- cases in which the document's cells fail ---

struct Case {
  const char* name;
  void (*set)(sim::VehicleConfig& pattern);                       // changes the pattern of all vehicles
  void (*change)(sim::Scenario& scenario, const Random& random);  // changes the finished scene
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
  const Vector3 middle = side_m * across + Vector3(0.0, 0.0, kTeamHeight_m);
  scenario.vehicles.push_back(stranger(scenario.vehicles.front(), "intruder", middle - (20.0 + 4.0 * meeting_s) * ahead,
                                       middle + 30.0 * ahead, 4.0));
}

void swap_heights(sim::Scenario& scenario, const Random& random) {
  scenario.vehicles.resize(2);
  for (int i = 0; i < 2; ++i) {
    const double side = i == 0 ? -1.0 : 1.0;
    const Vector3 around(random.uniform(-0.1, 0.1, 0, 2U * i), random.uniform(-0.1, 0.1, 0, 2U * i + 1), 0.0);
    scenario.vehicles[i].start.position_m = around + Vector3(0.0, 0.0, kTeamHeight_m + 3.0 * side);
    set_goal(scenario.vehicles[i], {0.0, 0.0, kTeamHeight_m - 3.0 * side});
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

/// @param document  use the document's settings (`rbl_thesis`), for comparison
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
  sim::Scenario scenario = make_crossing(pattern, c.formation, kTeamHeight_m);
  c.change(scenario, Random(seed, "rbl-safety.case"));
  return scenario;
}

// --- the flights of batch/rbl_safety ---

/// `count` flights of the batch, drawn at random without repetition; a larger set contains the smaller one.
std::vector<sim::Scenario> flights_of_batch(int count) {
  const sim::BatchPlan plan("batch/rbl_safety");
  std::vector<std::uint64_t> ids(plan.num_episodes());
  std::iota(ids.begin(), ids.end(), 0);
  const Random random(1, "rbl-safety.flights");
  for (std::size_t i = 0; i + 1 < ids.size(); ++i) {
    const double share = random.uniform(0.0, 1.0, 0, static_cast<std::uint32_t>(i));
    std::swap(ids[i], ids[i + std::min(ids.size() - i - 1, static_cast<std::size_t>(share * (ids.size() - i)))]);
  }
  ids.resize(std::min(ids.size(), static_cast<std::size_t>(count)));
  std::vector<sim::Scenario> scenarios;
  for (const std::uint64_t id : ids) scenarios.push_back(plan.scenario_of(plan.episode(id)));
  return scenarios;
}

/// Flights of one kind, on the plot and in the table.
struct FlightKind {
  const char* name;
  const char* legend;
  int num = 0, contacts = 0, unwarned = 0, nearer = 0, arrived = 0, vehicles = 0;
  double least_m = std::numeric_limits<double>::infinity();
  std::vector<double> predicted_m = {}, flown_m = {};
};

/// Index of the flight's kind: guaranteed without or with an intruder, or the cause of no guarantee.
std::size_t kind_of(const RblConditions& conditions) {
  switch (obstacle_of(conditions)) {
    case RblObstacle::kNone:
      return conditions.intruder_mps > 0.0 ? 1 : 0;
    case RblObstacle::kUnseen:
      return 2;
    case RblObstacle::kLate:
      return 3;
    case RblObstacle::kNoise:
      return 4;
  }
  return 4;
}

void fly_batch(Experiment& experiment, int count) {
  const std::vector<sim::Scenario> scenarios = flights_of_batch(count);
  const std::vector<CrossingResult> flights = fly_crossings(experiment, scenarios);
  CsvTable csv({"scene", "seed", "vehicles", "noise", "delay_s", "rate_hz", "all_around", "speed_mps",
                "acceleration_mps2", "wind_mps", "intruder_mps", "predicted_m", "kind", "least_m", "intruder_m",
                "warned_s", "needed_s", "contact", "arrived"});
  FlightKind kinds[] = {{"promised, no intruder flies through", "no intruder"},
                        {"promised, an intruder", "an intruder"},
                        {"impossible, an intruder may come from an unobserved direction", "not looked at"},
                        {"impossible, an intruder is known too late", "known too late"},
                        {"impossible, samples may be too far off", "far off"}};
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const RblConditions c = conditions_of(scenarios[i]);
    const double predicted_m = predicted_distance_m(c), flown_m = flights[i].min_separation_m;
    const int members = static_cast<int>(scenarios[i].vehicles.size()) - 2;  // without the two that do not yield
    const std::size_t index = kind_of(c);
    FlightKind& kind = kinds[index];
    ++kind.num;
    kind.contacts += flights[i].crashed;
    // Contact with an intruder after too short a warning.
    const double intruder_m = c.intruder_mps > 0.0 ? flights[i].stranger_m : std::numeric_limits<double>::quiet_NaN();
    const double needed_s = c.intruder_mps > 0.0 ? needed_warning_s(c) : 0.0;
    kind.unwarned += flights[i].crashed && intruder_m < kTouching_m && flights[i].warned_s < needed_s;
    kind.nearer += flown_m < predicted_m;
    kind.arrived += std::min(flights[i].num_arrived, members);
    kind.vehicles += members;
    kind.least_m = std::min(kind.least_m, flown_m);
    kind.predicted_m.push_back(predicted_m);
    kind.flown_m.push_back(flown_m);
    csv.row(scenarios[i].name,
            {static_cast<double>(scenarios[i].seed), static_cast<double>(members), c.noise, c.latency_s, c.rate_hz,
             c.all_around ? 1.0 : 0.0, c.speed_mps, c.acceleration_mps2, scenarios[i].wind.mean_mps.x(), c.intruder_mps,
             predicted_m, static_cast<double>(index), flown_m, intruder_m, flights[i].warned_s, needed_s,
             flights[i].crashed ? 1.0 : 0.0, static_cast<double>(flights[i].num_arrived)});
  }
  experiment.write("batch.csv", csv);
  const int broken = kinds[0].contacts + kinds[1].contacts, promised = kinds[0].num + kinds[1].num;
  experiment.claim("batch: no contact where a distance is promised",
                   fmt::format("{} of {} flights with contact", broken, promised), broken == 0);
  const int nearer = kinds[0].nearer + kinds[1].nearer;
  experiment.claim("batch: no vehicle comes nearer than promised",
                   fmt::format("{} of {} flights came nearer", nearer, promised), nearer == 0);
  sim::plot::Figure figure("Least distance, predicted and flown", 1);
  sim::plot::Panel& panel = figure.add_panel("");
  panel.x.label = "predicted [m]";
  panel.y.label = "flown [m]";
  panel.x.min = panel.y.min = 0.0;
  const double diagonal_m[] = {0.0, 1.2};
  for (const FlightKind& kind : kinds) {
    if (kind.num == 0) continue;
    experiment.row({fmt::format("batch, {}: flights with contact [-]", kind.name),
                    fmt::format("{} of {}", kind.contacts, kind.num), Verdict::kNotJudged,
                    fmt::format("{} knew of the intruder too late; least distance {:.2f} m; {} flights below the "
                                "prediction; {:.0f} % of the vehicles arrive in time",
                                kind.unwarned, kind.least_m, kind.nearer, 100.0 * kind.arrived / kind.vehicles),
                    static_cast<double>(kind.contacts)});
    panel.scatter(kind.legend, kind.predicted_m, kind.flown_m, {.opacity = 0.6});
  }
  panel.line("as predicted", diagonal_m, diagonal_m, {.dash = sim::plot::Dash::kDashed});
  experiment.write("predicted.svg", figure);
}

}  // namespace

void rbl_safety(Experiment& experiment) {
  const int seeds = experiment.repetitions(6, 1);
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
                      fmt::format("least distance {:.2f} m, {}", table.min_separation_m,
                                  table.success > 0.0 ? fmt::format("{:.1f} s", table.time_s.mean)
                                                      : std::string("in no flight all arrive")),
                      table.crashed});
    }
  }
  experiment.write("cases.csv", csv);

  fly_batch(experiment, experiment.quick() ? 4 * seeds : kFlights * seeds / 6);
}

}  // namespace swiftlet::tools
