// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "experiments.hpp"
#include "guidance_flights.hpp"
#include "parallel.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/plot/plot.hpp"
#include "swiftlet/sim/world/warehouse.hpp"

namespace swiftlet::tools {
namespace {

/// A row of Table III, and the limit for the share of successful passes.
struct Door {
  double width_m, safe_distance_m, least_share;
};
constexpr Door kDoors[] = {{1.2, 0.5, 1.0}, {1.1, 0.45, 1.0}, {1.0, 0.4, 1.0}, {0.9, 0.4, 0.8}};
constexpr int kPassesAFlight = 2;

sim::Scenario flight_through(const Door& door, std::uint64_t seed) {
  const Random random(seed, "narrow-gap");
  const auto near = [&](const Vector3& p_m, std::uint32_t i) {
    return text_of(p_m + Vector3(random.uniform(-0.3, 0.3, i, 0), random.uniform(-0.3, 0.3, i, 1), 0.0));
  };
  return scenario_with(
      "reproduce/narrow_gap.yaml", seed,
      {{"world.door_width_m", fmt::format("{}", door.width_m)},
       {"vehicles[0].start.position_m", near({15.6, -2.5, 1.5}, 0)},
       {"vehicles[1].start.position_m", near({17.4, 0.0, 1.5}, 1)},
       {"vehicles[1].start.yaw_deg", fmt::format("{}", random.uniform(0.0, 360.0, 2, 0))},
       {"vehicles[0].agent.guidance.planner.secondary.clearance_m", fmt::format("{}", door.safe_distance_m)}});
}

Passage passage_of(const sim::Scenario& scenario) {
  const auto& warehouse = scenario.world.as<sim::WarehouseConfig>();
  return {0.5 * (warehouse.size_m.x() + warehouse.wall_thickness_m), warehouse.door_offset_m, 0.0};
}

}  // namespace

void narrow_gap(Experiment& experiment) {
  const int flights = experiment.repetitions(10, 1);  // kPassesAFlight passes each
  std::vector<sim::Scenario> scenarios;
  std::vector<Passage> passages;
  for (const Door& door : kDoors) {
    for (int seed = 1; seed <= flights; ++seed) {
      scenarios.push_back(flight_through(door, static_cast<std::uint64_t>(seed)));
      passages.push_back(passage_of(scenarios.back()));
    }
  }
  const std::vector<GuidedFlight> all = fly_guided(experiment, std::move(scenarios), passages);

  CsvTable csv({"case", "width_m", "seed", "passes", "contact", "time_s", "least_clearance_m", "error_near_door_m"});
  sim::plot::Figure figure("Passes of the door (Table III)", 1);
  sim::plot::Panel& panel = figure.add_panel();
  std::vector<double> published_percent, ours_percent;
  auto flight = all.begin();
  for (const Door& door : kDoors) {
    int passes = 0, contacts = 0;
    double least_m = 20.0, error_sum_m = 0.0;
    int num_errors = 0;
    for (int seed = 1; seed <= flights; ++seed, ++flight) {
      passes += std::min(flight->passes, kPassesAFlight);
      contacts += flight->crashed;
      least_m = std::min(least_m, flight->least_clearance_m);
      error_sum_m += flight->error_sum_m;
      num_errors += flight->num_errors;
      csv.row("door", {door.width_m, static_cast<double>(seed), static_cast<double>(flight->passes),
                       flight->crashed ? 1.0 : 0.0, flight->time_s, flight->least_clearance_m,
                       flight->error_sum_m / std::max(flight->num_errors, 1)});
    }
    // A pass is attempted if it is the first or the one before it succeeds.
    const int attempts = passes + static_cast<int>(std::count_if(flight - flights, flight, [](const GuidedFlight& f) {
                           return f.passes < kPassesAFlight;
                         }));
    const double share = static_cast<double>(passes) / attempts;
    const std::string what = fmt::format("{:.1f} m: passes that succeed [%]", door.width_m);
    experiment.at_least(what, 100.0 * share, 100.0 * door.least_share, 3,
                        fmt::format("{} of {}, {} contacts, least clearance {:.2f} m, error at the door {:.3f} m",
                                    passes, attempts, contacts, least_m, error_sum_m / std::max(num_errors, 1)));
    panel.x.categories.push_back(fmt::format("{:.1f} m", door.width_m));
    published_percent.push_back(experiment.published(what).value);
    ours_percent.push_back(100.0 * share);
  }
  panel.x.label = "width of the door";
  panel.y.label = "passes that succeed [%]";
  panel.y.min = 0.0;
  panel.bars("published", published_percent).bars("ours", ours_percent);
  experiment.write("flights.csv", csv);
  experiment.write("narrow-gap.svg", figure);
}

}  // namespace swiftlet::tools
