// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/team.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "sim/run/build.hpp"
#include "sim/run/finite_values.hpp"
#include "sim/run/state_hash.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/radio/radio.hpp"
#include "swiftlet/sim/run/memory.hpp"

namespace swiftlet::sim {
namespace {

// [s] Length of the history beyond the look-back of the sensors.
constexpr double kHistoryMargin_s = 0.05;
constexpr double kMaxStates = 1e9;  // states of a vehicle in the history, whose indices are of type int

}  // namespace

Team::Team(const Scenario& scenario, const World& world, const std::vector<PhysicsVehicle>& vehicles,
           const std::vector<std::shared_ptr<const VehicleShape>>& shapes)
    : sensors(make_sensors(scenario, world, shapes)),
      agents(make_agents(scenario, vehicles, *world.scene)),
      names(vehicle_names(scenario)),
      observations(agents.size()),
      actions(agents.size(), &idle_),
      commands(agents.size()),
      clearances(agents.size()),
      least_clearance_m(agents.size()),
      scans(agents.size()),
      hashes(agents.size()) {
  const Vector3 none = Vector3::Constant(std::numeric_limits<double>::quiet_NaN());
  idle_.reference = {none, none, none, none.x(), none.x()};
}

StateHistory Team::make_history(const Scenario& scenario) const {
  double look_back_s = 0.0;
  std::string key = "physics.step_s";  // the setting that determines the history's length
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    for (std::size_t k = 0; k < sensors[i].size(); ++k) {
      if (sensors[i][k]->look_back_s() <= look_back_s) continue;
      look_back_s = sensors[i][k]->look_back_s();
      key = "vehicles[" + std::to_string(i) + "].sensors[" + std::to_string(k) + "]";
    }
  }
  const double num_states = (look_back_s + scenario.tick_s + kHistoryMargin_s) / scenario.physics.step_s + 2.0;
  require_memory(key, num_states * sizeof(VehicleState) * static_cast<double>(sensors.size()));
  if (!(num_states <= kMaxStates)) {
    throw InputError(
        fmt::format("{}: expected a history of at most {:g} states of each vehicle, found {:g}; reduce "
                    "the latency, or increase physics.step_s",
                    key, kMaxStates, num_states));
  }
  return {size(), static_cast<int>(num_states)};
}

void Team::begin_tick(TimeNs t, bool wants_overlays, Radio& radio) {
  now = t;
  for (int i = 0; i < size(); ++i) {
    Observation& observation = observations[i];
    radio.recycle(observation.messages);
    observation.clear();
    observation.t = now;
    observation.self = i;
    observation.wants_overlays = wants_overlays;
    radio.deliver(i, now, observation.messages);
  }
}

void Team::sense(VehicleId i, const Truth& truth) try {
  scans[i].clear();
  for (const auto& sensor : sensors[i]) {
    sensor->measure(now, truth.history, observations[i]);
    for (const auto& scan : sensor->scans()) scans[i].push_back(scan);
  }
  ensure_finite(observations[i]);
  clearances[i] = truth.physics.clearance(i, MetricsConfig::kClearanceMax_m);
  least_clearance_m[i] = std::min(clearances[i].surface_m, clearances[i].vehicle_m);
  hashes[i] = combine(hash_of(truth.physics.state(i)), hash_of(observations[i]));
} catch (const std::bad_alloc&) {
  throw OutOfMemory("at the sensors of " + names[i] + fmt::format(" at {:f} s", to_seconds(now)));
}

void Team::step(VehicleId i) try {
  AgentClock* const clock = agent_clocks.empty() ? nullptr : &agent_clocks[i];
  if (clock != nullptr) clock->start();
  actions[i] = &agents[i]->step(observations[i]);
  ensure_finite(*actions[i]);
  hashes[i] = combine(hashes[i], hash_of(*actions[i]));
  commands[i] = actions[i]->rotor_command;
  if (clock != nullptr) clock->stop();
} catch (const std::bad_alloc&) {
  throw OutOfMemory("at the agent of " + names[i] + fmt::format(" at {:f} s", to_seconds(now)));
}

void Team::start_agent_clocks() {
  agent_clocks.assign(agents.size(), {});
  for (std::size_t i = 0; i < agents.size(); ++i) {
    if (auto* const agent = dynamic_cast<StageNotifier*>(agents[i].get()))
      agent->set_stage_listener([&clock = agent_clocks[i]](AgentStage stage) { clock.begin(stage); });
  }
}

void Team::send(Radio& radio, std::span<const VehicleState> states) {
  for (int i = 0; i < size(); ++i) radio.post(i, now, actions[i]->messages, states);
}

std::uint64_t Team::combined_hash(std::uint64_t before) const {
  for (const std::uint64_t hash : hashes) before = combine(before, hash);
  return before;
}

std::vector<Counter> Team::counters(const RadioStatistics& radio) const {
  std::vector<Counter> all = {
      {"messages dropped from full queues", radio.dropped, radio.dropped + radio.sent, "radio.queue_limit_kB"}};
  for (std::size_t i = 0; i < agents.size(); ++i) {
    const std::size_t first = all.size();
    agents[i]->append_counters(all);
    const std::string place = "vehicles[" + std::to_string(i) + "].agent.";
    for (std::size_t k = first; k < all.size(); ++k) all[k].setting.insert(0, place);
  }
  return all;
}

}  // namespace swiftlet::sim
