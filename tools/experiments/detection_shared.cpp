// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "detection_flights.hpp"
#include "experiments.hpp"
#include "sharing_log.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/uncertainty/error_distribution.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"

namespace swiftlet::tools {
namespace {

constexpr std::uint64_t kFirstSharedSeed = 511;  // nothing is tuned on seeds from here on
constexpr double kKnown_s = 25.0;                // time by which frames should be known
constexpr double kRangeBin_m = 10.0, kFarthestRange_m = 70.0;
const std::vector<std::size_t> kObservers = {0, 1, 2}, kTargets = {3, 4, 5};

/// Teams of one kind; they differ only in their members.
struct Kind {
  std::string name;
  std::vector<SharingTeam> teams;
};

std::vector<Kind> kinds_of(const sim::RadioConfig& radio) {
  const auto team = [](std::vector<std::size_t> members, const sim::RadioConfig& by) {
    return SharingTeam{"", std::move(members), by};
  };
  sim::RadioConfig lossy = radio, late = radio, both = radio;
  lossy.loss_probability = both.loss_probability = 0.5;
  late.delay_s = both.delay_s = 0.3;
  return {{"one observer", {team({0}, radio), team({1}, radio), team({2}, radio)}},
          {"two observers", {team({0, 1}, radio), team({1, 2}, radio), team({0, 2}, radio)}},
          {"three observers", {team({0, 1, 2}, radio)}},
          {"three, half of the messages lost", {team({0, 1, 2}, lossy)}},
          {"three, messages 0.3 s late", {team({0, 1, 2}, late)}},
          {"three, lost and late", {team({0, 1, 2}, both)}}};
}

/// Expected error of a point measured by a Mid-360 with the pose noise of the stand-in odometry.
double expected_of_odometry_m(double range_m) {
  MeasurementNoise noise;
  noise.sigma_range_m = 0.02;
  noise.sigma_position_m.setConstant(0.003);
  noise.sigma_attitude_rad = Vector3(0.0035, 0.0035, 0.0);  // tilt of 0.2 deg; the heading drifts with its frame
  return ErrorDistribution(point_covariance(Vector3::UnitX(), range_m, Matrix3::Identity(), noise.Sigma_w())).mean_m();
}

struct SharedResult {
  int sightings = 0, found = 0, late = 0, late_found = 0, own = 0, own_found = 0;
  double error_m = 0.0, beyond_m = 0.0;
  double told = 0.0, second = 0.0, nobodys = 0.0, others = 0.0, mates = 0.0, late_mates = 0.0, late_told = 0.0;
  int switches = 0;
  double receiver_s = 0.0, bytes = 0.0, member_s = 0.0, false_tracks = 0.0, largest_message = 0.0;
  double frame_m = 0.0, frame_worst_m = 0.0, yaw_rad = 0.0, drifted_m = 0.0, sigma_m = 0.0;
  int frames = 0;
  double known_s = 0.0;  // time until another frame is known, summed over pairs
  int pairs = 0, never = 0;
  std::map<int, std::pair<int, int>> by_range;  // sightings and found, by distance from the receiver

  static double share(double part, double whole) { return whole > 0.0 ? part / whole : std::nan(""); }
  double recall() const { return share(found, sightings); }
  double late_recall() const { return share(late_found, late); }
  double precision() const {
    const double of_targets = told - others;
    return share(of_targets - second - nobodys - mates, of_targets);
  }
};

void add(const TeamRecord& record, std::size_t num_members, SharedResult& r) {
  std::map<std::tuple<double, double>, double> last;  // identity, by receiver and target
  for (const SharedSighting& s : record.sightings) {
    ++r.sightings;
    r.found += s.found > 0.0;
    r.late += s.t_s >= kKnown_s;
    r.late_found += s.t_s >= kKnown_s && s.found > 0.0;
    r.own += s.in_own_view > 0.0;
    r.own_found += s.in_own_view > 0.0 && s.found > 0.0;
    auto& bin = r.by_range[static_cast<int>(s.own_range_m / kRangeBin_m)];
    ++bin.first;
    bin.second += s.found > 0.0;
    if (!(s.found > 0.0)) continue;
    r.error_m += s.error_m;
    r.beyond_m += s.error_m - expected_of_odometry_m(s.nearest_m);
    double& identity = last[{s.receiver, s.target}];
    r.switches += identity != 0.0 && identity != s.track;
    identity = s.track;
  }
  for (const SharedScan& scan : record.scans) {
    r.told += scan.told;
    r.second += scan.second;
    r.nobodys += scan.nobodys;
    r.others += scan.others;
    r.mates += scan.mates;
    if (scan.t_s < kKnown_s) continue;
    r.late_mates += scan.mates;
    r.late_told += scan.told;
  }
  std::map<std::tuple<double, double>, double> first;
  for (const FrameError& f : record.frames) {
    first.try_emplace({f.receiver, f.other}, f.t_s);
    ++r.frames;
    r.frame_m += f.error_m;
    r.frame_worst_m = std::max(r.frame_worst_m, f.error_m);
    r.yaw_rad += f.yaw_rad;
    r.drifted_m += f.drifted_m;
    r.sigma_m += f.sigma_m;
  }
  for (const auto& [pair, t_s] : first) r.known_s += t_s;
  r.pairs += static_cast<int>(first.size());
  r.never += static_cast<int>(num_members * (num_members - 1) - first.size());
  r.receiver_s += static_cast<double>(num_members) * (record.flown_s - kIgnored_s);
  r.member_s += static_cast<double>(num_members) * record.flown_s;
  r.bytes += record.bytes;
  r.false_tracks += record.false_tracks;
  r.largest_message = std::max(r.largest_message, record.largest_message);
}

void tell_shared(Experiment& experiment, const std::string& name, const SharedResult& r, CsvTable& csv) {
  const double found = std::max(r.found, 1), frames = std::max(r.frames, 1);
  const double minutes = r.receiver_s / 60.0;
  plain_row(
      experiment, name + ": recall of what any of three could see up to 40 m", r.recall(), 3,
      fmt::format("{} sightings, {:.3f} from {:.0f} s on, {:.3f} of what is in the own view; error {:.3f} m, {:.3f} m "
                  "beyond the pose's noise; precision {:.3f} ({:.3f} told twice, {:.3f} nobody's); {:.2f} false tracks "
                  "and {:.2f} switches a minute; team mates told as targets: {:.3f} of what is told, {:.3f} from "
                  "{:.0f} s on; {:.0f} bytes a second from each, {:.0f} at most in a message",
                  r.sightings, r.late_recall(), kKnown_s, SharedResult::share(r.own_found, r.own), r.error_m / found,
                  r.beyond_m / found, r.precision(), SharedResult::share(r.second, r.told),
                  SharedResult::share(r.nobodys, r.told), r.false_tracks / minutes, r.switches / minutes,
                  SharedResult::share(r.mates, r.told), SharedResult::share(r.late_mates, r.late_told), kKnown_s,
                  r.bytes / std::max(r.member_s, 1.0), r.largest_message));
  if (r.pairs + r.never > 0) {
    plain_row(experiment, name + ": error of the other's frame [m]", r.frame_m / frames, 3,
              fmt::format("{:.2f} m at most, heading {:.2f} deg; told {:.2f} m; the frames had drifted by {:.2f} m; "
                          "known after {:.1f} s, {} of {} never",
                          r.frame_worst_m, r.yaw_rad / frames * 180.0 / std::numbers::pi, r.sigma_m / frames,
                          r.drifted_m / frames, r.known_s / std::max(r.pairs, 1), r.never, r.pairs + r.never));
  }
  csv.row(name, {static_cast<double>(r.sightings), r.recall(), r.late_recall(), r.error_m / found, r.beyond_m / found,
                 r.precision(), r.false_tracks / minutes, r.switches / minutes, r.bytes / std::max(r.member_s, 1.0),
                 r.frame_m / frames, r.yaw_rad / frames, r.drifted_m / frames});
}

/// Share of targets found by at least one observer alone, in scans of about the same instant: the most that sharing
/// can give.
double share_told_by_any(const std::vector<TeamRecord>& alone) {
  std::map<std::tuple<int, double>, bool> found;
  for (const TeamRecord& record : alone) {
    for (const SharedSighting& s : record.sightings) {
      bool& any = found[{static_cast<int>(std::floor(s.t_s * 10.0 + 0.5)), s.target}];
      any = any || s.found > 0.0;
    }
  }
  int count = 0;
  for (const auto& [key, any] : found) count += any;
  return SharedResult::share(count, static_cast<double>(found.size()));
}

}  // namespace

void detection_shared(Experiment& experiment) {
  const double duration_s = experiment.quick() ? 40.0 : 60.0;
  const int flights = experiment.repetitions(4, 1);
  std::vector<sim::Scenario> scenarios;
  SharedTracksConfig sharing;
  for (int k = 0; k < flights; ++k) {
    const std::uint64_t seed = kFirstSharedSeed + static_cast<std::uint64_t>(k);
    Overrides overrides = {{"duration_s", fmt::format("{}", duration_s)}};
    for (std::size_t v = 0; v < kObservers.size() + kTargets.size(); ++v) {
      overrides.emplace_back(fmt::format("vehicles[{}].agent.guidance.seed", v), std::to_string(10 * seed + v));
    }
    const sim::Scenario as_written = scenario_with("reproduce/detection_shared.yaml", seed, overrides);
    sharing = as_written.vehicles[0].agent.as<StackConfig>().tracker.as<SharedTracksConfig>();
    for (const std::size_t v : kObservers) {  // detector tracks: every team shares results of the same scans
      overrides.emplace_back(fmt::format("vehicles[{}].agent.tracker", v), "{type: detector}");
    }
    scenarios.push_back(scenario_with("reproduce/detection_shared.yaml", seed, overrides));
  }
  const std::vector<Kind> kinds = kinds_of(scenarios.front().radio);
  std::vector<SharingTeam> teams;
  for (const Kind& kind : kinds) teams.insert(teams.end(), kind.teams.begin(), kind.teams.end());
  std::vector<std::unique_ptr<SharingLog>> logs;
  for (const sim::Scenario& scenario : scenarios) {
    logs.push_back(std::make_unique<SharingLog>(scenario, kObservers, kTargets, teams, sharing, kIgnored_s));
  }
  fly(experiment, scenarios,
      {.after_tick = [&](std::size_t run, const sim::Simulation& simulation) { logs[run]->add(simulation); },
       .write = [&](std::size_t run) { return logs[run]->numbers(); },
       .read = [&](std::size_t run, std::span<const double> numbers) { logs[run]->restore(numbers); }});

  CsvTable csv({"observers", "sightings", "recall", "recall_from_25_s", "error_m", "beyond_noise_m", "precision",
                "false_tracks_per_min", "switches_per_min", "bytes_per_s", "frame_error_m", "frame_yaw_rad",
                "frames_drifted_m"});
  CsvTable by_range_csv({"observers", "from_m", "to_m", "sightings", "recall"});
  CsvTable frames_csv({"pair", "t_s", "error_m", "sigma_m", "drifted_m"});
  sim::plot::Figure figure("Several observers of the same targets", 2);
  figure.set_panel_size(460, 340);
  sim::plot::Panel &recall = figure.add_panel("From the one who is told"),
                   &frames = figure.add_panel("Frame of another observer, three observers, first flight");
  recall.x.label = "distance of the target [m]";
  recall.y.label = "recall of what any of three could see [-]";
  recall.y.min = 0.0;
  recall.y.max = 1.05;
  frames.x.label = "time [s]";
  frames.y.label = "[m]";
  frames.y.min = 0.0;
  std::size_t first = 0;
  int color = 0;
  for (const Kind& kind : kinds) {
    SharedResult result;
    double any = 0.0;
    for (const auto& log : logs) {
      std::vector<TeamRecord> records;
      for (std::size_t i = 0; i < kind.teams.size(); ++i) {
        add(log->of(first + i), kind.teams[i].members.size(), result);
        records.push_back(log->of(first + i));
      }
      if (kind.teams.front().members.size() == 1) any += share_told_by_any(records) / static_cast<double>(logs.size());
    }
    tell_shared(experiment, kind.name, result, csv);
    if (any > 0.0) {
      plain_row(experiment, "told by at least one of three by itself", any, 3,
                "more can't be shared but where weak tracks of several make a sure one");
    }
    std::vector<double> x, y;
    for (const auto& [bin, counts] : result.by_range) {
      if (counts.first < 20 || bin * kRangeBin_m >= kFarthestRange_m) continue;
      x.push_back((bin + 0.5) * kRangeBin_m);
      y.push_back(SharedResult::share(counts.second, counts.first));
      by_range_csv.row(kind.name,
                       {bin * kRangeBin_m, (bin + 1) * kRangeBin_m, static_cast<double>(counts.first), y.back()});
    }
    recall.line(kind.name, x, y, {.color = color++, .marker = sim::plot::Marker::kCircle});
    if (kind.name == "three observers") {
      std::map<std::tuple<double, double>, std::array<std::vector<double>, 3>> of_pair;
      for (const FrameError& f : logs.front()->of(first).frames) {
        auto& [t_s, error_m, drifted_m] = of_pair[{f.receiver, f.other}];
        t_s.push_back(f.t_s);
        error_m.push_back(f.error_m);
        drifted_m.push_back(f.drifted_m);
        frames_csv.row(fmt::format("{:.0f} of {:.0f}", f.other + 1.0, f.receiver + 1.0),
                       {f.t_s, f.error_m, f.sigma_m, f.drifted_m});
      }
      bool labeled = false;
      for (const auto& [pair, lines] : of_pair) {
        if (std::get<0>(pair) > std::get<1>(pair)) continue;  // draw one direction of each pair
        frames.line(labeled ? "" : "error of the estimate", lines[0], lines[1], {.color = 2});
        frames.line(labeled ? "" : "drift of the frames", lines[0], lines[2],
                    {.color = 0, .dash = sim::plot::Dash::kDashed});
        labeled = true;
      }
    }
    first += kind.teams.size();
  }
  experiment.write("detection-shared.csv", csv);
  experiment.write("detection-shared-range.csv", by_range_csv);
  experiment.write("detection-shared-frames.csv", frames_csv);
  experiment.write("detection-shared.svg", figure);
}

}  // namespace swiftlet::tools
