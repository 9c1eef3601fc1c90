// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments.hpp"
#include "guidance_flights.hpp"
#include "parallel.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::tools {
namespace {

/// The configurations of Fig. 6, in the order of its legend.
enum class GapTeam { kTruthOwnMap, kTruth, kFull, kFullToldOnce, kSingle };
using Overrides = std::vector<std::pair<std::string, std::string>>;

constexpr std::array<const char*, 5> kTeamNames = {"true places, the secondary's map", "true places",
                                                   "full localization", "full localization, path sent once",
                                                   "single UAV"};
constexpr double kHeight_m = 1.5;

struct Run {
  sim::Scenario scenario;
  Passage passage;
};

/// Both vehicles use true poses, also for each other.
void know_the_truth(Overrides& changes) {
  changes.emplace_back("vehicles[1].start.known", "pose");
  changes.emplace_back("vehicles[1].agent.localization", "{type: ground_truth}");
  changes.emplace_back("vehicles[1].agent.guidance.odometry_rate_hz", "10");
  changes.emplace_back("vehicles[0].agent.relative_localization", "{type: shared_world, other: secondary}");
}

/// The guide plans on scans of a LiDAR on the secondary, which is too heavy in reality; no real radio carries the
/// scans.
void map_by_the_secondary(Overrides& changes) {
  changes.emplace_back("radio.rate_kbps", "1000000");
  changes.emplace_back("radio.queue_limit_kB", "10000");
  changes.emplace_back("vehicles[1].sensors",
                       "[{type: lidar, name: os0, model: os0_128, mount: {position_m: [0, 0, 0.12]}}, "
                       "{type: imu, name: imu, model: imu_mrs}]");
  changes.emplace_back("vehicles[1].agent.mapping", "{type: occupancy, tell_rays_to: primary, range_min_m: 0.4}");
  changes.emplace_back("vehicles[0].agent.mapping", "{type: occupancy, rays_of: secondary}");
}

void localize_by_sensors(Overrides& changes) {
  changes.emplace_back("vehicles[0].sensors",
                       "[{type: lidar, name: os0, model: os0_128, mount: {position_m: [0, 0, 0.15]}}, "
                       "{type: odometry, name: lio, model: odometry_lio}, "
                       "{type: imu, name: imu, model: imu_adis16448}]");
  changes.emplace_back("vehicles[0].agent.localization", "{type: odometry}");
  changes.emplace_back(
      "vehicles[0].agent.relative_localization",
      "{type: sliding_window, other: secondary, source: markers, center_behind_m: 0.025, center_above_m: 0.025}");
}

/// The seed draws the pose of the building, the starts and the goals.
Run make_run(GapTeam team, double safe_distance_m, std::uint64_t seed) {
  const Random random(seed, "gap-success");
  std::uint32_t drawn = 0;
  const auto draw = [&](double low, double high) { return random.uniform(low, high, 0, drawn++); };
  Passage passage;
  passage.x_world_m = draw(-0.5, 0.5);
  passage.y_world_m = draw(-0.5, 0.5);
  const double yaw_deg = draw(0.0, 360.0);
  passage.yaw_rad = yaw_deg * std::numbers::pi / 180.0;
  const Vector3 small_m = in_world(passage, draw(-4.2, -3.0), draw(-2.0, 2.0), kHeight_m);
  const Vector3 large_m = in_world(passage, draw(-7.6, -6.2), draw(-3.0, 3.0), kHeight_m);
  const Vector3 goal_m = in_world(passage, draw(2.5, 3.5), draw(-0.5, 0.5), kHeight_m);
  const std::string goals = fmt::format("[{}, {}]", text_of(goal_m), text_of(small_m));

  Overrides changes = {{"world.safe_distance_m", fmt::format("{}", safe_distance_m)},
                       {"world.yaw_deg", fmt::format("{}", yaw_deg)},
                       {"world.position_m", fmt::format("[{}, {}]", passage.x_world_m, passage.y_world_m)},
                       {"vehicles[0].agent.guidance.goals_m", goals},
                       {"vehicles[0].start.yaw_deg", fmt::format("{}", draw(0.0, 360.0))},
                       {"duration_s", "120"}};
  if (team == GapTeam::kSingle) {
    changes.emplace_back("vehicles[0].start.position_m", text_of(small_m));
    changes.emplace_back("vehicles[0].agent.guidance.planner.clearance_m", fmt::format("{}", safe_distance_m));
    changes.emplace_back("vehicles[0].agent.guidance.follow", "corners");  // same as the secondary
    return {scenario_with("navigate.yaml", seed, std::move(changes)), passage};
  }
  changes.emplace_back("vehicles[0].start.position_m", text_of(large_m));
  changes.emplace_back("vehicles[1].start.position_m", text_of(small_m));
  changes.emplace_back("vehicles[1].start.yaw_deg", fmt::format("{}", draw(0.0, 360.0)));
  const std::string planner = "vehicles[0].agent.guidance.planner.secondary.";
  changes.emplace_back(planner + "clearance_m", fmt::format("{}", safe_distance_m));
  changes.emplace_back(planner + "unknown_is_free", "true");
  const bool truth = team == GapTeam::kTruth || team == GapTeam::kTruthOwnMap;
  if (truth)
    know_the_truth(changes);
  else
    localize_by_sensors(changes);
  if (team == GapTeam::kTruthOwnMap) map_by_the_secondary(changes);
  if (team == GapTeam::kFullToldOnce) {
    changes.emplace_back("vehicles[0].agent.guidance.periodic", "false");
    changes.emplace_back("vehicles[1].agent.guidance.link_timeout_s", "120");  // covers the whole path
  }
  return {scenario_with("guided_gap.yaml", seed, std::move(changes)), passage};
}

const char* name_of(GapTeam team) { return kTeamNames[static_cast<std::size_t>(team)]; }

/// All flights of one configuration at one safe distance.
struct GapPoint {
  int flights = 0, successes = 0, crashes = 0;
  double share() const { return flights > 0 ? static_cast<double>(successes) / flights : 0.0; }
};
using GapCurve = std::map<double, GapPoint>;  // key: safe distance [m]

/// Sums of the error of the guide's estimate of the secondary's position, within 1 m of the gap.
struct GapErrors {
  double error_sum_m = 0.0, along_wall_sum_m = 0.0;
  int count = 0;
};

class GapFlights {
 public:
  explicit GapFlights(Experiment& experiment) : experiment_(experiment) {}

  void want(GapTeam team, double safe_distance_m, int first_seed, int last_seed);
  void fly_wanted();
  const GapCurve& curve(GapTeam team) const { return curves_.at(team); }
  const std::map<GapTeam, GapCurve>& curves() const { return curves_; }
  const GapErrors& errors(GapTeam team) { return errors_[team]; }
  const CsvTable& csv() const { return csv_; }

 private:
  struct Wanted {
    GapTeam team;
    double safe_distance_m;
    int seed;
  };
  void take(const Wanted& w, const GuidedFlight& flight);

  Experiment& experiment_;
  std::vector<Wanted> wanted_;
  std::map<GapTeam, GapCurve> curves_;
  std::map<GapTeam, GapErrors> errors_;
  CsvTable csv_{{"configuration", "safe_distance_m", "seed", "success", "contact", "passes", "time_s",
                 "least_clearance_m", "error_near_gap_m"}};
};

void GapFlights::want(GapTeam team, double safe_distance_m, int first_seed, int last_seed) {
  for (int seed = first_seed; seed <= last_seed; ++seed) wanted_.push_back({team, safe_distance_m, seed});
}

void GapFlights::fly_wanted() {
  std::vector<sim::Scenario> scenarios;
  std::vector<Passage> passages;
  for (const Wanted& w : wanted_) {
    Run run = make_run(w.team, w.safe_distance_m, static_cast<std::uint64_t>(w.seed));
    scenarios.push_back(std::move(run.scenario));
    passages.push_back(run.passage);
  }
  const std::vector<GuidedFlight> flights = fly_guided(experiment_, std::move(scenarios), passages);
  for (std::size_t i = 0; i < flights.size(); ++i) take(wanted_[i], flights[i]);
  wanted_.clear();
}

void GapFlights::take(const Wanted& w, const GuidedFlight& flight) {
  const bool success = flight.done && flight.passes >= 2 && !flight.crashed;
  GapPoint& point = curves_[w.team][w.safe_distance_m];
  ++point.flights;
  point.successes += success;
  point.crashes += flight.crashed;
  GapErrors& errors = errors_[w.team];
  errors.error_sum_m += flight.error_sum_m;
  errors.along_wall_sum_m += flight.along_wall_sum_m;
  errors.count += flight.num_errors;
  const double mean_m = flight.num_errors > 0 ? flight.error_sum_m / flight.num_errors : std::nan("");
  csv_.row(name_of(w.team),
           {w.safe_distance_m, static_cast<double>(w.seed), success ? 1.0 : 0.0, flight.crashed ? 1.0 : 0.0,
            static_cast<double>(flight.passes), flight.time_s, flight.least_clearance_m, mean_m});
}

constexpr std::array kTeams = {GapTeam::kTruthOwnMap, GapTeam::kTruth, GapTeam::kFull, GapTeam::kFullToldOnce,
                               GapTeam::kSingle};

/// Safe distance from which on 90 % succeed, interpolated linearly between two points of the curve.
std::optional<double> distance_of_90(const GapCurve& curve) {
  std::optional<double> found_m;
  const std::pair<const double, GapPoint>* above = nullptr;
  for (auto point = curve.rbegin(); point != curve.rend(); ++point) {
    const double share = point->second.share();
    if (share < 0.9) {
      if (above != nullptr) {
        found_m = point->first + (above->first - point->first) * (0.9 - share) / (above->second.share() - share);
      }
      return found_m;
    }
    above = &*point;
    found_m = point->first;
  }
  return found_m;
}

/// Points of the curve within 0.05 m of the 90 % crossing.
std::vector<double> around_90(const GapCurve& curve) {
  const auto at_m = distance_of_90(curve);
  if (!at_m) return {};
  std::vector<double> near_m;
  for (const auto& [safe_distance_m, point] : curve) {
    if (std::abs(safe_distance_m - *at_m) <= 0.05 + 1e-9) near_m.push_back(safe_distance_m);
  }
  return near_m;
}

void plot(Experiment& experiment, const std::map<GapTeam, GapCurve>& curves) {
  sim::plot::Figure figure("Flights through the gap and back (Fig. 6)", 1);
  figure.set_panel_size(760, 420);
  sim::plot::Panel& panel = figure.add_panel();
  panel.x.label = "safe distance of the planner [m]; the gap is twice as wide and 0.15 m more";
  panel.y.label = "flights that succeeded [%]";
  panel.y.min = 0.0;
  panel.y.max = 100.0;
  for (const auto& [team, curve] : curves) {
    std::vector<double> x, y, low, high;
    for (const auto& [safe_distance_m, point] : curve) {
      const ShareInterval interval = wilson(point.successes, point.flights);
      x.push_back(safe_distance_m);
      y.push_back(100.0 * point.share());
      low.push_back(100.0 * interval.low);
      high.push_back(100.0 * interval.high);
    }
    const int color = static_cast<int>(team);
    panel.band("", x, low, high, {.color = color, .opacity = 0.15});
    panel.line(name_of(team), x, y, {.color = color, .marker = sim::plot::Marker::kCircle});
  }
  experiment.write("gap-success.svg", figure);
}

std::string in_meters(const std::optional<double>& m) { return m ? fmt::format("{:.2f}", *m) : "never"; }

}  // namespace

/// A UAV guides a small one through a gap and back, in several configurations [Pritzl 2024, Fig. 6].
void gap_success(Experiment& experiment) {
  const int seeds = experiment.repetitions(10, 1);
  std::vector<double> distances_m;
  if (experiment.quick())
    distances_m = {0.2, 0.3, 0.6};
  else
    distances_m = {0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6};
  GapFlights flights(experiment);
  for (const GapTeam team : kTeams) {
    for (const double safe_distance_m : distances_m) flights.want(team, safe_distance_m, 1, seeds);
  }
  flights.fly_wanted();
  if (!experiment.quick()) {
    for (const GapTeam team : kTeams) {
      for (const double safe_distance_m : around_90(flights.curve(team))) {
        flights.want(team, safe_distance_m, seeds + 1, 3 * seeds);
      }
    }
    flights.fly_wanted();
  }

  std::map<GapTeam, std::optional<double>> of_90_m;
  for (const GapTeam team : kTeams) {
    of_90_m[team] = distance_of_90(flights.curve(team));
    std::string shares;
    int crashes = 0;
    for (const auto& [safe_distance_m, point] : flights.curve(team)) {
      shares +=
          fmt::format("{}{:g}: {}/{}", shares.empty() ? "" : ", ", safe_distance_m, point.successes, point.flights);
      crashes += point.crashes;
    }
    experiment.row({fmt::format("{}: safe distance of 90 % success [m]", name_of(team)), in_meters(of_90_m[team]),
                    Verdict::kNotJudged, fmt::format("{}; {} contacts", shares, crashes),
                    of_90_m[team].value_or(std::nan(""))});
  }
  const auto &best_m = of_90_m[GapTeam::kTruthOwnMap], &full_m = of_90_m[GapTeam::kFull],
             &single_m = of_90_m[GapTeam::kSingle];
  if (best_m && full_m) {
    experiment.at_most("full localization, above that of the best [m]", *full_m - *best_m,
                       experiment.published("full localization, above that of the best [m]").value, 2,
                       "true places and the secondary's map");
  }
  if (full_m && single_m) {
    experiment.claim("a UAV is guided through gaps that are too narrow for its guide",
                     fmt::format("{:.2f} m less", *single_m - *full_m), *full_m < *single_m);
  }
  const GapErrors& errors = flights.errors(GapTeam::kFull);
  if (errors.count > 0) {
    experiment.at_most("error of its place within 1 m of the gap [m]", errors.error_sum_m / errors.count,
                       experiment.published("error of its place within 1 m of the gap [m]").value, 2);
    experiment.at_most("the same along the wall [m]", errors.along_wall_sum_m / errors.count,
                       experiment.published("the same along the wall [m]").value, 2);
  }
  experiment.write("flights.csv", flights.csv());
  plot(experiment, flights.curves());
}

}  // namespace swiftlet::tools
