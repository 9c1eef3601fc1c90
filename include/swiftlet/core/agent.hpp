// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/airframe.hpp"
#include "swiftlet/core/counter.hpp"
#include "swiftlet/core/observation.hpp"
#include "swiftlet/core/prior_map.hpp"

namespace swiftlet {

/// What a vehicle's software is told before the start.
struct AgentSetup {
  VehicleId self = 0;
  int num_vehicles = 1;
  std::vector<std::string> vehicle_names;      ///< by VehicleId
  Airframe airframe;                           ///< as identified; the truth may differ
  Pose T_world_body_start = Pose::Identity();  ///< where it was put down; the world frame as the operator sees it
  double tick_s = 0.004;
  std::shared_ptr<const PriorMap> prior_map;  ///< null: nothing is known
};

/// One vehicle's software. Knows nothing but its setup and its observations; has no clock, no files, no random numbers.
class Agent {
 public:
  virtual ~Agent() = default;
  /// One tick. The result belongs to the agent and is valid until the next call.
  virtual const Action& step(const Observation& observation) = 0;
  /// What did not fit its settings so far, with keys from the agent's own.
  virtual void append_counters(std::vector<Counter>& /*counters*/) const {}
};

}  // namespace swiftlet
