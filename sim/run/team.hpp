// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "sim/run/agent_clock.hpp"
#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/sim/physics/physics_world.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

class Radio;
struct RadioStatistics;

/// The truth measured by sensors.
struct Truth {
  const PhysicsWorld& physics;
  const StateHistory& history;
};

/// Sensors and software of all vehicles, and their exchange with the truth in one tick; all indexed by VehicleId.
/// Different vehicles may sense and step in parallel.
struct Team {
  Team(const Scenario& scenario, const World& world, const std::vector<PhysicsVehicle>& vehicles,
       const std::vector<std::shared_ptr<const VehicleShape>>& shapes);
  Team(const Team&) = delete;

  int size() const { return static_cast<int>(agents.size()); }
  /// History for the sensors' look-back time, with a margin for a tick and for sensors with latency.
  StateHistory make_history(const Scenario& scenario) const;

  /// Clears the observations and delivers arrived messages.
  void begin_tick(TimeNs now, bool wants_overlays, Radio& radio);
  /// Due sensors measure the truth.
  void sense(VehicleId i, const Truth& truth);
  /// The agent processes its own observation.
  void step(VehicleId i);
  /// Enables timing of the agents' steps.
  void start_agent_clocks();
  /// Passes posted messages to the radio, in vehicle order.
  void send(Radio& radio, std::span<const VehicleState> states);
  /// Combines the hash of earlier ticks with states, observations and actions of this tick.
  std::uint64_t combined_hash(std::uint64_t before) const;
  /// Counters of all agents, with keys relative to the scenario, and of shared parts.
  std::vector<Counter> counters(const RadioStatistics& radio) const;

  std::vector<std::vector<std::unique_ptr<Sensor>>> sensors;
  std::vector<std::unique_ptr<Agent>> agents;
  std::vector<std::string> names;

  TimeNs now = 0;
  std::vector<Observation> observations;
  std::vector<const Action*> actions;
  std::vector<std::array<double, kMaxRotors>> commands;  // hold until the next tick
  std::vector<Clearance> clearances;
  std::vector<double> least_clearance_m;
  std::vector<std::vector<std::shared_ptr<const LabeledScan>>> scans;  // completed in this tick
  std::vector<std::uint64_t> hashes;
  std::vector<AgentClock> agent_clocks;  // empty: steps are not timed

 private:
  Action idle_;
};

}  // namespace swiftlet::sim
