// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/run/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "sim/run/build.hpp"
#include "sim/run/event_log.hpp"
#include "sim/run/sweep_schedule.hpp"
#include "sim/run/team.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/metrics/metrics.hpp"
#include "swiftlet/sim/parallel/crew.hpp"
#include "swiftlet/sim/radio/radio.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/render/snapshot_recorder.hpp"
#include "swiftlet/sim/run/memory.hpp"
#include "swiftlet/sim/run/processors.hpp"
#include "swiftlet/sim/run/summary.hpp"

namespace swiftlet::sim {

struct Simulation::Impl {
  /// Requires the crew on duty.
  Impl(Scenario scenario_in, std::unique_ptr<Crew> crew_in, std::optional<World> world_in)
      : crew(std::move(crew_in)),
        scenario(with_truth_sensors(std::move(scenario_in))),
        world(world_in ? std::move(*world_in) : build_world(scenario.world, scenario.seed_of_world())),
        vehicles(make_physics_vehicles(scenario, *world.static_scene)),
        info(make_run_info(scenario, world)),
        physics(scenario.physics, scenario.wind, vehicles, world.static_scene, scenario.seed),
        team(scenario, world, vehicles, info.vehicle_shapes),
        history(team.make_history(scenario)),
        schedule(team.size()),
        radio(scenario.radio, scenario.seed, info.vehicle_names, world.static_scene),
        events(info.vehicle_names, perception_of(scenario)),
        metrics(scenario.metrics, info.vehicle_names, perception_of(scenario)),
        has_missions(std::ranges::any_of(scenario.vehicles, [](const auto& v) { return v.agent.type != "none"; })),
        tick_length(from_seconds(scenario.tick_s)) {
    info.series = metrics.series();
    for (int i = 0; i < team.size(); ++i) history.push(i, physics.state(i));
    view = {now, physics.states(), team.observations, team.actions, team.scans, {}, {}, team.agents};
  }

  void tick();

  std::unique_ptr<Crew> crew;
  Scenario scenario;
  World world;
  std::vector<PhysicsVehicle> vehicles;
  RunInfo info;
  PhysicsWorld physics;
  Team team;
  StateHistory history;
  SweepSchedule schedule;
  Radio radio;
  EventLog events;
  Metrics metrics;
  std::vector<std::unique_ptr<Recorder>> recorders;

  bool has_missions;  // a run without missions lasts for its full duration
  TimeNs now = 0;
  TimeNs tick_length;
  std::uint64_t hash = 0;
  StageClock clock;
  TickView view;
};

// One tick. Parallel sections touch only one vehicle each, and interactions are processed in vehicle order, so that the
// result is the same for any number of threads.
void Simulation::Impl::tick() {
  const Crew::Duty duty(*crew);
  if (now == 0) {
    const auto timed = clock.measure(Stage::kRecorders);
    for (const auto& recorder : recorders) recorder->write_start(view);
  }
  const TimeNs previous = now == 0 ? -1 : now;
  now += tick_length;

  // 1. Physics advances the truth, with its own finer step.
  {
    const auto timed = clock.measure(Stage::kPhysics);
    physics.advance(now, team.commands, history);
  }
  // 2. Due sensors measure the truth; the radio delivers arrived messages.
  {
    const auto timed = clock.measure(Stage::kSensors);
    const bool wants_overlays = wants_picture(scenario.snapshots, previous, now) ||
                                std::ranges::any_of(recorders, [&](const auto& r) { return r->wants_overlays(now); });
    team.begin_tick(now, wants_overlays, radio);
  }
  // 3. Every agent steps on its own observation, as soon as its sensors have measured.
  schedule.sense_and_step(team, {physics, history}, clock);
  // 4. The radio accepts new messages.
  {
    const auto timed = clock.measure(Stage::kRadio);
    team.send(radio, physics.states());
  }
  // 5. Metrics compare truth and estimates; recorders write.
  {
    const auto timed = clock.measure(Stage::kMetrics);
    events.collect(now, physics, team.actions);
    hash = team.combined_hash(hash);
    view = {now,        physics.states(),      team.observations,      team.actions,
            team.scans, events.of_this_tick(), team.least_clearance_m, team.agents};
    metrics.update(view, team.clearances);
    if (const auto* captures = series_of<CaptureRecord>(metrics.series())) events.note_captures(now, *captures);
    view.events = events.of_this_tick();
  }
  {
    const auto timed = clock.measure(Stage::kRecorders);
    for (const auto& recorder : recorders) recorder->write(view);
  }
}

Simulation::Simulation(Scenario scenario, int threads, std::optional<World> world) {
  require_memory(scenario);
  const int usual_threads = default_threads();  // throws on an invalid OMP_NUM_THREADS
  if (threads > kMaxThreads) {
    throw InputError("threads: expected a whole number in [0, " + std::to_string(kMaxThreads) + "], found " +
                     std::to_string(threads));
  }
  try {
    auto crew = std::make_unique<Crew>(threads > 0 ? threads : usual_threads);
    const Crew::Duty duty(*crew);
    impl_ = std::make_unique<Impl>(std::move(scenario), std::move(crew), std::move(world));
  } catch (const OutOfMemory&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw OutOfMemory("while the world and the vehicles are made");
  }
}

Simulation::~Simulation() = default;

void Simulation::attach_recorders(const std::filesystem::path& directory) {
  for (const Module& config : scenario().recorders) attach(make_recorder(config), directory);
  if (scenario().snapshots.empty()) return;
  require_pictures(scenario().snapshots_place, "; or fly without them: --set snapshots=[]");
  attach(make_snapshot_recorder(scenario().snapshots), directory);
}

void Simulation::attach(std::unique_ptr<Recorder> recorder, const std::filesystem::path& directory) {
  impl_->info.directory = directory;
  recorder->begin(impl_->info);
  impl_->recorders.push_back(std::move(recorder));
}

void Simulation::tick() {
  try {
    impl_->tick();
  } catch (const OutOfMemory&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw OutOfMemory("in the stage " + std::string(kStageNames[static_cast<std::size_t>(impl_->clock.latest())]) +
                      fmt::format(" at {:f} s", to_seconds(impl_->now)));
  }
}

bool Simulation::finished() const {
  const MetricsConfig& until = scenario().metrics;
  return now() >= from_seconds(scenario().duration_s) || (until.stop_on_crash && impl_->events.crashed()) ||
         (until.stop_when_done && impl_->has_missions && impl_->events.all_is_over(now()));
}

TimeNs Simulation::now() const { return impl_->now; }
const Scenario& Simulation::scenario() const { return impl_->scenario; }
const TickView& Simulation::view() const { return impl_->view; }
const RunInfo& Simulation::info() const { return impl_->info; }
std::uint64_t Simulation::state_hash() const { return impl_->hash; }

void Simulation::time_agents() { impl_->team.start_agent_clocks(); }

std::vector<std::pair<std::string, double>> Simulation::agent_stage_s() const {
  std::vector<std::pair<std::string, double>> named;
  for (std::size_t i = 0; i < kAgentStageNames.size(); ++i) {
    double sum_s = 0.0;
    for (const AgentClock& clock : impl_->team.agent_clocks) sum_s += clock.seconds(static_cast<AgentStage>(i));
    named.emplace_back(kAgentStageNames[i], sum_s);
  }
  return named;
}

std::vector<std::filesystem::path> Simulation::finish() {
  std::vector<std::filesystem::path> paths;
  for (const auto& recorder : impl_->recorders) {
    for (auto& path : recorder->finish()) paths.push_back(std::move(path));
  }
  impl_->recorders.clear();
  return paths;
}

RunSummary Simulation::summary() const {
  std::vector<Counter> counters = impl_->world.scene->counters;
  for (Counter& counter : impl_->team.counters(impl_->radio.statistics())) counters.push_back(std::move(counter));
  return {.scenario = scenario().name,
          .seed = scenario().seed,
          .outcome = impl_->metrics.outcome(),
          .state_hash = impl_->hash,
          .threads = impl_->crew->num_threads(),
          .simulated_s = static_cast<double>(now()) / 1e9,  // nearest to the decimal fraction, for display
          .stage_wall_s = impl_->clock.seconds_by_stage(),
          .metrics = impl_->metrics.report(),
          .radio = impl_->radio.statistics(),
          .radio_topics = impl_->radio.topics(),
          .counters = std::move(counters)};
}

}  // namespace swiftlet::sim
