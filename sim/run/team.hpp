// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "sim/run/agent_clock.hpp"
#include "swiftlet/core/agent.hpp"
#include "swiftlet/sim/physics/physics_world.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

class Radio;
struct RadioStatistics;

/// The truth that sensors measure.
struct Truth {
  const PhysicsWorld& physics;
  const StateHistory& history;
};

/// Sensors and software of all vehicles, and what passes between them and the truth in one tick; all by VehicleId.
/// Different vehicles may sense and step at the same time.
struct Team {
  Team(const Scenario& scenario, const World& world, const std::vector<PhysicsVehicle>& vehicles,
       const std::vector<std::shared_ptr<const VehicleShape>>& shapes);
  Team(const Team&) = delete;

  int size() const { return static_cast<int>(agents.size()); }
  /// States that the sensors look back over, with a margin for a tick and for sensors with latency.
  StateHistory make_history(const Scenario& scenario) const;

  /// Empties the observations and hands over the messages that have arrived.
  void begin_tick(TimeNs now, bool wants_overlays, Radio& radio);
  /// Sensors that are due measure the truth.
  void sense(VehicleId i, const Truth& truth);
  /// The agent takes its own observation, and nothing else.
  void step(VehicleId i);
  /// From now on the agents' steps are timed.
  void start_agent_clocks();
  /// The radio takes what was said, in the order of the vehicles.
  void send(Radio& radio, std::span<const VehicleState> states);
  /// What the vehicles were and knew in this tick joins the hash of the ticks before.
  std::uint64_t combined_hash(std::uint64_t before) const;
  /// Of all agents, their keys put under where the agent stands in the scenario, and of what they share.
  std::vector<Counter> counters(const RadioStatistics& radio) const;

  std::vector<std::vector<std::unique_ptr<Sensor>>> sensors;
  std::vector<std::unique_ptr<Agent>> agents;
  std::vector<std::string> names;
  double clearance_max_m;

  TimeNs now = 0;
  std::vector<Observation> observations;
  std::vector<const Action*> actions;
  std::vector<std::array<double, kMaxRotors>> commands;  // hold until the next tick
  std::vector<Clearance> clearances;
  std::vector<double> least_clearance_m;
  std::vector<std::vector<std::shared_ptr<const LabeledScan>>> scans;  // completed in this tick
  std::vector<std::uint64_t> hashes;
  std::vector<AgentClock> agent_clocks;  // empty: their steps are not timed

 private:
  Action idle_;
};

}  // namespace swiftlet::sim
