// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_rules.hpp"

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

}  // namespace swiftlet
