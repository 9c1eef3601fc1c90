// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "experiments.hpp"
#include "guidance_flights.hpp"
#include "parallel.hpp"
#include "stopwatch.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/mapping/occupancy_mapper.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::tools {
namespace {

constexpr TimeNs kFirstPlan = 5 * kNsPerSecond, kEvery = kNsPerSecond;
constexpr double kStep_m = 4.0;

/// Stages of algorithm 1 as in the table; its last row is the total.
constexpr std::array<const char*, 3> kPlanningStages = {"the secondary's path", "the viewpoint", "the primary's path"};
constexpr const char* kWhole = "algorithm 1";

/// Plans once a second during a flight, outside of the vehicle's stack, on a map of the same scans.
class PlanTimer {
 public:
  explicit PlanTimer(const TeamPlannerConfig& config)
      : config_(config), registrar_(0.6), mapper_(make_occupancy_mapper(OccupancyMapperConfig{}, AgentSetup{})) {}

  void take(const sim::Simulation& simulation) {
    const sim::TickView& view = simulation.view();
    const Action& action = *view.actions[0];
    registrar_.push(action.estimate);
    for (const auto& labeled : view.scans[0]) {
      auto cloud = std::make_shared<LocalCloud>();
      if (!registrar_.make(std::shared_ptr<const Scan>(labeled, &labeled->scan), *cloud)) continue;
      const std::shared_ptr<const LocalCloud> clouds[] = {std::move(cloud)};
      insertion.time([&] { mapper_->step({view.observations[0], action.estimate, clouds, action.tracks}, outbox_); });
    }
    if (view.t < next_) return;
    next_ += kEvery;
    plan(view.states[0].p_world_m, view.states[1].p_world_m);
  }

  std::array<Stopwatch, 3> stages;
  Stopwatch whole, insertion;
  int failed = 0;

 private:
  void plan(const Vector3& primary_world_m, const Vector3& secondary_world_m) {
    std::vector<double> began_s;
    const TeamPlan plan = plan_team(mapper_->map(), config_, primary_world_m, {secondary_world_m, 0.0},
                                    {secondary_world_m + Vector3(kStep_m, 0.0, 0.0), 0.0}, {},
                                    [&](PlanningStage) { began_s.push_back(thread_time_s()); });
    began_s.push_back(thread_time_s());
    for (std::size_t i = 0; i + 1 < began_s.size(); ++i) stages[i].add(began_s[i + 1] - began_s[i]);
    whole.add(began_s.back() - began_s.front());
    failed += plan.next == TeamPlan::Next::kFail;
  }

  TeamPlannerConfig config_;
  CloudRegistrar registrar_;
  std::unique_ptr<Mapper> mapper_;
  Outbox outbox_;
  TimeNs next_ = kFirstPlan;
};

/// Sizes of the messages of one topic.
struct Traffic {
  std::vector<double> sizes_bytes;
  double rate_hz(double seconds) const { return static_cast<double>(sizes_bytes.size()) / seconds; }
  double least_kB() const { return 1e-3 * *std::min_element(sizes_bytes.begin(), sizes_bytes.end()); }
  double most_kB() const { return 1e-3 * *std::max_element(sizes_bytes.begin(), sizes_bytes.end()); }
};

/// Records radio traffic while the secondary is guided.
class Listener {
 public:
  void take(const sim::Simulation& simulation) {
    const sim::TickView& view = simulation.view();
    for (const sim::Event& event : view.events) {
      if (event.vehicle == 0) guides_ = event.note == "secondary moving";
    }
    if (!guides_) return;
    guided_s += simulation.scenario().tick_s;
    for (const auto& [vehicle, traffic] : {std::pair(0, &paths), std::pair(1, &odometry)}) {
      for (const Message& message : view.actions[static_cast<std::size_t>(vehicle)]->messages) {
        traffic->sizes_bytes.push_back(static_cast<double>(message.size_bytes()));
      }
    }
  }
  Traffic paths, odometry;
  double guided_s = 0.0;

 private:
  bool guides_ = false;
};

sim::Scenario quiet(sim::Scenario scenario) {
  scenario.recorders.clear();
  scenario.snapshots.clear();
  return scenario;
}

/// Adds a histogram of the samples.
void add_histogram(sim::plot::Panel& panel, const std::vector<double>& samples, double bin) {
  const auto bin_of = [bin](double sample) { return static_cast<std::size_t>(sample / bin); };
  const double most = *std::max_element(samples.begin(), samples.end());
  std::vector<double> edges, counts(bin_of(most) + 1, 0.0);
  for (std::size_t i = 0; i < counts.size(); ++i) edges.push_back(bin * static_cast<double>(i));
  for (const double sample : samples) ++counts[bin_of(sample)];
  edges.push_back(bin * static_cast<double>(counts.size()));
  counts.push_back(0.0);
  panel.step("", edges, counts);
}

}  // namespace

void guidance_timing(Experiment& experiment) {
  const int seeds = experiment.repetitions(5, 1);
  std::vector<sim::Scenario> scenarios;
  std::vector<std::unique_ptr<PlanTimer>> timers;
  for (int seed = 1; seed <= seeds; ++seed) {
    scenarios.push_back(quiet(scenario_with("forest_guidance.yaml", static_cast<std::uint64_t>(seed))));
    if (experiment.quick()) scenarios.back().duration_s = 25.0;
    timers.push_back(std::make_unique<PlanTimer>(guide_of(scenarios.back()).planner));
  }
  fly(experiment, scenarios, [&](std::size_t i, const sim::Simulation& simulation) { timers[i]->take(simulation); });

  std::array<Stopwatch, 3> stages;
  Stopwatch whole, insertion;
  int failed = 0;
  const auto add_all = [](Stopwatch& to, const Stopwatch& from) {
    for (const double took_ms : from.times_ms()) to.add(1e-3 * took_ms);
  };
  for (const auto& timer : timers) {
    for (std::size_t i = 0; i < stages.size(); ++i) add_all(stages[i], timer->stages[i]);
    add_all(whole, timer->whole);
    add_all(insertion, timer->insertion);
    failed += timer->failed;
  }

  CsvTable csv({"stage", "median_ms", "greatest_ms", "calls", "published_ms"});
  sim::plot::Figure figure("Algorithm 1: median time of each stage (sec. III-B)", 1);
  figure.set_panel_size(760, 320);
  sim::plot::Panel& panel = figure.add_panel();
  std::vector<double> published_ms, ours_ms;
  const auto add_row = [&](const char* name, const Stopwatch& clock, double times_faster, const std::string& note) {
    const std::string what = fmt::format("{} [s]", name);
    const double theirs_s = experiment.published(what).value, ours_s = 1e-3 * clock.median_ms();
    const double most_ms = clock.times_ms().empty() ? 0.0 : std::ranges::max(clock.times_ms());
    experiment.row({what, short_number(ours_s, 2),
                    ours_s * times_faster <= theirs_s ? Verdict::kOtherConditions : Verdict::kDiffers,
                    fmt::format("median of {}, at most {:.3f} s{}", clock.times_ms().size(), 1e-3 * most_ms, note),
                    ours_s, fmt::format("{:.3g} times faster", times_faster)});
    csv.row(name, {clock.median_ms(), most_ms, static_cast<double>(clock.times_ms().size()), 1e3 * theirs_s});
    panel.x.categories.emplace_back(name);
    published_ms.push_back(1e3 * theirs_s);
    ours_ms.push_back(clock.median_ms());
  };
  for (std::size_t i = 0; i < stages.size(); ++i) add_row(kPlanningStages[i], stages[i], 10.0, "");
  add_row(kWhole, whole, 8.9 / 0.3, fmt::format("; {} plans found no way", failed));
  experiment.row({"insertion of a scan into the map [s]", short_number(1e-3 * insertion.median_ms(), 2),
                  Verdict::kNotJudged, fmt::format("median of {}", insertion.times_ms().size()),
                  1e-3 * insertion.median_ms()});
  panel.y.label = "median time [ms]";
  panel.y.log = true;
  panel.y.min = 0.01;
  panel.bars("published", published_ms).bars("ours", ours_ms);
  experiment.write("guidance-timing.csv", csv);
  experiment.write("guidance-timing.svg", figure);
}

void communication(Experiment& experiment) {
  const int seeds = experiment.repetitions(3, 1);
  std::vector<sim::Scenario> scenarios;
  for (int seed = 1; seed <= seeds; ++seed) {
    scenarios.push_back(quiet(scenario_with("guided_gap.yaml", static_cast<std::uint64_t>(seed))));
    if (!experiment.quick()) {
      scenarios.push_back(quiet(scenario_with("forest_guidance.yaml", static_cast<std::uint64_t>(seed))));
    }
  }
  std::vector<Listener> listeners(scenarios.size());
  fly(experiment, scenarios, [&](std::size_t i, const sim::Simulation& simulation) { listeners[i].take(simulation); });

  Traffic odometry, paths;
  double guided_s = 0.0;
  for (const Listener& listener : listeners) {
    guided_s += listener.guided_s;
    for (const auto& [to, from] : {std::pair(&odometry, &listener.odometry), std::pair(&paths, &listener.paths)}) {
      to->sizes_bytes.insert(to->sizes_bytes.end(), from->sizes_bytes.begin(), from->sizes_bytes.end());
    }
  }
  const std::string note = fmt::format("{:.0f} s of guiding in {} flights", guided_s, scenarios.size());
  const auto tell = [&](const std::string& name, const Traffic& traffic) {
    const double rate_hz = traffic.rate_hz(guided_s);
    experiment.within(name + ": rate [Hz]", rate_hz, 0.05, 3, note);
    experiment.at_most(name + ": smallest [kB]", traffic.least_kB(),
                       experiment.published(name + ": smallest [kB]").value, 3);
    experiment.at_most(name + ": largest [kB]", traffic.most_kB(), experiment.published(name + ": largest [kB]").value,
                       3);
    const std::string most = name + ": most a second [kB/s]";
    experiment.at_most(most, rate_hz * traffic.most_kB(), experiment.published(most).value, 3);
  };
  tell("odometry of the secondary", odometry);
  tell("path for the secondary", paths);

  CsvTable csv({"message", "bytes"});
  for (const double bytes : odometry.sizes_bytes) csv.row("odometry", {bytes});
  for (const double bytes : paths.sizes_bytes) csv.row("path", {bytes});
  experiment.write("messages.csv", csv);
  sim::plot::Figure figure("Sizes of the path messages (Fig. 9)", 1);
  sim::plot::Panel& panel = figure.add_panel();
  panel.x.label = "size [bytes]";
  panel.y.label = "messages";
  add_histogram(panel, paths.sizes_bytes, 16.0);
  experiment.write("communication.svg", figure);
}

}  // namespace swiftlet::tools
