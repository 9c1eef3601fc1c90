// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "experiments.hpp"
#include "interception_hunt.hpp"
#include "interception_protocol.hpp"
#include "parallel.hpp"

namespace swiftlet::tools {
namespace {

/// Chases of one target: by one interceptor, by one from another start, and by both.
struct Duels {
  std::vector<sim::Scenario> first, second, team;

  void add(const sim::Scenario& by_first, const sim::Scenario& by_second) {
    first.push_back(by_first);
    second.push_back(by_second);
    sim::VehicleConfig other = by_second.vehicles.front();
    other.name = "second";
    team.push_back(by_first);
    team.back().vehicles.push_back(other);
  }
};

/// Least separation of the interceptors in each flight of both.
struct Nearness {
  explicit Nearness(std::size_t flights) : least_m(flights, std::numeric_limits<double>::infinity()) {}

  FlightNotes notes(std::function<bool(const sim::Simulation&)> is_over) {
    return {.after_tick =
                [this](std::size_t flight, const sim::Simulation& simulation) {
                  const auto& states = simulation.view().states;
                  least_m[flight] =
                      std::min(least_m[flight], (states.front().p_world_m - states.back().p_world_m).norm());
                },
            .write = [this](std::size_t flight) { return std::vector<double>{least_m[flight]}; },
            .read = [this](std::size_t flight, std::span<const double> numbers) { least_m[flight] = numbers[0]; },
            .is_over = std::move(is_over)};
  }

  std::vector<double> least_m;
};

/// First capture of each flight by any interceptor; a flight without one counts with its duration.
std::vector<double> first_captures_s(const std::vector<sim::RunSummary>& runs, double duration_s) {
  std::vector<double> times_s;
  for (const sim::RunSummary& run : runs) {
    double first_s = duration_s;
    for (const char* hunter : {"interceptor", "second"}) {
      const sim::MetricRow* row = run.metrics.find("time_to_first_capture_s", hunter);
      if (row != nullptr && row->value < first_s) first_s = row->value;
    }
    times_s.push_back(first_s);
  }
  return times_s;
}

int count_contacts(const std::vector<sim::RunSummary>& runs) {
  return static_cast<int>(std::count_if(runs.begin(), runs.end(), [](const sim::RunSummary& run) {
    return std::any_of(run.metrics.rows().begin(), run.metrics.rows().end(),
                       [](const sim::MetricRow& row) { return row.name == "crash_time_s" && !std::isnan(row.value); });
  }));
}

/// Time to capture of two interceptors, over a given radio, against each of them alone.
class Comparison {
 public:
  Comparison(Experiment& experiment, CsvTable& csv, std::string name, Duels duels,
             std::function<bool(const sim::Simulation&)> is_over = {})
      : experiment_(experiment),
        csv_(csv),
        name_(std::move(name)),
        duels_(std::move(duels)),
        is_over_(std::move(is_over)),
        duration_s_(duels_.team.front().duration_s),
        first_s_(first_captures_s(fly(experiment, duels_.first, FlightNotes{.is_over = is_over_}), duration_s_)),
        second_s_(first_captures_s(fly(experiment, duels_.second, FlightNotes{.is_over = is_over_}), duration_s_)) {}

  void tell(const std::string& what, const sim::RadioConfig& radio = {}) {
    for (sim::Scenario& scenario : duels_.team) scenario.radio = radio;
    Nearness nearness(duels_.team.size());
    const std::vector<sim::RunSummary> runs = fly(experiment_, duels_.team, nearness.notes(is_over_));
    const std::vector<double> team_s = first_captures_s(runs, duration_s_);
    std::vector<double> sooner_s = first_s_;
    for (std::size_t i = 0; i < team_s.size(); ++i) {
      sooner_s[i] = std::min(first_s_[i], second_s_[i]);
      csv_.row(name_ + what, {static_cast<double>(i), first_s_[i], second_s_[i], team_s[i], nearness.least_m[i]});
    }
    const double one_s = 0.5 * (mean_and_deviation(first_s_).mean + mean_and_deviation(second_s_).mean);
    const double change = mean_and_deviation(team_s).mean / one_s - 1.0;
    experiment_.row({name_ + what + ": first capture by two against that by one [-]", fmt::format("{:+.2f}", change),
                     Verdict::kNotJudged,
                     fmt::format("{} s against {} s, {} flights; the sooner of two who fly alone: {} s",
                                 short_number(mean_and_deviation(team_s).mean, 3), short_number(one_s, 3),
                                 team_s.size(), short_number(mean_and_deviation(sooner_s).mean, 3)),
                     change});
    const double least_m = *std::min_element(nearness.least_m.begin(), nearness.least_m.end());
    experiment_.row({name_ + what + ": least distance of the two from each other [m]", short_number(least_m, 3),
                     Verdict::kNotJudged,
                     duels_.team.front().physics.contacts ? fmt::format("{} contacts", count_contacts(runs)) : "",
                     least_m});
  }

 private:
  Experiment& experiment_;
  CsvTable& csv_;
  std::string name_;
  Duels duels_;
  std::function<bool(const sim::Simulation&)> is_over_;
  double duration_s_;
  std::vector<double> first_s_, second_s_;
};

}  // namespace

void interception_team(Experiment& experiment) {
  CsvTable csv({"case", "flight", "first_alone_s", "second_alone_s", "team_s", "least_separation_m"});
  const int flights = experiment.repetitions(100, 2);
  for (const TargetLimits& limits : kTargetLimits) {
    Duels duels;
    for (int i = 0; i < flights; ++i)
      duels.add(protocol_flight("mpc", limits, i, 0), protocol_flight("mpc", limits, i, 1));
    Comparison comparison(experiment, csv, fmt::format("truth as input, up to {}", limits.name), std::move(duels));
    comparison.tell("");
    comparison.tell(", radio 0.3 s late", {.delay_s = 0.3});
    comparison.tell(", half of the messages lost", {.loss_probability = 0.5});
    comparison.tell(", no radio", {.loss_probability = 1.0});
  }
  Duels duels;
  for (int i = 0; i < std::max(1, flights / 5); ++i) {
    const Overrides& eye = os1_eye().overrides;
    duels.add(hunt(i, "mpc", kDocumentSpeed_mps, eye), hunt(i, "mpc", kDocumentSpeed_mps, eye, 1));
  }
  Comparison(experiment, csv, "OS1-128, up to 5 m/s", std::move(duels), hunt_is_over).tell("");
  experiment.write("team.csv", csv);
}

}  // namespace swiftlet::tools
