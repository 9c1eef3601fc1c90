// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "experiments.hpp"
#include "parallel.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet::tools {
namespace {

/// The greatest speeds and accelerations of the targets: two accounts of the paper disagree.
struct TargetLimits {
  const char* name;
  double speed_mps, acceleration_mps2;
};
constexpr TargetLimits kTargetLimits[] = {{"8 m/s", 8.0, 4.0}, {"10 m/s", 10.0, 8.0}};
constexpr double kSlowestTarget_mps = 3.0;
constexpr const char* kPursuits[] = {"frpn", "proportional_navigation", "pure_pursuit", "mpc"};
constexpr int kFirstTrajectory = 100;                             // the planner was tuned on others
constexpr double kNearestStart_m = 5.0, kFarthestStart_m = 20.0;  // of the starts from the target

/// One of the trajectories, from one of its starts. How hard a trajectory is, is drawn as well.
sim::Scenario protocol_flight(const char* method, const TargetLimits& limits, int trajectory, int start) {
  const auto number = static_cast<std::uint32_t>(kFirstTrajectory + trajectory);
  const Random random(1, "interception.protocol");
  const double speed_mps = random.uniform(kSlowestTarget_mps, limits.speed_mps, number, 0);
  const double acceleration_mps2 = limits.acceleration_mps2 * speed_mps / limits.speed_mps;
  const auto index = static_cast<std::uint32_t>(16 * (start + 1));
  const double azimuth_rad = random.uniform(0.0, 2.0 * kPi, number, index);
  const double elevation_rad = random.uniform(-0.5, 0.5, number, index + 1);
  const double distance_m = random.uniform(kNearestStart_m, kFarthestStart_m, number, index + 2);
  const double level_m = distance_m * std::cos(elevation_rad);
  return scenario_with("reproduce/interception.yaml", number + 1,
                       {{"vehicles[0].agent.guidance.method", method},
                        {"vehicles[0].start.position_m",
                         fmt::format("[{:.3f}, {:.3f}, {:.3f}]", level_m * std::cos(azimuth_rad),
                                     level_m * std::sin(azimuth_rad), 25.0 + distance_m * std::sin(elevation_rad))},
                        {"vehicles[1].agent.guidance.seed", std::to_string(number + 1)},
                        {"vehicles[1].agent.guidance.speed_mps", fmt::format("{:.4f}", speed_mps)},
                        {"vehicles[1].agent.guidance.acceleration_mps2", fmt::format("{:.4f}", acceleration_mps2)}});
}

/// The figures that the paper tells of one method.
struct ProtocolResult {
  double captured = 0.0;  ///< share of the trajectories in which any start led to a capture
  double every_start = 0.0;
  double captures = 0.0, first_s = 0.0, least_m = 0.0;
};

ProtocolResult fly_protocol(const Experiment& experiment, const char* method, const TargetLimits& limits,
                            int trajectories, int starts, CsvTable& csv) {
  std::vector<sim::Scenario> scenarios;
  for (int t = 0; t < trajectories; ++t) {
    for (int s = 0; s < starts; ++s) scenarios.push_back(protocol_flight(method, limits, t, s));
  }
  const std::vector<sim::RunSummary> runs = fly(experiment, scenarios);
  const std::vector<double> captures = metric_of(runs, "captures", "interceptor");
  const std::vector<double> first_s = metric_of(runs, "time_to_first_capture_s", "interceptor");
  const std::vector<double> least_m = metric_of(runs, "least_net_distance_m", "interceptor");
  ProtocolResult result;
  for (int t = 0; t < trajectories; ++t) {
    bool any = false;
    for (int s = 0; s < starts; ++s) {
      const auto i = static_cast<std::size_t>(t * starts + s);
      any = any || captures[i] > 0.0;
      result.every_start += captures[i] > 0.0 ? 1.0 / static_cast<double>(runs.size()) : 0.0;
      csv.row(fmt::format("{} {}", limits.name, method),
              {static_cast<double>(t), static_cast<double>(s), captures[i], first_s[i], least_m[i]});
    }
    result.captured += any ? 1.0 / trajectories : 0.0;
  }
  result.captures = mean_and_deviation(captures).mean;
  result.first_s = mean_and_deviation(first_s).mean;
  result.least_m = mean_and_deviation(least_m).mean;
  return result;
}

/// A second interceptor from another of the starts.
sim::Scenario team_flight(const TargetLimits& limits, int trajectory) {
  sim::Scenario scenario = protocol_flight("mpc", limits, trajectory, 0);
  sim::VehicleConfig second = protocol_flight("mpc", limits, trajectory, 1).vehicles.front();
  second.name = "second";
  scenario.vehicles.push_back(second);
  return scenario;
}

/// Does a second interceptor shorten the chase? A flight without a capture counts with its whole length.
void two_against_one(Experiment& experiment, const TargetLimits& limits, int trajectories, CsvTable& csv) {
  std::vector<sim::Scenario> alone, team;
  for (int t = 0; t < trajectories; ++t) {
    alone.push_back(protocol_flight("mpc", limits, t, 0));
    team.push_back(team_flight(limits, t));
  }
  const auto first_s = [&](const std::vector<sim::RunSummary>& runs, const char* vehicle) {
    std::vector<double> times_s = metric_of(runs, "time_to_first_capture_s", vehicle);
    for (double& time_s : times_s) time_s = std::isnan(time_s) ? team.front().duration_s : time_s;
    return times_s;
  };
  const std::vector<double> alone_s = first_s(fly(experiment, alone), "interceptor");
  const std::vector<sim::RunSummary> runs = fly(experiment, team);
  std::vector<double> team_s = first_s(runs, "interceptor");
  const std::vector<double> second_s = first_s(runs, "second");
  for (std::size_t i = 0; i < team_s.size(); ++i) {
    team_s[i] = std::min(team_s[i], second_s[i]);
    csv.row(limits.name, {static_cast<double>(i), alone_s[i], team_s[i]});
  }
  const double one_s = mean_and_deviation(alone_s).mean, two_s = mean_and_deviation(team_s).mean;
  experiment.row(
      {fmt::format("{} mpc: first capture by two against that by one [-]", limits.name),
       fmt::format("{:+.2f}", two_s / one_s - 1.0), Verdict::kNotJudged,
       fmt::format("{} s against {} s, {} flights of each; a flight without a capture counts with its length",
                   short_number(two_s, 3), short_number(one_s, 3), trajectories),
       two_s / one_s - 1.0});
}

}  // namespace

void interception(Experiment& experiment) {
  const int trajectories = experiment.repetitions(100, 2);
  const int starts = experiment.quick() ? 1 : 5;
  const std::string flights = fmt::format(
      "{} trajectories, {} starts each; the paper tells neither its trajectories nor the interceptor's "
      "limits",
      trajectories, starts);
  CsvTable csv({"case", "trajectory", "start", "captures", "first_s", "least_m"});
  for (const TargetLimits& limits : kTargetLimits) {
    for (const char* method : kPursuits) {
      const ProtocolResult result = fly_protocol(experiment, method, limits, trajectories, starts, csv);
      const std::string name = fmt::format("{} {}: ", limits.name, method);
      const auto row = [&](const char* what, double value, int digits, const std::string& note) {
        experiment.row({name + what, short_number(value, digits), Verdict::kNotJudged, note, value});
      };
      row("trajectories captured [-]", result.captured, 3,
          fmt::format("{:.3f} of all flights; {}", result.every_start, flights));
      row("captures in 100 s", result.captures, 3, "each passage through the disc counts");
      row("first capture after [s]", result.first_s, 3, "of the flights with a capture");
      row("least distance from the net's middle [m]", result.least_m, 2, "mean over flights");
    }
  }
  experiment.write("flights.csv", csv);
  CsvTable team({"case", "trajectory", "alone_s", "team_s"});
  for (const TargetLimits& limits : kTargetLimits) two_against_one(experiment, limits, trajectories, team);
  experiment.write("team.csv", team);
}

}  // namespace swiftlet::tools
