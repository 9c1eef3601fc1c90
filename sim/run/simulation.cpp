// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/simulation.hpp"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <compare>
#include <cstdio>

#include "core/math/angles.hpp"
#include "sim/metrics/metrics.hpp"
#include "sim/radio/radio.hpp"
#include "sim/raycast/ray_scene.hpp"
#include "sim/render/snapshot_recorder.hpp"
#include "sim/run/build.hpp"
#include "sim/run/stage_clock.hpp"
#include "sim/run/state_hash.hpp"
#include "sim/run/summary.hpp"
#include "sim/world/world.hpp"

namespace swiftlet::sim {
namespace {

// Sensors look back over at most a sweep; the margin covers a tick and sensors with latency.
constexpr double kHistoryMargin_s = 0.05;

// From here on vehicles without LiDARs are worth several threads, which take so many at a time.
constexpr int kManyVehicles = 16;
constexpr int kVehiclesAtATime = 8;
constexpr int kPartsAtATime = 16;

// An agent whose step takes longer is worth being started before others' sweeps are traced.
constexpr double kLongStep_s = 1e-3;

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

struct Sweep {
  Sensor* sensor = nullptr;
  VehicleId vehicle = 0;
  int num_parts = 0;
};

/// Part of a sweep. In order of who waits for it, then of its heading: what one vehicle's beams brought from memory
/// serves the next one's.
struct Part {
  double minus_step_s = 0.0;  // of the agent that waits, if it is a long one
  int heading = 0;
  int sweep = 0;
  int number = 0;

  auto operator<=>(const Part&) const = default;
};

// A mission that has ended is flown on for this long, so that recordings show its end.
constexpr TimeNs kAfterTheEnd = kNsPerSecond / 2;

int history_capacity(const std::vector<std::vector<std::unique_ptr<Sensor>>>& sensors, const Scenario& scenario) {
  double look_back_s = 0.0;
  for (const auto& of_vehicle : sensors) {
    for (const auto& sensor : of_vehicle) look_back_s = std::max(look_back_s, sensor->look_back_s());
  }
  return static_cast<int>((look_back_s + scenario.tick_s + kHistoryMargin_s) / scenario.physics.step_s) + 2;
}

}  // namespace

World build_world(const Module& config, std::uint64_t seed) {
  auto scene = std::make_shared<const Scene>(make_world(config, seed));
  return {scene, std::make_shared<const StaticScene>(*scene)};
}

struct Simulation::Impl {
  Impl(Scenario scenario_in, int threads_in, std::optional<World> world_in)
      : scenario(with_truth_sensors(std::move(scenario_in))),
        threads(threads_in > 0 ? threads_in : omp_get_max_threads()),
        world(world_in ? std::move(*world_in) : build_world(scenario.world, scenario.seed_of_world())),
        names(vehicle_names(scenario)),
        shapes(make_vehicle_shapes(scenario)),
        vehicles(make_physics_vehicles(scenario, *world.static_scene)),
        physics(scenario.physics, scenario.wind, vehicles, world.static_scene, scenario.seed),
        sensors(make_sensors(scenario, world, shapes)),
        agents(make_agents(scenario, vehicles, *world.scene)),
        history(num_vehicles(), history_capacity(sensors, scenario)),
        radio(scenario.radio, scenario.seed, names, world.static_scene),
        metrics(scenario.metrics, names, perception_of(scenario)),
        tick_length(from_seconds(scenario.tick_s)),
        duration(from_seconds(scenario.duration_s)),
        observations(num_vehicles()),
        actions(num_vehicles(), &idle),
        commands(num_vehicles()),
        clearances(num_vehicles()),
        least_clearance_m(num_vehicles()),
        scans(num_vehicles()),
        hashes(num_vehicles()),
        parts_left(num_vehicles()),
        step_s(num_vehicles()),
        corrections(num_vehicles(), 0),
        missions(num_vehicles(), MissionStatus::kRunning),
        mission_notes(num_vehicles()),
        ended(num_vehicles(), false) {
    for (int i = 0; i < num_vehicles(); ++i) history.push(i, physics.state(i));
    info.scenario = &scenario;
    info.scene = world.scene.get();
    info.vehicle_names = names;
    info.vehicle_shapes = shapes;
    info.series = metrics.series();
    for (const VehicleConfig& vehicle : scenario.vehicles) info.airframes.push_back(&vehicle.airframe);
  }

  int num_vehicles() const { return static_cast<int>(vehicles.size()); }

  void tick();
  int vehicles_at_a_time() const;
  void begin_sweeps();
  void sense_and_step_with_sweeps();
  void sense(VehicleId i);
  void step(VehicleId i) { actions[i] = &agents[i]->step(observations[i]); }
  void collect_events();
  void note_correction(VehicleId i);
  void note_mission(VehicleId i);

  Scenario scenario;
  int threads;
  World world;
  std::vector<std::string> names;
  std::vector<std::shared_ptr<const VehicleShape>> shapes;
  std::vector<PhysicsVehicle> vehicles;
  PhysicsWorld physics;
  std::vector<std::vector<std::unique_ptr<Sensor>>> sensors;
  std::vector<std::unique_ptr<Agent>> agents;
  StateHistory history;
  Radio radio;
  Metrics metrics;
  std::vector<std::unique_ptr<Recorder>> recorders;
  RunInfo info;

  TimeNs now = 0;
  TimeNs tick_length;
  TimeNs duration;
  TimeNs end_of_missions = -1;
  std::uint64_t hash = 0;
  Action idle;
  std::vector<Observation> observations;
  std::vector<const Action*> actions;
  std::vector<std::array<double, kMaxRotors>> commands;
  std::vector<Clearance> clearances;
  std::vector<double> least_clearance_m;
  std::vector<std::vector<std::shared_ptr<const LabeledScan>>> scans;
  std::vector<std::uint64_t> hashes;
  std::vector<Sweep> sweeps;                 // due in this tick
  std::vector<Part> parts;                   // of theirs
  std::vector<std::atomic<int>> parts_left;  // by vehicle
  std::vector<double> step_s;                // by vehicle: wall time of its agent's last step with a sweep
  std::vector<Event> events;
  std::vector<std::uint32_t> corrections;  // by vehicle: the last correction_revision
  std::vector<MissionStatus> missions;
  std::vector<std::string> mission_notes;
  std::vector<bool> ended;
  int num_crashes = 0;
  StageClock clock;
  TickView view;
};

// One tick. What is parallel touches one vehicle only; everything that joins vehicles goes in their order, so the
// result is the same for any number of threads.
void Simulation::Impl::tick() {
  omp_set_num_threads(threads);
  const TimeNs previous = now;
  const bool first = previous == 0;
  now += tick_length;

  // 1. Truth moves, at its own finer step.
  {
    const auto timed = clock.measure(Stage::kPhysics);
    physics.advance(now, commands, history);
  }
  // 2. Sensors that are due measure the truth; the radio hands over what has arrived.
  {
    const auto timed = clock.measure(Stage::kSensors);
    const bool pictures = wants_picture(scenario.snapshots, first ? -1 : previous, now);
    for (int i = 0; i < num_vehicles(); ++i) {
      radio.recycle(observations[i].messages);
      observations[i].clear();
      observations[i].t = now;
      observations[i].self = i;
      observations[i].wants_overlays = pictures;
      radio.deliver(i, now, observations[i].messages);
    }
  }
  // 3. Every agent steps on its own observation.
  const int share = vehicles_at_a_time();
  if (share == 1) {
    sense_and_step_with_sweeps();
  } else {
    {
      const auto timed = clock.measure(Stage::kSensors);
#pragma omp parallel for schedule(dynamic, std::max(share, 1)) if (share > 0)
      for (int i = 0; i < num_vehicles(); ++i) sense(i);
    }
    const auto timed = clock.measure(Stage::kAgents);
#pragma omp parallel for schedule(dynamic, std::max(share, 1)) if (share > 0)
    for (int i = 0; i < num_vehicles(); ++i) step(i);
  }
  for (int i = 0; i < num_vehicles(); ++i) commands[i] = actions[i]->rotor_command;
  // 4. The radio takes the messages, in vehicle order.
  {
    const auto timed = clock.measure(Stage::kRadio);
    for (int i = 0; i < num_vehicles(); ++i) radio.post(i, now, actions[i]->messages, physics.states());
  }
  // 5. Metrics compare truth and estimates; recorders write.
  {
    const auto timed = clock.measure(Stage::kMetrics);
    collect_events();
    for (int i = 0; i < num_vehicles(); ++i) hash = combine(hash, hashes[i]);
    view = {now, physics.states(), observations, actions, scans, events, least_clearance_m};
    metrics.update(view, clearances);
  }
  {
    const auto timed = clock.measure(Stage::kRecorders);
    for (const auto& recorder : recorders) recorder->write(view);
  }
}

// How many a thread takes from the heap: a sweep of a LiDAR is worth a thread of its own, other sensors and controllers
// only where there are many. 0: one thread does all, which costs less than starting others.
int Simulation::Impl::vehicles_at_a_time() const {
  if (num_vehicles() < 2) return 0;  // a lone LiDAR is parallel inside
  for (const auto& of_vehicle : sensors) {
    for (const auto& sensor : of_vehicle) {
      if (sensor->makes_scan_by(now)) return 1;
    }
  }
  return num_vehicles() >= kManyVehicles ? kVehiclesAtATime : 0;
}

// The sweeps that are due, in parts.
void Simulation::Impl::begin_sweeps() {
  sweeps.clear();
  for (int i = 0; i < num_vehicles(); ++i) {
    for (const auto& sensor : sensors[i]) {
      if (sensor->makes_scan_by(now)) sweeps.push_back({sensor.get(), i, 0});
    }
    parts_left[i] = 0;
  }
#pragma omp parallel for schedule(dynamic, 1)
  for (Sweep& sweep : sweeps) sweep.num_parts = sweep.sensor->begin_sweep(now, history);

  parts.clear();
  for (int s = 0; s < static_cast<int>(sweeps.size()); ++s) {
    const Sweep& sweep = sweeps[s];
    parts_left[sweep.vehicle] += sweep.num_parts;
    const double step = step_s[sweep.vehicle] > kLongStep_s ? step_s[sweep.vehicle] : 0.0;
    for (int k = 0; k < sweep.num_parts; ++k) parts.push_back({-step, sweep.sensor->heading_of_part(k), s, k});
  }
  std::sort(parts.begin(), parts.end());
}

// Threads share the parts of the sweeps. Who traces the last one of a vehicle goes on with its other sensors and its
// agent, while others trace: an agent that detects keeps one thread as busy as the sweeps keep the rest. Only the order
// of the work depends on how long it took.
void Simulation::Impl::sense_and_step_with_sweeps() {
  const auto start = Clock::now();
  begin_sweeps();
  std::atomic<double> busy_s = 0.0, stepping_s = 0.0;
#pragma omp parallel
  {
    const auto thread_start = Clock::now();
    const auto sense_and_step = [&](VehicleId i) {
      sense(i);
      const auto step_start = Clock::now();
      step(i);
      step_s[i] = seconds_since(step_start);
      stepping_s += step_s[i];
    };
#pragma omp for schedule(dynamic, 1)
    for (int i = 0; i < num_vehicles(); ++i) {
      if (parts_left[i] == 0) sense_and_step(i);
    }
#pragma omp for schedule(dynamic, kPartsAtATime) nowait
    for (const Part& part : parts) {
      const Sweep& sweep = sweeps[part.sweep];
      sweep.sensor->trace_part(part.number);
      if (--parts_left[sweep.vehicle] == 0) sense_and_step(sweep.vehicle);
    }
    busy_s += seconds_since(thread_start);
  }
  const double agents_s = seconds_since(start) * stepping_s / busy_s;
  clock.add(Stage::kAgents, agents_s);
  clock.add(Stage::kSensors, seconds_since(start) - agents_s);
}

void Simulation::Impl::sense(VehicleId i) {
  scans[i].clear();
  for (const auto& sensor : sensors[i]) {
    sensor->measure(now, history, observations[i]);
    for (const auto& scan : sensor->scans()) scans[i].push_back(scan);
  }
  clearances[i] = physics.clearance(i, scenario.metrics.clearance_max_m);
  least_clearance_m[i] = std::min(clearances[i].surface_m, clearances[i].vehicle_m);
  hashes[i] = combine(hash_of(physics.state(i)), hash_of(observations[i]));
}

void Simulation::Impl::collect_events() {
  events.clear();
  for (const Crash& crash : physics.crashes()) {
    ++num_crashes;
    ended[crash.vehicle] = true;
    Event event{crash.t, "crash", crash.vehicle, {}, crash.p_world_m, {}};
    if (crash.other_vehicle != kNoVehicle) {
      event.partner = names[crash.other_vehicle];
    } else {
      event.partner = name_of(crash.surface_class);
      if (crash.instance) event.partner.append(" ").append(std::to_string(crash.instance));
    }
    event.note = "at " + std::to_string(crash.speed_mps) + " m/s";
    events.push_back(std::move(event));
  }
  for (int i = 0; i < num_vehicles(); ++i) {
    note_correction(i);
    note_mission(i);
  }
  if (end_of_missions < 0 && num_vehicles() > 0 && std::all_of(ended.begin(), ended.end(), [](bool e) { return e; })) {
    end_of_missions = now + kAfterTheEnd;
  }
}

void Simulation::Impl::note_correction(VehicleId i) {
  const StateEstimate& estimate = actions[i]->estimate;
  if (estimate.correction_revision == corrections[i]) return;
  corrections[i] = estimate.correction_revision;
  const Vector3& p_m = estimate.T_world_local.translation();
  const double yaw_deg = yaw_of(estimate.T_world_local.linear()) / kRadPerDeg;
  char note[120];
  std::snprintf(note, sizeof note, "the local frame lies at %.3f, %.3f, %.3f m and is turned by %.2f deg", p_m.x(),
                p_m.y(), p_m.z(), yaw_deg);
  events.push_back({now, "correction", i, {}, physics.state(i).p_world_m, note});
}

void Simulation::Impl::note_mission(VehicleId i) {
  const Action& action = *actions[i];
  if (action.mission == missions[i] && action.mission_note == mission_notes[i]) return;
  missions[i] = action.mission;
  mission_notes[i] = action.mission_note;
  const bool over = action.mission == MissionStatus::kDone || action.mission == MissionStatus::kFailed;
  ended[i] = ended[i] || over;
  if (!over && action.mission_note.empty()) return;
  const char* status = action.mission == MissionStatus::kDone     ? "mission_done"
                       : action.mission == MissionStatus::kFailed ? "mission_failed"
                                                                  : "mission";
  events.push_back({now, status, i, {}, physics.state(i).p_world_m, action.mission_note});
}

Simulation::Simulation(Scenario scenario, int threads, std::optional<World> world)
    : impl_(std::make_unique<Impl>(std::move(scenario), threads, std::move(world))) {}

Simulation::~Simulation() = default;

void Simulation::attach_recorders(const std::filesystem::path& directory) {
  const Scenario& scenario = impl_->scenario;
  for (const Module& config : scenario.recorders) attach(make_recorder(config), directory);
  if (!scenario.snapshots.empty()) attach(make_snapshot_recorder(scenario.snapshots), directory);
}

void Simulation::attach(std::unique_ptr<Recorder> recorder, const std::filesystem::path& directory) {
  impl_->info.directory = directory;
  recorder->begin(impl_->info);
  impl_->recorders.push_back(std::move(recorder));
}

void Simulation::tick() { impl_->tick(); }

bool Simulation::finished() const {
  const MetricsConfig& metrics = impl_->scenario.metrics;
  return impl_->now >= impl_->duration || (metrics.stop_on_crash && impl_->num_crashes > 0) ||
         (metrics.stop_when_done && impl_->end_of_missions >= 0 && impl_->now >= impl_->end_of_missions);
}

TimeNs Simulation::now() const { return impl_->now; }
const Scenario& Simulation::scenario() const { return impl_->scenario; }
const TickView& Simulation::view() const { return impl_->view; }
const RunInfo& Simulation::info() const { return impl_->info; }
std::uint64_t Simulation::state_hash() const { return impl_->hash; }

std::vector<std::filesystem::path> Simulation::finish() {
  std::vector<std::filesystem::path> paths;
  for (const auto& recorder : impl_->recorders) {
    for (auto& path : recorder->finish()) paths.push_back(std::move(path));
  }
  impl_->recorders.clear();
  return paths;
}

RunSummary Simulation::summary() const {
  RunSummary summary;
  summary.scenario = impl_->scenario.name;
  summary.seed = impl_->scenario.seed;
  summary.state_hash = impl_->hash;
  summary.threads = impl_->threads;
  summary.simulated_s = static_cast<double>(impl_->now) / 1e9;  // nearest to the decimal fraction, for readers
  summary.stage_wall_s = impl_->clock.seconds_by_stage();
  summary.outcome = impl_->metrics.outcome();
  summary.metrics = impl_->metrics.report();
  summary.radio = impl_->radio.statistics();
  summary.radio_topics = impl_->radio.topics();
  return summary;
}

}  // namespace swiftlet::sim
