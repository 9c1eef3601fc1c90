// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <vector>

#include "experiments.hpp"
#include "interception_protocol.hpp"
#include "parallel.hpp"

namespace swiftlet::tools {
namespace {

constexpr const char* kPursuits[] = {"frpn", "proportional_navigation", "pure_pursuit", "mpc"};

/// Figures that the paper gives for one method.
struct ProtocolResult {
  double captured = 0.0;  ///< share of the trajectories with a capture from any start
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
}

}  // namespace swiftlet::tools
