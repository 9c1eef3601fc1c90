// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/rbl_rules.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [rad] Limits of the turn of the destination: theta of (2.8), (2.11), and phi of (2.19). Larger values fly away from
/// the goal.
constexpr double kMaxAzimuth_rad = kPi / 2.0, kMaxElevation_rad = kPi / 4.0;

double length_xy(const Vector3& v) { return elementary::hypot(v.x(), v.y()); }

double toward_zero(double value, double step) {
  return value > 0.0 ? std::max(0.0, value - step) : std::min(0.0, value + step);
}

// Next beta [m] (2.7). beta also falls with the goal in reach: with a large beta, neighbors that rest at their own
// goals shift the centroid, and keep the vehicle off its goal or out of the gap between them indefinitely.
double next_beta(const RblRules& rules, const RblSituation& now, double beta_m, double dt_s) {
  const bool goal_in_reach = now.goal_agent_m.norm() < rules.weight_goal_m;
  const bool cut_off = (now.partitioned_agent_m - now.sensing_agent_m).norm() > rules.weight_gap_m;
  const bool stuck = now.partitioned_agent_m.norm() < rules.weight_near_m && (cut_off || goal_in_reach);
  if (stuck) return std::max(rules.beta_min_m, beta_m - rules.weight_rate_mps * dt_s);
  return std::max(rules.beta_min_m, beta_m - (beta_m - rules.beta_desired_m) * std::min(dt_s, 1.0));
}

// Next turn [rad] of the destination to the right (2.8), (2.11), then the reset (2.9), (2.12).
double next_theta(const RblRules& rules, const RblSituation& now, double theta_rad, double dt_s) {
  const double gap_m = length_xy(now.partitioned_agent_m - now.sensing_agent_m);
  const double reach_m = length_xy(now.partitioned_agent_m);
  const bool near = rules.azimuth_condition == RblRules::AzimuthCondition::kNear ? reach_m < rules.azimuth_near_m
                                                                                 : reach_m > rules.azimuth_near_m;
  const bool turn = gap_m > rules.azimuth_gap_m && near;
  const double next = turn ? std::min(kMaxAzimuth_rad, theta_rad + rules.azimuth_rate_radps * dt_s)
                           : std::max(0.0, theta_rad - rules.azimuth_return_radps * dt_s);
  const double direct_m = length_xy(now.unrotated_agent_m);
  const bool clear = rules.azimuth_reset == RblRules::AzimuthReset::kDetour
                         ? direct_m > reach_m
                         : rules.azimuth_reset == RblRules::AzimuthReset::kNear && direct_m > rules.azimuth_near_m;
  return next >= kMaxAzimuth_rad && clear ? 0.0 : next;
}

// Replaces c_S,z - p_z in (2.18). c_S lies towards the destination, so a destination turned up by (2.20) would keep
// turning up. "level" subtracts the effect of the present turn and keeps that of the height limits.
double centering(const RblRules& rules, const RblSituation& now, double phi_rad) {
  if (rules.elevation_sense != RblRules::ElevationSense::kLevel) return now.sensing_agent_m.z();
  const double goal_rad = elementary::atan2(now.goal_agent_m.z(), length_xy(now.goal_agent_m));
  const double reach_m = now.sensing_agent_m.norm();
  const double turned_m = reach_m * elementary::sin(std::clamp(goal_rad + phi_rad, -0.5 * kPi, 0.5 * kPi));
  return (now.sensing_agent_m.z() - turned_m) - (turned_m - reach_m * elementary::sin(goal_rad));
}

// Next turn [rad] of the destination up (2.19), then the reset of the released program.
double next_phi(const RblRules& rules, const RblSituation& now, double phi_rad, double dt_s) {
  const double step = rules.elevation_rate_radps * dt_s;
  double next = toward_zero(phi_rad, step);
  if (wants_elevation(rules, now)) {
    const double sense = vertical_influence(rules, now, phi_rad) > 0.0 ? 1.0 : -1.0;
    next = std::clamp(phi_rad + sense * step, -kMaxElevation_rad, kMaxElevation_rad);
  }
  const bool is_counterproductive = std::abs(now.partitioned_agent_m.z()) > std::abs(now.unrotated_agent_m.z());
  return std::abs(next) >= kMaxElevation_rad && is_counterproductive ? 0.0 : next;
}

}  // namespace

bool wants_elevation(const RblRules& rules, const RblSituation& now) {
  const double gap_m = std::abs(now.partitioned_agent_m.z() - now.sensing_agent_m.z());
  const bool apart = rules.elevation_condition == RblRules::ElevationCondition::kGap ? gap_m > rules.elevation_gap_m
                                                                                     : gap_m < rules.elevation_gap_m;
  const double shrink_m = length_xy(now.sensing_agent_m) - length_xy(now.partitioned_agent_m);
  // The document takes the absolute value of shrink_m. A level path that neighbors do not shorten needs no elevation.
  const bool shrunk = shrink_m > rules.elevation_shrink_m;
  return (apart && std::abs(now.partitioned_agent_m.z()) < rules.elevation_near_m) || shrunk;
}

double vertical_influence(const RblRules& rules, const RblSituation& now, double phi_rad) {
  const Vector3& goal = now.goal_agent_m;
  const double horizontal_m = length_xy(goal);
  double direction = 0.0;
  if (horizontal_m > 0.0) {
    if (rules.direction_influence == RblRules::DirectionInfluence::kNorth) {
      direction = goal.y() / horizontal_m;
    } else if (rules.direction_influence == RblRules::DirectionInfluence::kPrinted) {
      direction = elementary::atan2(goal.y(), goal.x()) / kPi;  // (2.16), (2.17)
    } else {
      const double from_north = elementary::atan2(goal.x(), goal.y());
      direction = (from_north < 0.0 ? from_north + 2.0 * kPi : from_north) / kPi - 1.0;
    }
  }
  const double weights = rules.centering_weight + rules.direction_weight;
  return (rules.centering_weight * centering(rules, now, phi_rad) + rules.direction_weight * direction) / weights;
}

RblState apply_rules(const RblRules& rules, const RblSituation& now, const RblState& state, double dt_s, bool planar) {
  RblState next;
  next.beta_m = next_beta(rules, now, state.beta_m, dt_s);
  next.theta_rad = rules.azimuth_rule ? next_theta(rules, now, state.theta_rad, dt_s) : 0.0;
  next.phi_rad = rules.elevation_rule && !planar ? next_phi(rules, now, state.phi_rad, dt_s) : 0.0;
  return next;
}

Vector3 rbl_destination(const RblRules& rules, const Vector3& goal_agent_m, const RblState& state) {
  const double distance_m = goal_agent_m.norm();
  if (distance_m <= 0.0) return goal_agent_m;
  const double up = rules.elevation_sense == RblRules::ElevationSense::kPrinted ? state.phi_rad : -state.phi_rad;
  const double polar =
      std::clamp(elementary::acos(std::clamp(goal_agent_m.z() / distance_m, -1.0, 1.0)) + up, 0.0, kPi);
  const double azimuth = elementary::atan2(goal_agent_m.y(), goal_agent_m.x()) - state.theta_rad;
  return distance_m * Vector3(elementary::sin(polar) * elementary::cos(azimuth),
                              elementary::sin(polar) * elementary::sin(azimuth), elementary::cos(polar));
}

void RblRules::visit(ConfigVisitor& v) {
  const Range positive = Range::positive();
  const Range non_negative = Range::non_negative();
  v.field("weight_near_m", weight_near_m,
          "[m] d_1 of (2.7): beta falls if c_A is nearer than this to the agent, and farther than d_2 from c_S",
          non_negative);
  v.field("weight_gap_m", weight_gap_m, "[m] d_2 of (2.7): least distance of c_A from c_S at which beta falls",
          non_negative);
  v.field("weight_goal_m", weight_goal_m,
          "[m] beta falls too if c_A is nearer than d_1 and the goal nearer than this; at r_s, the goal lies in S; 0: "
          "as in "
          "the document",
          non_negative);
  v.field("azimuth_near_m", azimuth_near_m,
          "[m] d_3 of (2.8), (2.11): horizontal distance of c_A below which theta grows, with d_4", non_negative);
  v.field("azimuth_gap_m", azimuth_gap_m,
          "[m] d_4 of (2.8), (2.11): horizontal distance of c_A from c_S above which theta grows, with d_3",
          non_negative);
  v.field("elevation_near_m", elevation_near_m,
          "[m] d_5 of (2.15): vertical distance of c_A below which phi changes, with d_6", non_negative);
  v.field("elevation_gap_m", elevation_gap_m,
          "[m] d_6 of (2.15): vertical distance of c_A from c_S above which phi changes, with d_5", non_negative);
  v.field("elevation_shrink_m", elevation_shrink_m,
          "[m] d_7 of (2.15): horizontal distance by which c_A is nearer than c_S, above which phi changes",
          non_negative);
  v.field("beta_desired_m", beta_desired_m,
          "[m] beta^D of (2.7): weighting length without conflict; smaller values fly more directly to the goal",
          positive);
  v.field("beta_min_m", beta_min_m,
          "[m] beta_min of (2.7): least weighting length; not in the document, 0.1 in the authors' later program",
          positive);
  v.field("weight_rate_mps", weight_rate_mps, "[m/s] k of (2.7): rate at which beta falls", non_negative);
  v.field("azimuth_rate_radps", azimuth_rate_radps, "[rad/s] k of (2.8), (2.11): rate at which theta grows",
          non_negative);
  v.field("azimuth_return_radps", azimuth_return_radps,
          "[rad/s] rate at which theta returns to 0; k in print, 2 in the authors' 2D program", non_negative);
  v.field("elevation_rate_radps", elevation_rate_radps, "[rad/s] k of (2.19): rate of phi", non_negative);
  v.field("centering_weight", centering_weight, "[-] w_1 of (2.18): weight of the height of c_S in the sign of phi",
          non_negative);
  v.field("direction_weight", direction_weight,
          "[-] w_2 of (2.18): weight of the direction to the goal in the sign of phi", non_negative);
  v.choice("azimuth_condition", azimuth_condition, {"near", "printed"},
           "[-] turn when c_A is nearer than d_3 (stuck; the authors' program), or farther (as printed)");
  v.choice(
      "azimuth_reset", azimuth_reset, {"detour", "near", "none"},
      "[-] the condition missing in (2.9), (2.12): the direct centroid is farther than the turned one (the authors' "
      "program), or farther than d_3");
  v.choice("elevation_condition", elevation_condition, {"gap", "printed"},
           "[-] first part of (2.15): vertical gap above d_6 and c_A nearer than d_5, or below d_6 as printed");
  v.choice("direction_influence", direction_influence, {"north", "printed", "program"},
           "[-] (2.17): +1 to the north, -1 to the south (the text), the printed formula, or the authors' program");
  v.choice("elevation_sense", elevation_sense, {"level", "up", "printed"},
           "[-] positive phi turns the destination up, and its own turn counts backwards in (2.18); up, and counts as "
           "printed; or down, as (2.20) is printed");
  v.field("azimuth_rule", azimuth_rule, "[-] whether the right-hand rule (2.8) to (2.12) is applied");
  v.check(centering_weight + direction_weight > 0.0, "direction_weight", "a weight above 0 beside centering_weight");
  v.check(beta_min_m <= beta_desired_m, "beta_min_m", "at most beta_desired_m");
}

}  // namespace swiftlet
