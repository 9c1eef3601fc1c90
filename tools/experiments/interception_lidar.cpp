// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "experiments.hpp"
#include "interception_hunt.hpp"
#include "parallel.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::tools {
namespace {

constexpr const char* kHuntMethods[] = {"mpc", "frpn", "proportional_navigation", "pure_pursuit"};

/// Results over a set of flights.
struct HuntTally {
  int flights = 0, captured = 0, contacts = 0;
  std::vector<double> times_s;  ///< time of each capture

  double rate() const { return flights > 0 ? static_cast<double>(captured) / flights : 0.0; }
  double mean_s() const { return mean_and_deviation(times_s).mean; }
};

/// Each flight ends when the interceptor reports success or failure, or a vehicle crashes.
HuntTally fly_hunts(const Experiment& experiment, const std::vector<sim::Scenario>& scenarios, const std::string& name,
                    CsvTable& csv) {
  const std::vector<sim::RunSummary> runs = fly(experiment, scenarios, FlightNotes{.is_over = hunt_is_over});
  const std::vector<double> captures = metric_of(runs, "captures", "interceptor");
  const std::vector<double> first_s = metric_of(runs, "time_to_first_capture_s", "interceptor");
  const std::vector<double> recall = metric_of(runs, "track_recall", "interceptor");
  const std::vector<double> hunter_crash_s = metric_of(runs, "crash_time_s", "interceptor");
  const std::vector<double> intruder_crash_s = metric_of(runs, "crash_time_s", "intruder");
  HuntTally tally;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const bool contact = !std::isnan(hunter_crash_s[i]) || !std::isnan(intruder_crash_s[i]);
    const bool captured = captures[i] > 0.0 && !contact;
    ++tally.flights;
    tally.captured += captured ? 1 : 0;
    tally.contacts += contact ? 1 : 0;
    if (captured) tally.times_s.push_back(first_s[i]);
    csv.row(name, {static_cast<double>(i), captured ? 1.0 : 0.0, contact ? 1.0 : 0.0, first_s[i], recall[i]});
  }
  return tally;
}

std::string told(const HuntTally& tally) {
  return fmt::format("{} of {}, after {} s in the mean, {} contacts", tally.captured, tally.flights,
                     tally.times_s.empty() ? "-" : short_number(tally.mean_s(), 3), tally.contacts);
}

void tell(Experiment& experiment, const std::string& what, const HuntTally& tally) {
  experiment.row(
      {what + ": captured [-]", short_number(tally.rate(), 3), Verdict::kNotJudged, told(tally), tally.rate()});
}

/// IMM, MPC and a map given in advance, with targets as fast as in the document.
void as_in_the_document(Experiment& experiment, int flights, CsvTable& csv) {
  std::vector<sim::Scenario> scenarios;
  for (int i = 0; i < flights; ++i) scenarios.push_back(hunt(i, "mpc", kDocumentSpeed_mps, os1_eye().overrides));
  const HuntTally tally = fly_hunts(experiment, scenarios, "document", csv);
  experiment.at_least("OS1-128, IMM, MPC, up to 5 m/s: captured within 60 s without contact [-]", tally.rate(), 0.99, 3,
                      told(tally));
  experiment.at_most("OS1-128, IMM, MPC, up to 5 m/s: contacts", tally.contacts, 0, 1);
}

/// Capture rate over target speed.
void over_speed(Experiment& experiment, int flights, CsvTable& csv) {
  const std::vector<double> speeds_mps =
      experiment.quick() ? std::vector<double>{5.0} : std::vector<double>{1.0, 3.0, 5.0, 8.0, 10.0};
  sim::plot::Figure figure("Captured within 60 s on nothing but a LiDAR", 2);
  figure.set_panel_size(420, 290);
  for (const HuntEye& eye : {os1_eye(), mid360_eye()}) {
    sim::plot::Panel& rate = figure.add_panel(eye.name);
    sim::plot::Panel& time = figure.add_panel(eye.name);
    rate.x.label = time.x.label = "greatest speed of the target [m/s]";
    rate.y.label = "captured [-]";
    rate.y.min = time.y.min = 0.0;
    rate.y.max = 1.05;
    rate.legend = sim::plot::Legend::kNone;  // the panel beside it has the legend
    time.y.label = "mean time of the captures [s]";
    for (const char* method : kHuntMethods) {
      std::vector<double> rates, times_s;
      for (const double speed_mps : speeds_mps) {
        std::vector<sim::Scenario> scenarios;
        for (int i = 0; i < flights; ++i) scenarios.push_back(hunt(i, method, speed_mps, eye.overrides));
        const std::string what = fmt::format("{}, {}, up to {:g} m/s", eye.name, method, speed_mps);
        const HuntTally tally = fly_hunts(experiment, scenarios, what, csv);
        tell(experiment, what, tally);
        rates.push_back(tally.rate());
        times_s.push_back(tally.times_s.empty() ? std::numeric_limits<double>::quiet_NaN() : tally.mean_s());
      }
      rate.line(method, speeds_mps, rates, {.marker = sim::plot::Marker::kCircle});
      time.line(method, speeds_mps, times_s, {.marker = sim::plot::Marker::kCircle});
    }
  }
  experiment.write("speed.svg", figure);
}

/// Flights with wind, noise and latency.
void robustness(Experiment& experiment, int flights, CsvTable& csv) {
  const std::string timing = "vehicles[0].agent.detector.timing.", lidar = "vehicles[0].sensors[0].";
  const std::vector<std::pair<const char*, Overrides>> cases = {
      {"detections 0.3 s late", {{timing + "classification_latency_s", "0.3"}}},
      {"detections 0.5 s late", {{timing + "classification_latency_s", "0.5"}}},
      {"wind of 5 m/s with moderate gusts", {{"wind", "{mean_mps: [5, 0, 0], gusts: true, wind_at_6m_mps: 15.4}"}}},
      {"wind of 8 m/s with severe gusts", {{"wind", "{mean_mps: [8, 0, 0], gusts: true, wind_at_6m_mps: 23.2}"}}},
      {"poses of scans with 0.1 m and 0.01 rad of noise",
       {{lidar + "external_pose", "{enabled: true, sigma_position_m: 0.1, sigma_rotation_rad: 0.01}"}}},
      {"ranges with 0.1 m of noise", {{lidar + "noise", "{law: constant, sigma_range_m: 0.1}"}}},
  };
  for (const auto& [name, changes] : cases) {
    std::vector<sim::Scenario> scenarios;
    for (int i = 0; i < flights; ++i) scenarios.push_back(hunt(i, "mpc", kDocumentSpeed_mps, changes));
    tell(experiment, fmt::format("OS1-128, mpc, up to 5 m/s, {}", name), fly_hunts(experiment, scenarios, name, csv));
  }
}

/// An observer that hovers beside the intruder gives both trackers the same scans.
void trackers(Experiment& experiment, int flights) {
  CsvTable csv({"tracker", "speed_mps", "error_m", "speed_error_mps", "recall"});
  for (const double speed_mps : experiment.quick() ? std::vector<double>{5.0} : std::vector<double>{3.0, 5.0, 8.0}) {
    double error_m[2] = {}, speed_error_mps[2] = {};
    for (const int imm : {0, 1}) {
      std::vector<sim::Scenario> scenarios;
      for (int i = 0; i < flights; ++i) {
        scenarios.push_back(hunt(i, "mpc", speed_mps,
                                 {{"vehicles[0].agent.guidance", "{type: hover}"},
                                  {"vehicles[0].agent.tracker",
                                   fmt::format("{{type: {}, measurement: {{sigma_m: 0.1}}}}", imm ? "imm" : "vofod")},
                                  {"vehicles[0].start.position_m", "[0, -22, 8]"},
                                  {"duration_s", "30"}}));
      }
      const std::vector<sim::RunSummary> runs = fly(experiment, scenarios);
      const auto mean = [&](const char* metric) {
        return mean_and_deviation(metric_of(runs, metric, "interceptor")).mean;
      };
      error_m[imm] = mean("track_error_mean_m");
      speed_error_mps[imm] = mean("track_speed_error_mean_mps");
      csv.row(imm ? "imm" : "kalman", {speed_mps, error_m[imm], speed_error_mps[imm], mean("track_recall")});
    }
    const auto row = [&](const char* what, const double(&error)[2], const char* unit) {
      const double change = error[1] / error[0] - 1.0;
      experiment.row(
          {fmt::format("{} of IMM against Kalman filter, up to {:g} m/s [-]", what, speed_mps),
           fmt::format("{:+.2f}", change), Verdict::kNotJudged,
           fmt::format("{} {} against {} {}", short_number(error[1], 3), unit, short_number(error[0], 3), unit),
           change});
    };
    row("position error", error_m, "m");
    row("speed error", speed_error_mps, "m/s");
  }
  experiment.write("trackers.csv", csv);
}

}  // namespace

void interception_lidar(Experiment& experiment) {
  CsvTable csv({"case", "flight", "captured", "contact", "first_s", "track_recall"});
  const int flights = experiment.repetitions(20, 1);
  as_in_the_document(experiment, experiment.quick() ? 2 : 5 * flights, csv);
  trackers(experiment, std::max(1, flights / 4));
  robustness(experiment, flights, csv);
  experiment.write("hunts.csv", csv);
}

void interception_speed(Experiment& experiment) {
  CsvTable csv({"case", "flight", "captured", "contact", "first_s", "track_recall"});
  over_speed(experiment, experiment.repetitions(20, 1), csv);
  experiment.write("hunts.csv", csv);
}

}  // namespace swiftlet::tools
