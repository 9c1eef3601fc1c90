// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/guidance/rbl_config.hpp"

namespace swiftlet {

/// State changed by the rules.
struct RblState {
  double beta_m = 1.5;
  double theta_rad = 0.0;  ///< rotation of the destination to the right
  double phi_rad = 0.0;    ///< rotation of the destination upward
};

/// Inputs of the rules, in the agent's frame.
struct RblSituation {
  Vector3 goal_agent_m = Vector3::Zero();
  Vector3 partitioned_agent_m = Vector3::Zero();  ///< c_A with the present destination
  Vector3 sensing_agent_m = Vector3::Zero();      ///< c_S with the present destination
  Vector3 unrotated_agent_m = Vector3::Zero();    ///< c_A with the goal as destination
};

/// Applies all rules once.
/// @param planar  norms and rules of the 2D algorithm: no elevation
RblState apply_rules(const RblRules& rules, const RblSituation& now, const RblState& state, double dt_s, bool planar);

/// Destination (2.20) relative to the agent: the goal turned to the right by theta and up by phi, distance kept.
Vector3 rbl_destination(const RblRules& rules, const Vector3& goal_agent_m, const RblState& state);

/// C_influence (2.16 to 2.18); positive: climb.
/// @param phi_rad  elevation of the present destination
double vertical_influence(const RblRules& rules, const RblSituation& now, double phi_rad = 0.0);

/// Omega (2.15): condition for flight above or below the direct path to the goal.
bool wants_elevation(const RblRules& rules, const RblSituation& now);

}  // namespace swiftlet
