// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "experiments.hpp"
#include "parallel.hpp"
#include "slam_flights.hpp"

namespace swiftlet::tools {
namespace {

constexpr double kAisles_m[] = {-11.36, -5.68, 0.0, 5.68, 11.36};

/// Waypoints to and fro through all aisles of the warehouse, and back along the same path.
std::string snake() {
  std::vector<std::string> way;
  double x_m = -17.3;
  for (const double y_m : kAisles_m) {
    way.push_back(fmt::format("[{}, {}, 3.6]", x_m, y_m));
    x_m = -x_m;
    way.push_back(fmt::format("[{}, {}, 3.6]", x_m, y_m));
  }
  std::vector<std::string> back(way.rbegin() + 1, way.rend());
  way.erase(way.begin());  // the start
  way.insert(way.end(), back.begin(), back.end());
  return fmt::format("[{}]", fmt::join(way, ", "));
}

/// Every place of every rack holds a pallet, so all aisles look alike, and all bays as well. The LiDAR range
/// of 12 m leaves the ends of an aisle out of sight in its middle.
sim::Scenario slam_aisle_flight(std::uint64_t seed) {
  sim::Scenario scenario =
      scenario_with("warehouse", seed,
                    {{"snapshots", "[]"},
                     {"world.fill", "1"},
                     {"vehicles[0].start.position_m", fmt::format("[-17.3, {}, 3.6]", kAisles_m[0])},
                     {"vehicles[0].sensors",
                      "[{type: lidar, name: lidar, model: puck_lite, mount: {position_m: [0, 0, 0.15]}}, "
                      "{type: imu, name: imu, model: imu_adis16448}]"},
                     {"vehicles[0].agent.localization",
                      "{type: slam, local: {range_max_m: 12, map: {keep_radius_m: 15}}, global: {enabled: true}}"},
                     {"vehicles[0].agent.guidance",
                      fmt::format("{{type: waypoints, speed_mps: 3, loop: false, waypoints_m: {}}}", snake())},
                     {"metrics.stop_when_done", "true"},
                     {"duration_s", "200"}});
  scenario.vehicles.resize(1);
  return sim::validated(std::move(scenario));
}

}  // namespace

void slam_aisles(Experiment& experiment) {
  const int seeds = experiment.repetitions(20, 1);
  std::vector<sim::Scenario> scenarios;
  for (int seed = 1; seed <= seeds; ++seed) scenarios.push_back(slam_aisle_flight(static_cast<std::uint64_t>(seed)));
  const std::vector<SlamFlight> flights = fly_on_slam(experiment, std::move(scenarios));
  CsvTable csv({"seed", "done", "contact", "lost_s", "way_m", "rms_m", "rms_local_after_m", "rms_after_m", "closures",
                "false_closures", "worst_closure_m", "revisits", "revisits_closed"});
  ClosureCount sum;
  int done = 0, contacts = 0;
  std::vector<double> after_m, local_after_m;
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const SlamFlight& f = flights[i];
    done += f.done;
    contacts += f.crashed;
    sum.closed += f.closures.closed;
    sum.false_ones += f.closures.false_ones;
    sum.worst_m = std::max(sum.worst_m, f.closures.worst_m);
    sum.revisits += f.closures.revisits;
    sum.revisits_closed += f.closures.revisits_closed;
    after_m.push_back(f.rms_after_m);
    local_after_m.push_back(f.rms_local_after_m);
    csv.row({static_cast<double>(i + 1), f.done ? 1.0 : 0.0, f.crashed ? 1.0 : 0.0, f.lost_s, f.way_m, f.rms_m,
             f.rms_local_after_m, f.rms_after_m, static_cast<double>(f.closures.closed),
             static_cast<double>(f.closures.false_ones), f.closures.worst_m, static_cast<double>(f.closures.revisits),
             static_cast<double>(f.closures.revisits_closed)});
  }
  experiment.at_most("false closures", sum.false_ones, 0.0, 1,
                     fmt::format("of {}; the worst of the true ones off by {:.3f} m", sum.closed, sum.worst_m));
  experiment.row({"revisits that were closed [%]",
                  short_number(100.0 * sum.revisits_closed / std::max(sum.revisits, 1), 3), Verdict::kNotJudged,
                  fmt::format("{} of {}", sum.revisits_closed, sum.revisits),
                  100.0 * sum.revisits_closed / std::max(sum.revisits, 1)});
  experiment.row({"error of the position after the first closure [m]", short_number(median_of(after_m), 2),
                  Verdict::kNotJudged,
                  fmt::format("median of root mean squares; by local SLAM alone {:.3f} m", median_of(local_after_m)),
                  median_of(after_m)});
  experiment.claim("flights that came back", fmt::format("{} of {}", done, flights.size()),
                   done == static_cast<int>(flights.size()));
  experiment.at_most("contacts", contacts, 0.0, 1);
  experiment.write("flights.csv", csv);
}

}  // namespace swiftlet::tools
