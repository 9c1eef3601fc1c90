// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_detour.hpp"

#include <algorithm>
#include <cmath>

#include "core/guidance/guidance_constants.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/map/overlaid_occupancy.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [m] Displacement that counts as motion, and shorter way that counts as progress. Larger values take slow flight for
/// rest.
constexpr double kMoves_m = 0.3;
// Conditions for a plan.
/// [m] Distance of the vehicle from the path above which a new path is planned. Larger values keep outdated paths.
constexpr double kOff_m = 2.0;
/// [m] Displacement of the goal above which a new path is planned. Smaller values plan for noise of the pose.
constexpr double kGoalMoved_m = 0.5;
// Limits of the path.
/// [m] Horizontal distance of the goal within which the path may change to its height. Larger values climb through air
/// that the LiDAR does not see.
constexpr double kNearGoal_m = 8.0;
/// [m/s] Speed of a neighbor below which it is an obstacle of the path. Larger values plan around neighbors that leave.
constexpr double kStands_mps = 0.3;
/// [m] Vertical extent of such an obstacle. Larger values keep the path out of the downwash.
constexpr double kColumn_m = 3.0;
// Straight flight along the path where the centroid of the cell keeps the vehicle at rest.
/// [s] Time at rest after which straight flight begins. Larger values wait longer before gaps.
constexpr double kHeld_s = 2.0;
/// [m] Length of the path that is then flown straight. Smaller values leave the vehicle inside of a gap, where the cell
/// draws it back.
constexpr double kStraight_m = 2.0;
// Viewpoint of a goal that the map shows occupied.
/// [m] Least horizontal distance of the viewpoint from the goal. Smaller values see less of the surroundings.
constexpr double kBeside_m = 2.0;
/// [-] Share of the distance from which the goal is in view, below which the goal counts as above or below. Larger
/// values fly to a viewpoint more often.
constexpr double kSteep = 0.7;
/// [m] Remaining length of the path at which the viewpoint is reached. Larger values look from farther off.
constexpr double kThere_m = 0.5;
/// [-] Directions around the goal that are tried. More find narrower free places and cost a search each.
constexpr int kSides = 8;
// Path following.
/// [-] Shares of the lookahead distance, tested from the largest on. More shares find points closer to the farthest
/// visible one and cost a segment test each.
constexpr double kShares[] = {1.0, 0.8, 0.6, 0.4, 0.3, 0.2, 0.1, 0.05};

/// Share of the leg before its point nearest to p.
double nearest_share(const Vector3& from_m, const Vector3& to_m, const Vector3& p_m) {
  const Vector3 leg_m = to_m - from_m;
  return std::clamp((p_m - from_m).dot(leg_m) / std::max(leg_m.squaredNorm(), kNearest_m * kNearest_m), 0.0, 1.0);
}

/// Columns around stationary neighbors. A path around moving neighbors would be outdated before it is flown.
std::vector<KeepOut> standing(const RblDetour::Situation& situation, double radius_m) {
  std::vector<KeepOut> places;
  for (const Neighbor& neighbor : situation.neighbors) {
    if (neighbor.velocity_local_mps.norm() > kStands_mps) continue;
    places.push_back(KeepOut::column(neighbor.position_local_m, 2.0 * radius_m, kColumn_m));
  }
  return places;
}

/// True if the segment from the vehicle passes a stationary neighbor closer than the encumbrances of both.
bool meets_standing(const RblDetour::Situation& situation, const Vector3& to_local_m) {
  const std::vector<KeepOut> places = standing(situation, 2.0 * situation.encumbrance_m);
  return std::any_of(places.begin(), places.end(), [&](const KeepOut& place) {
    return place.entered_after_m(situation.p_local_m, to_local_m).has_value();
  });
}

}  // namespace

RblDetour::RblDetour(const RblDetourConfig& config, double ahead_m)
    : config_(config), ahead_m_(ahead_m), planner_(config.planning_latency_s) {}

Vector3 RblDetour::next_goal_local_m(const Situation& situation) {
  if (!config_.enabled || situation.map == nullptr) return situation.goal_local_m;
  if (planner_.due(situation.now)) take(situation);
  double remaining_m = (situation.goal_local_m - situation.p_local_m).norm();
  if (on_path()) remaining_m = follow(situation.p_local_m);
  if (on_path() && to_viewpoint_ && remaining_m < kThere_m) {  // the viewpoint is reached
    corners_local_m_.clear();
    progress_at_ = situation.now;
    least_remaining_m_ = remaining_m = (situation.goal_local_m - situation.p_local_m).norm();
  }
  if (planner_.idle() && situation.now >= retry_at_ && needs_plan(situation, remaining_m)) plan(situation);
  straight_local_m_.reset();
  if (!on_path()) return situation.goal_local_m;
  if (is_held(situation)) {
    const double narrowed_m = narrowed(rules_, situation.map->edge_m()).clearance_m;
    straight_local_m_ = clear_point_local_m(situation, std::max(narrowed_m, situation.encumbrance_m));
    if (straight_local_m_ && meets_standing(situation, *straight_local_m_)) straight_local_m_.reset();
  }
  return point_ahead_local_m(situation);
}

/// True if the cell keeps the vehicle at rest, and then for kStraight_m of path, so that the cell does not draw the
/// vehicle back.
bool RblDetour::is_held(const Situation& situation) {
  if ((situation.p_local_m - last_moved_local_m_).norm() > kMoves_m) {
    last_moved_local_m_ = situation.p_local_m;
    last_moved_at_ = situation.now;
  }
  if (to_seconds(situation.now - last_moved_at_) > kHeld_s) straight_until_m_ = arc_m_ + kStraight_m;
  return arc_m_ < straight_until_m_;
}

bool RblDetour::is_near_goal(const Situation& situation) const {
  return (situation.goal_local_m - situation.p_local_m).head<2>().norm() < kNearGoal_m;
}

bool RblDetour::makes_progress(double remaining_m, TimeNs now) {
  if (remaining_m < least_remaining_m_ - kMoves_m) {
    least_remaining_m_ = remaining_m;
    progress_at_ = now;
  }
  return to_seconds(now - progress_at_) < config_.patience_s;
}

bool RblDetour::needs_plan(const Situation& situation, double remaining_m) {
  const bool stands = !makes_progress(remaining_m, situation.now);
  if (!on_path()) return stands;
  if (stands || off_m_ > kOff_m) return true;
  if (level_ && !to_viewpoint_ && !situation.planar && is_near_goal(situation)) return true;
  const double moved_m = (corners_local_m_.back() - situation.goal_local_m).head<2>().norm();
  if (moved_m > kGoalMoved_m + (to_viewpoint_ ? viewpoint_m_ : 0.0)) return true;
  if (checked_revision_ == situation.map->revision()) return false;
  checked_revision_ = situation.map->revision();
  std::size_t next = 1;
  for (double arc_m = 0.0; next + 1 < corners_local_m_.size(); ++next) {
    arc_m += (corners_local_m_[next] - corners_local_m_[next - 1]).norm();
    if (arc_m > arc_m_) break;
  }
  return is_blocked(*situation.map, rules_, situation.p_local_m, corners_local_m_, next);
}

/// Limits the path to heights near that of the vehicle, whose sensor sees little above and below; near the goal, also
/// to heights between both.
ClearPathConfig RblDetour::rules_for(const Situation& situation, bool level) const {
  ClearPathConfig rules = config_.planner;
  const double own_m = situation.p_local_m.z(), edge_m = situation.map->edge_m();
  const double goal_m = level ? own_m : situation.goal_local_m.z();
  const double climb_m = situation.planar ? edge_m : std::max(config_.climb_m, edge_m);
  const double low_m = std::min(own_m, goal_m) - climb_m, high_m = std::max(own_m, goal_m) + climb_m;
  rules.z_min_m = std::max({rules.z_min_m, std::min(situation.z_min_m, own_m) - 0.5 * edge_m, low_m});
  rules.z_max_m = std::min({rules.z_max_m, std::max(situation.z_max_m, own_m) + 0.5 * edge_m, high_m});
  return rules;
}

/// Searches a path, first around stationary neighbors, then through them.
/// @param level   the path ends above or below the goal, at the vehicle's own height
/// @param narrow  with the least clearance that the cells need instead of the configured one
void RblDetour::search(const Situation& situation, Vector3 goal_local_m, bool level, bool narrow) {
  rules_ = rules_for(situation, level);
  const double least_m = situation.encumbrance_m + 0.5 * situation.map->edge_m();
  if (narrow) rules_.clearance_m = std::min(rules_.clearance_m, least_m);
  level_ = level;
  goal_local_m.z() = std::clamp(level ? situation.p_local_m.z() : goal_local_m.z(), rules_.z_min_m, rules_.z_max_m);
  // The clearance of the path is added to the encumbrance.
  const std::vector<KeepOut> stationary = standing(situation, situation.encumbrance_m);
  const OverlaidOccupancy with_stationary(*situation.map, stationary);
  const OccupancyView& view = stationary.empty() ? *situation.map : static_cast<const OccupancyView&>(with_stationary);
  found_ = find_clear_path(view, rules_, situation.p_local_m, goal_local_m);
  // Without a path around stationary neighbors, plans through them: they may fly on, or stay at the goal.
  if (found_.status == ClearPathStatus::kFound || stationary.empty()) return;
  found_ = find_clear_path(*situation.map, rules_, situation.p_local_m, goal_local_m);
}

void RblDetour::plan(const Situation& situation) {
  found_ = {};
  to_viewpoint_ = is_above_or_below(situation) && plan_viewpoint(situation);
  const auto consider_both_sides = [&](const Vector3& goal_local_m, bool level) {
    if (found_.status != ClearPathStatus::kFound) search(situation, goal_local_m, level, false);
    if (found_.status != ClearPathStatus::kFound) search(situation, goal_local_m, level, true);
  };
  if (situation.planar || !is_near_goal(situation)) consider_both_sides(situation.goal_local_m, true);
  if (!situation.planar) consider_both_sides(situation.goal_local_m, false);
  if (found_.status == ClearPathStatus::kGoalBlocked && is_near_goal(situation)) {
    to_viewpoint_ = plan_viewpoint(situation);
    if (!to_viewpoint_) found_.status = ClearPathStatus::kGoalBlocked;
  }
  ++num_plans_;
  if (found_.status == ClearPathStatus::kBudgetSpent) ++num_given_up_;
  planner_.start(situation.now);
}

/// True if the direction to the goal is too steep for the LiDAR to see the goal.
bool RblDetour::is_above_or_below(const Situation& situation) const {
  const Vector3 to_goal_m = situation.goal_local_m - situation.p_local_m;
  return !situation.planar && std::abs(to_goal_m.z()) > situation.encumbrance_m &&
         to_goal_m.head<2>().norm() < kSteep * situation.sees_goal_from_m;
}

/// Plans a path at the vehicle's own height to a viewpoint beside the goal: occupied voxels at the goal may be of a
/// vehicle that has left, but the LiDAR cannot see them free from above or below.
bool RblDetour::plan_viewpoint(const Situation& situation) {
  const Vector3 from_goal_m = situation.p_local_m - situation.goal_local_m;
  const double toward_rad = elementary::atan2(from_goal_m.y(), from_goal_m.x());
  viewpoint_m_ = std::max(kBeside_m, situation.sees_goal_from_m);
  for (int i = 0; i < kSides; ++i) {
    const int side = (i + 1) / 2;  // left and right in turn
    const double turn_rad = (i % 2 == 0 ? 1.0 : -1.0) * side * 2.0 * kPi / kSides;
    const double azimuth_rad = toward_rad + turn_rad;
    const Vector3 out_m = viewpoint_m_ * Vector3(elementary::cos(azimuth_rad), elementary::sin(azimuth_rad), 0.0);
    search(situation, situation.goal_local_m + out_m, true, true);
    if (found_.status == ClearPathStatus::kFound) return true;
  }
  found_ = {};
  return false;
}

void RblDetour::take(const Situation& situation) {
  planner_.stop();
  progress_at_ = situation.now;
  least_remaining_m_ = std::numeric_limits<double>::infinity();
  straight_until_m_ = std::max(0.0, straight_until_m_ - arc_m_);
  arc_m_ = off_m_ = 0.0;
  checked_revision_ = 0;
  corners_local_m_.clear();
  if (found_.status == ClearPathStatus::kFound) {
    corners_local_m_ = std::move(found_.corners_local_m);
    failures_ = to_viewpoint_ ? failures_ + 1 : 0;
    note_ = to_viewpoint_ ? "detour to a viewpoint of the goal" : "detour around an obstacle";
    return;
  }
  if (found_.status != ClearPathStatus::kBudgetSpent) ++failures_;
  retry_at_ = situation.now + from_seconds(config_.retry_after_s);
  note_ = text_of(found_.status);
}

/// Advances along the path to the point nearest to the vehicle, never backwards. Returns the remaining length.
double RblDetour::follow(const Vector3& p_local_m) {
  double leg_start_m = 0.0, best_m = arc_m_, nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < corners_local_m_.size(); ++i) {
    const double leg_m = (corners_local_m_[i] - corners_local_m_[i - 1]).norm();
    if (leg_start_m + leg_m >= arc_m_ && leg_start_m <= arc_m_ + ahead_m_) {
      const double share = nearest_share(corners_local_m_[i - 1], corners_local_m_[i], p_local_m);
      const double arc_m = std::clamp(leg_start_m + share * leg_m, arc_m_, arc_m_ + ahead_m_);
      const double off_m = (at_local_m(arc_m) - p_local_m).norm();
      if (off_m < nearest_m) {
        nearest_m = off_m;
        best_m = arc_m;
      }
    }
    leg_start_m += leg_m;
  }
  arc_m_ = best_m;
  off_m_ = (at_local_m(arc_m_) - p_local_m).norm();
  return leg_start_m - arc_m_ + off_m_;
}

Vector3 RblDetour::at_local_m(double arc_m) const {
  for (std::size_t i = 1; i < corners_local_m_.size(); ++i) {
    const Vector3 leg_m = corners_local_m_[i] - corners_local_m_[i - 1];
    const double length_m = leg_m.norm();
    if (arc_m <= length_m && length_m > 0.0) return corners_local_m_[i - 1] + arc_m / length_m * leg_m;
    arc_m -= length_m;
  }
  return corners_local_m_.back();
}

/// Farthest point of the path within the lookahead distance to which the straight segment from the vehicle is clear.
std::optional<Vector3> RblDetour::clear_point_local_m(const Situation& situation, double clearance_m) const {
  ClearPathConfig rules = rules_;
  rules.clearance_m = clearance_m;
  const ClearSpace space(*situation.map, rules, situation.p_local_m);
  for (const double share : kShares) {
    const Vector3 ahead_local_m = at_local_m(arc_m_ + share * ahead_m_);
    if (space.is_clear_segment(situation.p_local_m, ahead_local_m)) return ahead_local_m;
  }
  return std::nullopt;
}

Vector3 RblDetour::point_ahead_local_m(const Situation& situation) const {
  const double clearance_m = narrowed(rules_, situation.map->edge_m()).clearance_m;
  const auto clear = clear_point_local_m(situation, clearance_m);
  return clear ? *clear : at_local_m(arc_m_ + kShares[std::size(kShares) - 1] * ahead_m_);
}

void RblDetourConfig::visit(ConfigVisitor& v) {
  v.field("enabled", enabled,
          "[-] whether a vehicle with `lidar` plans a path in its own map when it makes no progress");
  v.field("patience_s", patience_s, "[s] time without progress before a path is planned", Range::positive());
  v.field("planning_latency_s", planning_latency_s,
          "[s] delay from the start of a search until its path is flown, as of the onboard computer",
          Range::between(0.0, 1000.0));
  v.object("planner", planner, "limits and search of the path");
}

}  // namespace swiftlet
