// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_detour.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/map/overlaid_occupancy.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

// When a path is planned.
constexpr double kNearer_m = 0.3;     ///< shortest progress that resets the patience
constexpr double kOff_m = 2.0;        ///< distance from the path beyond which it is planned anew
constexpr double kGoalMoved_m = 0.5;  ///< displacement of the goal beyond which it is planned anew
// Its limits.
constexpr double kNearGoal_m = 8.0;  ///< horizontal distance within which a path leads to the goal's height
constexpr double kStands_mps = 0.3;  ///< slower neighbors are obstacles of the path
constexpr double kColumn_m = 3.0;    ///< vertical extent of such a neighbor
// Flight straight along the path where the cell holds the vehicle.
constexpr double kMoves_m = 0.3;     ///< smaller displacements count as standing
constexpr double kHeld_s = 2.0;      ///< time of standing after which the cell counts as holding the vehicle
constexpr double kStraight_m = 2.0;  ///< length of path that is then flown straight
// Viewpoint of a blocked goal.
constexpr double kBeside_m = 2.0;  ///< least horizontal distance from the goal
constexpr double kSteep = 0.7;     ///< share of the viewing distance below which the goal counts as above or below
constexpr double kThere_m = 0.5;   ///< distance at which the viewpoint is reached
constexpr int kSides = 8;          ///< directions of the search
/// Bound of a squared leg length, against division by 0.
constexpr double kLeastLeg_m2 = 1e-6;

/// Shares of the lookahead distance, tested from the farthest on. More of them find points nearer to the bound.
constexpr double kShares[] = {1.0, 0.8, 0.6, 0.4, 0.3, 0.2, 0.1, 0.05};

/// Share of the leg before its point nearest to p.
double nearest_share(const Vector3& from_m, const Vector3& to_m, const Vector3& p_m) {
  const Vector3 leg_m = to_m - from_m;
  return std::clamp((p_m - from_m).dot(leg_m) / std::max(leg_m.squaredNorm(), kLeastLeg_m2), 0.0, 1.0);
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

/// Does the segment pass a stationary neighbor nearer than both encumbrances?
bool meets_standing(const RblDetour::Situation& situation, const Vector3& to_local_m) {
  const std::vector<KeepOut> places = standing(situation, 2.0 * situation.encumbrance_m);
  return std::any_of(places.begin(), places.end(), [&](const KeepOut& place) {
    return place.entered_after_m(situation.p_local_m, to_local_m).has_value();
  });
}

/// Clearance less one voxel, so that flickering voxels do not invalidate the path.
ClearPathConfig narrowed(const ClearPathConfig& rules, double edge_m) {
  ClearPathConfig narrow = rules;
  narrow.clearance_m = std::max(rules.clearance_m - edge_m, 0.5 * edge_m);
  return narrow;
}

}  // namespace

RblDetour::RblDetour(const RblDetourConfig& config, double ahead_m)
    : config_(config), ahead_m_(ahead_m), planner_(config.planning_latency_s) {}

Vector3 RblDetour::next_goal_local_m(const Situation& situation) {
  if (!config_.enabled || situation.map == nullptr) return situation.goal_local_m;
  if (planner_.due(situation.now)) take(situation);
  double left_m = (situation.goal_local_m - situation.p_local_m).norm();
  if (on_path()) left_m = follow(situation.p_local_m);
  if (on_path() && beside_ && left_m < kThere_m) {  // the viewpoint is reached
    corners_local_m_.clear();
    since_ = situation.now;
    least_m_ = left_m = (situation.goal_local_m - situation.p_local_m).norm();
  }
  if (planner_.idle() && situation.now >= retry_ && has_to_plan(situation, left_m)) plan(situation);
  straight_local_m_.reset();
  if (!on_path()) return situation.goal_local_m;
  if (is_held(situation)) {
    const double narrowed_m = narrowed(rules_, situation.map->edge_m()).clearance_m;
    straight_local_m_ = clear_point_local_m(situation, std::max(narrowed_m, situation.encumbrance_m));
    if (straight_local_m_ && meets_standing(situation, *straight_local_m_)) straight_local_m_.reset();
  }
  return point_ahead_local_m(situation);
}

/// Stays true for kStraight_m of path after the vehicle was held, or the cell would draw it back.
bool RblDetour::is_held(const Situation& situation) {
  if ((situation.p_local_m - moved_local_m_).norm() > kMoves_m) {
    moved_local_m_ = situation.p_local_m;
    moved_at_ = situation.now;
  }
  if (to_seconds(situation.now - moved_at_) > kHeld_s) straight_until_m_ = arc_m_ + kStraight_m;
  return arc_m_ < straight_until_m_;
}

bool RblDetour::is_near_goal(const Situation& situation) const {
  return (situation.goal_local_m - situation.p_local_m).head<2>().norm() < kNearGoal_m;
}

bool RblDetour::gets_on(double left_m, TimeNs now) {
  if (left_m < least_m_ - kNearer_m) {
    least_m_ = left_m;
    since_ = now;
  }
  return to_seconds(now - since_) < config_.patience_s;
}

bool RblDetour::has_to_plan(const Situation& situation, double left_m) {
  const bool stands = !gets_on(left_m, situation.now);
  if (!on_path()) return stands;
  if (stands || off_m_ > kOff_m) return true;
  if (level_ && !beside_ && !situation.planar && is_near_goal(situation)) return true;
  const double moved_m = (corners_local_m_.back() - situation.goal_local_m).head<2>().norm();
  if (moved_m > kGoalMoved_m + (beside_ ? beside_m_ : 0.0)) return true;
  if (checked_ == situation.map->revision()) return false;
  checked_ = situation.map->revision();
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

/// @param level   ends above or below the goal, at the vehicle's own height
/// @param narrow  with the least clearance that the cells need, where no wider path begins
void RblDetour::search(const Situation& situation, Vector3 goal_local_m, bool level, bool narrow) {
  rules_ = rules_for(situation, level);
  const double least_m = situation.encumbrance_m + 0.5 * situation.map->edge_m();
  if (narrow) rules_.clearance_m = std::min(rules_.clearance_m, least_m);
  level_ = level;
  goal_local_m.z() = std::clamp(level ? situation.p_local_m.z() : goal_local_m.z(), rules_.z_min_m, rules_.z_max_m);
  // The clearance of the path is added to the encumbrance.
  const std::vector<KeepOut> others = standing(situation, situation.encumbrance_m);
  const OverlaidOccupancy with_others(*situation.map, others);
  const OccupancyView& view = others.empty() ? *situation.map : static_cast<const OccupancyView&>(with_others);
  found_ = find_clear_path(view, rules_, situation.p_local_m, goal_local_m);
  // Without a path around stationary neighbors, plans through them: they may fly on, or stay at the goal.
  if (found_.status == ClearPathStatus::kFound || others.empty()) return;
  found_ = find_clear_path(*situation.map, rules_, situation.p_local_m, goal_local_m);
}

void RblDetour::plan(const Situation& situation) {
  found_ = {};
  beside_ = is_above_or_below(situation) && look_from_beside(situation);
  const auto consider_both_sides = [&](const Vector3& goal_local_m, bool level) {
    if (found_.status != ClearPathStatus::kFound) search(situation, goal_local_m, level, false);
    if (found_.status != ClearPathStatus::kFound) search(situation, goal_local_m, level, true);
  };
  if (situation.planar || !is_near_goal(situation)) consider_both_sides(situation.goal_local_m, true);
  if (!situation.planar) consider_both_sides(situation.goal_local_m, false);
  if (found_.status == ClearPathStatus::kGoalBlocked && is_near_goal(situation)) {
    beside_ = look_from_beside(situation);
    if (!beside_) found_.status = ClearPathStatus::kGoalBlocked;
  }
  ++num_plans_;
  if (found_.status == ClearPathStatus::kBudgetSpent) ++num_given_up_;
  planner_.start(situation.now);
}

/// Is the direction to the goal too steep for the goal to come into view?
bool RblDetour::is_above_or_below(const Situation& situation) const {
  const Vector3 to_goal_m = situation.goal_local_m - situation.p_local_m;
  return !situation.planar && std::abs(to_goal_m.z()) > situation.encumbrance_m &&
         to_goal_m.head<2>().norm() < kSteep * situation.sees_goal_from_m;
}

/// Plans a path at the vehicle's own height to a viewpoint beside the goal. Voxels at the goal may be those of a
/// vehicle that has left, which is never visible from above or below.
bool RblDetour::look_from_beside(const Situation& situation) {
  const Vector3 from_goal_m = situation.p_local_m - situation.goal_local_m;
  const double toward_rad = elementary::atan2(from_goal_m.y(), from_goal_m.x());
  beside_m_ = std::max(kBeside_m, situation.sees_goal_from_m);
  for (int i = 0; i < kSides; ++i) {
    const int side = (i + 1) / 2;  // left and right in turn
    const double turn_rad = (i % 2 == 0 ? 1.0 : -1.0) * side * 2.0 * kPi / kSides;
    const double azimuth_rad = toward_rad + turn_rad;
    const Vector3 out_m = beside_m_ * Vector3(elementary::cos(azimuth_rad), elementary::sin(azimuth_rad), 0.0);
    search(situation, situation.goal_local_m + out_m, true, true);
    if (found_.status == ClearPathStatus::kFound) return true;
  }
  found_ = {};
  return false;
}

void RblDetour::take(const Situation& situation) {
  planner_.stop();
  since_ = situation.now;
  least_m_ = std::numeric_limits<double>::infinity();
  straight_until_m_ = std::max(0.0, straight_until_m_ - arc_m_);
  arc_m_ = off_m_ = 0.0;
  checked_ = 0;
  corners_local_m_.clear();
  if (found_.status == ClearPathStatus::kFound) {
    corners_local_m_ = std::move(found_.corners_local_m);
    failures_ = beside_ ? failures_ + 1 : 0;
    note_ = beside_ ? "on a path to where it sees its goal" : "on a path around what is in its way";
    return;
  }
  if (found_.status != ClearPathStatus::kBudgetSpent) ++failures_;
  retry_ = situation.now + from_seconds(config_.retry_after_s);
  note_ = text_of(found_.status);
}

/// Advances along the path to the point nearest to the vehicle, never backwards. Returns the remaining length.
double RblDetour::follow(const Vector3& p_local_m) {
  double begins_m = 0.0, best_m = arc_m_, nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < corners_local_m_.size(); ++i) {
    const double leg_m = (corners_local_m_[i] - corners_local_m_[i - 1]).norm();
    if (begins_m + leg_m >= arc_m_ && begins_m <= arc_m_ + ahead_m_) {
      const double share = nearest_share(corners_local_m_[i - 1], corners_local_m_[i], p_local_m);
      const double arc_m = std::clamp(begins_m + share * leg_m, arc_m_, arc_m_ + ahead_m_);
      const double off_m = (at_local_m(arc_m) - p_local_m).norm();
      if (off_m < nearest_m) {
        nearest_m = off_m;
        best_m = arc_m;
      }
    }
    begins_m += leg_m;
  }
  arc_m_ = best_m;
  off_m_ = (at_local_m(arc_m_) - p_local_m).norm();
  return begins_m - arc_m_ + off_m_;
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

/// The farthest point of the path within the lookahead that a clear segment joins with the vehicle.
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
  v.field("enabled", enabled, "[-] without progress, a vehicle with `lidar` plans a path through its own map");
  v.field("patience_s", patience_s, "[s] time without progress before a path is planned", Range::positive());
  v.field("climb_m", climb_m,
          "[m] largest height of the path above and below the vehicle; near the goal, also above and below the goal",
          Range::non_negative());
  v.field("planning_latency_s", planning_latency_s, "[s] computing time of a plan on board",
          Range::between(0.0, 1000.0));
  v.field("retry_after_s", retry_after_s, "[s] delay after a search without a path before the next one",
          Range::non_negative());
  v.field("retries", retries, "[-] further searches without a path before the mission has failed",
          Range::between(0, 1e6));
  v.object("planner", planner, "limits and search of the path");
}

}  // namespace swiftlet
