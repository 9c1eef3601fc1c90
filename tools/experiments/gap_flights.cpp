// SPDX-License-Identifier: BSD-3-Clause
#include "gap_flights.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "parallel.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet::tools {
namespace {

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

}  // namespace

const char* name_of(GapTeam team) { return kTeamNames[static_cast<std::size_t>(team)]; }

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

}  // namespace swiftlet::tools
