// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "experiments.hpp"
#include "parallel.hpp"
#include "slam_flights.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::tools {
namespace {

/// Quantity that becomes harder from flight to flight, in closed loop on SLAM alone.
struct SlamLimit {
  const char* name;
  const char* axis;
  std::vector<double> values;  // from easy to hard
};

const std::array<SlamLimit, 4>& slam_limits_tried() {
  static const std::array<SlamLimit, 4> kLimits = {
      SlamLimit{"fast", "speed that is asked for [m/s]", {2.0, 4.0, 6.0, 8.0, 10.0, 12.0}},
      SlamLimit{
          "dark", "range at which nine of ten shots on a surface of 10 % return [m]", {20.0, 10.0, 7.0, 5.0, 3.0, 2.0}},
      SlamLimit{"empty", "trees on 1.44 ha of open ground", {64.0, 32.0, 16.0, 8.0, 4.0, 0.0}},
      SlamLimit{"crowded", "vehicles that fly along, 2.5 to 5 m away", {0.0, 2.0, 4.0, 6.0, 8.0, 10.0}},
  };
  return kLimits;
}

struct LimitLidar {
  const char* model;
  const char* label;
};
constexpr std::array kLimitLidars = {LimitLidar{"puck_lite", "Puck LITE"}, LimitLidar{"mid360", "Mid-360"}};

/// One vehicle around the building, and others that fly along with it. Returns from them look as if the vehicle stood
/// still; its tracker reports their positions to SLAM.
std::string crowd(int num_others) {
  const double corners_m[][3] = {{12.5, -10, 3}, {12.5, 10, 4}, {-12.5, 10, 4}, {-12.5, -10, 3}};
  std::string vehicles = "{name: uav1}";
  for (int i = 0; i < num_others; ++i) {
    const double x_m = (i % 2 == 0 ? 1.0 : -1.0) * (i % 4 < 2 ? 2.5 : 4.5), z_m = 2.0 * (i / 4);
    std::string way;
    for (const auto& c : corners_m)
      way += fmt::format("{}[{}, {}, {}]", way.empty() ? "" : ", ", c[0] + x_m, c[1], c[2] + z_m);
    vehicles += fmt::format(
        ", {{name: other{}, model: f450, start: {{position_m: [{}, -10, {}]}}, agent: {{type: stack, localization: "
        "{{type: "
        "ground_truth}}, control: {{limits: {{set: agile}}}}, guidance: {{type: waypoints, speed_mps: 3, loop: true, "
        "waypoints_m: [{}]}}}}}}",
        i + 1, x_m - 12.5, 3.0 + z_m, way);
  }
  return fmt::format("[{}]", vehicles);
}

sim::Scenario limit_flight(const SlamLimit& limit, double value, const LimitLidar& lidar, std::uint64_t seed) {
  const std::string kind = limit.name;
  const bool field = kind == "empty", crowded = kind == "crowded";
  const double speed_mps = kind == "fast" ? value : 3.0;
  const std::string sight = kind == "dark" ? fmt::format(
                                                 ", detection: {{range_10_percent_m: {0}, range_80_percent_m: "
                                                 "{1:.2f}}}",
                                                 value, value * std::sqrt(8.0))
                                           : "";
  std::vector<std::pair<std::string, std::string>> changes = {
      {"snapshots", "[]"},
      {"vehicles", crowd(crowded ? static_cast<int>(value) : 0)},
      {"vehicles[0].model", "x500"},
      {"vehicles[0].start.position_m", field ? "[-12, -12, 4]" : "[-12.5, -10, 3]"},
      {"vehicles[0].sensors",
       fmt::format("[{{type: lidar, name: lidar, model: {}, mount: {{position_m: [0, 0, 0.15]}}{}}}, "
                   "{{type: imu, name: imu, model: imu_adis16448}}]",
                   lidar.model, sight)},
      {"vehicles[0].agent.localization", "{type: slam}"},
      {"vehicles[0].agent.control.limits.set", "agile"},
      {"vehicles[0].agent.guidance",
       fmt::format("{{type: waypoints, speed_mps: {}, loop: true, waypoints_m: {}}}", speed_mps,
                   field ? "[[12, -12, 4], [12, 12, 4.5], [-12, 12, 4], [-12, -12, 4]]"
                         : "[[12.5, -10, 3], [12.5, 10, 4], [-12.5, 10, 4], [-12.5, -10, 3]]")},
      {"duration_s", fmt::format("{:.1f}", 180.0 / (0.7 * speed_mps))},
  };
  if (field) {
    changes.emplace_back("world.num_trees", fmt::format("{:.0f}", value));
    changes.emplace_back("world.num_bushes", "0");
  }
  if (crowded) {
    changes.emplace_back("vehicles[0].agent.detector", "{type: vofod}");
    changes.emplace_back("vehicles[0].agent.tracker", "{type: vofod}");
  }
  return scenario_with(field ? "field" : "campus", seed, std::move(changes));
}

constexpr double kWell_m = 0.2;  // largest position error (RMS) of a successful flight: below the planners' clearance

/// All flights of one LiDAR at one value.
struct LimitPoint {
  std::vector<double> rms_m;
  int flights = 0;
  int failed = 0;    // contact, invalid estimate, or error above kWell_m
  int unwarned = 0;  // failed flights without a report of lost or degenerate
};

void draw_limit(sim::plot::Figure& figure, const SlamLimit& limit,
                const std::array<std::vector<LimitPoint>, kLimitLidars.size()>& points) {
  sim::plot::Panel& panel = figure.add_panel(limit.name);
  panel.x.label = limit.axis;
  panel.y.label = "error, RMSE [m]";
  panel.y.log = true;
  for (std::size_t l = 0; l < kLimitLidars.size(); ++l) {
    std::vector<double> x, y, failed_x, failed_y;
    for (std::size_t i = 0; i < limit.values.size(); ++i) {
      const LimitPoint& point = points[l][i];
      x.push_back(limit.values[i]);
      y.push_back(median_of(point.rms_m));
      if (point.failed == 0) continue;
      failed_x.push_back(x.back());
      failed_y.push_back(y.back());
    }
    const int color = static_cast<int>(l);
    panel.line(kLimitLidars[l].label, x, y, {.color = color, .marker = sim::plot::Marker::kCircle});
    panel.scatter(failed_x.empty() ? "" : fmt::format("{}: some failed", kLimitLidars[l].label), failed_x, failed_y,
                  {.color = color, .marker = sim::plot::Marker::kCross, .marker_px = 6.0});
  }
}

}  // namespace

void slam_limits(Experiment& experiment) {
  const int seeds = experiment.repetitions(3, 1);
  std::vector<sim::Scenario> scenarios;
  for (const SlamLimit& limit : slam_limits_tried()) {
    for (const double value : limit.values) {
      for (const LimitLidar& lidar : kLimitLidars) {
        for (int seed = 1; seed <= seeds; ++seed)
          scenarios.push_back(limit_flight(limit, value, lidar, static_cast<std::uint64_t>(seed)));
      }
    }
  }
  const std::vector<SlamFlight> flights = fly_on_slam(experiment, std::move(scenarios));
  CsvTable csv({"limit", "value", "lidar", "seed", "contact", "lost_s", "warnings", "way_m", "time_s", "rms_m", "end_m",
                "nees"});
  sim::plot::Figure figure("How fast, how dark and how empty may it be? Closed loop, median of the flights", 1);
  figure.set_panel_size(760, 260);
  auto next = flights.begin();
  for (const SlamLimit& limit : slam_limits_tried()) {
    std::array<std::vector<LimitPoint>, kLimitLidars.size()> points;
    for (const double value : limit.values) {
      for (std::size_t l = 0; l < kLimitLidars.size(); ++l) {
        LimitPoint& point = points[l].emplace_back();
        for (int seed = 1; seed <= seeds; ++seed, ++next) {
          ++point.flights;
          const bool failed = next->crashed || next->lost_s > 0.0 || next->rms_m > kWell_m;
          point.failed += failed;
          point.unwarned += failed && next->warnings == 0;
          point.rms_m.push_back(next->rms_m);
          csv.row(limit.name, {value, static_cast<double>(l), static_cast<double>(seed), next->crashed ? 1.0 : 0.0,
                               next->lost_s, static_cast<double>(next->warnings), next->way_m, next->time_s,
                               next->rms_m, next->end_m, next->nees});
        }
      }
    }
    draw_limit(figure, limit, points);
    for (std::size_t l = 0; l < kLimitLidars.size(); ++l) {
      std::string all;
      double hardest = std::nan("");  // largest value with every flight successful so far
      bool well = true;
      for (std::size_t i = 0; i < limit.values.size(); ++i) {
        const LimitPoint& point = points[l][i];
        all += fmt::format(
            "{}{:g}: {} m{}", all.empty() ? "" : ", ", limit.values[i], short_number(median_of(point.rms_m), 2),
            point.failed > 0
                ? fmt::format(" ({} of {} failed, {} without a word)", point.failed, point.flights, point.unwarned)
                : "");
        well = well && point.failed == 0;
        if (well) hardest = limit.values[i];
      }
      experiment.row({fmt::format("{}, {}: all flights went well up to", limit.name, kLimitLidars[l].label),
                      std::isfinite(hardest) ? fmt::format("{:g}", hardest) : "none", Verdict::kNotJudged,
                      fmt::format("{}; error (RMSE): {}", limit.axis, all), hardest});
    }
  }
  experiment.write("flights.csv", csv);
  experiment.write("slam-limits.svg", figure);
}

}  // namespace swiftlet::tools
