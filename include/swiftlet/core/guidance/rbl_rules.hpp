// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Rules of the 3D rule-based Lloyd algorithm [Kamler 2025, eqs. 2.7 to 2.20]. Where the document is ambiguous or
/// differs from its authors' program, the interpretation is an option, or fixed (docs/rbl.md).
struct RblRules {
  double weight_near_m = 0.5;       ///< d_1
  double weight_gap_m = 1.0;        ///< d_2
  double weight_goal_m = 3.5;       ///< goal distance below which beta falls too; 0: never, as in the document
  double azimuth_near_m = 0.5;      ///< d_3
  double azimuth_gap_m = 1.0;       ///< d_4
  double elevation_near_m = 0.5;    ///< d_5
  double elevation_gap_m = 1.0;     ///< d_6
  double elevation_shrink_m = 0.2;  ///< d_7
  double beta_desired_m = 1.5;      ///< beta^D
  double beta_min_m = 0.1;          ///< beta_min; not in the document
  double weight_rate_mps = 1.0;     ///< k of (2.7)
  double azimuth_rate_radps = 1.0;  ///< k of (2.8)
  double azimuth_return_radps = 2.0;
  double elevation_rate_radps = 1.0;  ///< k of (2.19)
  double centering_weight = 0.7;      ///< w_1
  double direction_weight = 0.3;      ///< w_2
  enum class AzimuthCondition { kNear, kPrinted };
  AzimuthCondition azimuth_condition = AzimuthCondition::kNear;
  enum class AzimuthReset { kDetour, kNear, kNone };
  AzimuthReset azimuth_reset = AzimuthReset::kDetour;
  enum class ElevationCondition { kGap, kPrinted };
  ElevationCondition elevation_condition = ElevationCondition::kGap;
  enum class DirectionInfluence { kNorth, kPrinted, kProgram };
  DirectionInfluence direction_influence = DirectionInfluence::kNorth;
  enum class ElevationSense { kLevel, kUp, kPrinted };
  ElevationSense elevation_sense = ElevationSense::kLevel;
  bool azimuth_rule = true;
  bool elevation_rule = true;  ///< z-rule (2.15) to (2.19); RblConfig enables it for the variant 3d_z only

  void visit(ConfigVisitor& v);
};

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
