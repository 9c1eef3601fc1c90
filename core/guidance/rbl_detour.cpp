// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/rbl_detour.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/elementary.hpp"
#include "swiftlet/core/map/overlaid_occupancy.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

constexpr double kNearer_m = 0.3;       // what counts as getting on
constexpr double kStands_mps = 0.3;     // a slower neighbor is planned around
constexpr double kOff_m = 2.0;          // a vehicle so far off its path needs another one
constexpr double kNearGoal_m = 8.0;     // nearer than this, a path leads to the goal's height
constexpr double kGoalMoved_m = 0.5;    // so does one whose goal lies elsewhere
constexpr double kColumn_m = 3.0;       // of air that belongs to a neighbor
constexpr double kMoves_m = 0.3;        // what counts as moving
constexpr double kHeld_s = 2.0;         // without that, its cell holds it on its path
constexpr double kStraight_m = 2.0;     // of the path that it then flies straight
constexpr double kLeastPoint_m = 1e-6;  // shorter legs have no direction
constexpr double kBeside_m = 2.0;       // of a goal that is blocked, from where it looks; at least
constexpr double kSteep = 0.7;          // share of the distance at which it sees the goal; nearer it is steep
constexpr double kThere_m = 0.5;        // near enough to that
constexpr int kSides = 8;               // of it

constexpr double kShares[] = {1.0, 0.8, 0.6, 0.4, 0.3, 0.2, 0.1, 0.05};  // of what lies ahead, within reach

/// Share of a leg at which it is nearest to a point.
double nearest_share(const Vector3& from_m, const Vector3& to_m, const Vector3& p_m) {
  const Vector3 leg_m = to_m - from_m;
  return std::clamp((p_m - from_m).dot(leg_m) / std::max(leg_m.squaredNorm(), kLeastPoint_m), 0.0, 1.0);
}

/// Those that stand: a path around one that flies would be old before it is flown.
std::vector<KeepOut> standing(const RblDetour::Situation& situation, double radius_m) {
  std::vector<KeepOut> places;
  for (const Neighbor& neighbor : situation.neighbors) {
    if (neighbor.velocity_local_mps.norm() > kStands_mps) continue;
    places.push_back(KeepOut::column(neighbor.position_local_m, 2.0 * radius_m, kColumn_m));
  }
  return places;
}

/// On a straight way nearer than the encumbrances of both.
bool meets_standing(const RblDetour::Situation& situation, const Vector3& to_local_m) {
  const std::vector<KeepOut> places = standing(situation, 2.0 * situation.encumbrance_m);
  return std::any_of(places.begin(), places.end(), [&](const KeepOut& place) {
    return place.entered_after_m(situation.p_local_m, to_local_m).has_value();
  });
}

/// A cell's edge less of clearance: an obstacle whose cells flicker is no reason for another path.
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
  if (on_path() && beside_ && left_m < kThere_m) {  // it looks now
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

/// Once held, for a part of the path: or its cell would draw it back to where it stood.
bool RblDetour::is_held(const Situation& situation) {
  if ((situation.p_local_m - stood_local_m_).norm() > kMoves_m) {
    stood_local_m_ = situation.p_local_m;
    stood_ = situation.now;
  }
  if (to_seconds(situation.now - stood_) > kHeld_s) straight_until_m_ = arc_m_ + kStraight_m;
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

/// Heights near that of the vehicle, which looks ahead and sees little of what is above it; near the goal up or down to
/// its height, too.
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

/// @param level   to above or below the goal, at the vehicle's own height
/// @param narrow  with no more clearance than its cells need: the vehicle may be where no other path begins
void RblDetour::search(const Situation& situation, Vector3 goal_local_m, bool level, bool narrow) {
  rules_ = rules_for(situation, level);
  const double least_m = situation.encumbrance_m + 0.5 * situation.map->edge_m();
  if (narrow) rules_.clearance_m = std::min(rules_.clearance_m, least_m);
  level_ = level;
  goal_local_m.z() = std::clamp(level ? situation.p_local_m.z() : goal_local_m.z(), rules_.z_min_m, rules_.z_max_m);
  // The clearance of the path comes on top.
  const std::vector<KeepOut> others = standing(situation, situation.encumbrance_m);
  const OverlaidOccupancy with_others(*situation.map, others);
  const OccupancyView& view = others.empty() ? *situation.map : static_cast<const OccupancyView&>(with_others);
  found_ = find_clear_path(view, rules_, situation.p_local_m, goal_local_m);
  // Who stands in the only way may go on, or be at the goal.
  if (found_.status == ClearPathStatus::kFound || others.empty()) return;
  found_ = find_clear_path(*situation.map, rules_, situation.p_local_m, goal_local_m);
}

void RblDetour::plan(const Situation& situation) {
  found_ = {};
  beside_ = is_above_or_below(situation) && look_from_beside(situation);
  const auto try_both = [&](const Vector3& goal_local_m, bool level) {
    if (found_.status != ClearPathStatus::kFound) search(situation, goal_local_m, level, false);
    if (found_.status != ClearPathStatus::kFound) search(situation, goal_local_m, level, true);
  };
  if (situation.planar || !is_near_goal(situation)) try_both(situation.goal_local_m, true);
  if (!situation.planar) try_both(situation.goal_local_m, false);
  if (found_.status == ClearPathStatus::kGoalBlocked && is_near_goal(situation)) {
    beside_ = look_from_beside(situation);
    if (!beside_) found_.status = ClearPathStatus::kGoalBlocked;
  }
  ++num_plans_;
  if (found_.status == ClearPathStatus::kBudgetSpent) ++num_given_up_;
  planner_.start(situation.now);
}

/// So that the goal cannot come into view on the way there.
bool RblDetour::is_above_or_below(const Situation& situation) const {
  const Vector3 to_goal_m = situation.goal_local_m - situation.p_local_m;
  return !situation.planar && std::abs(to_goal_m.z()) > situation.encumbrance_m &&
         to_goal_m.head<2>().norm() < kSteep * situation.sees_goal_from_m;
}

/// A path at its own height to a place beside the goal, from where that is in view. What the map shows at the goal may
/// be a vehicle that was there, and one above or below it never sees that it is gone.
bool RblDetour::look_from_beside(const Situation& situation) {
  const Vector3 from_goal_m = situation.p_local_m - situation.goal_local_m;
  const double toward_rad = elementary::atan2(from_goal_m.y(), from_goal_m.x());
  beside_m_ = std::max(kBeside_m, situation.sees_goal_from_m);
  for (int i = 0; i < kSides; ++i) {
    const int side = (i + 1) / 2;  // to the left and to the right in turn
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

/// Where on the path the vehicle is, never backwards; what is left of it.
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

/// The farthest point of the path within reach to which the straight way is clear.
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
          "[-] a vehicle with `lidar` that gets no nearer to its goal flies on a path through its own map");
  v.field("patience_s", patience_s, "[s] no nearer for so long, it looks for a path", Range::positive());
  v.field("climb_m", climb_m,
          "[m] the path keeps within this above and below the vehicle; near the goal, of the heights of both",
          Range::non_negative());
  v.field("planning_latency_s", planning_latency_s, "[s] that planning takes on board", Range::between(0.0, 1000.0));
  v.field("retry_after_s", retry_after_s, "[s] from one search without a path to the next", Range::non_negative());
  v.field("retries", retries, "[-] further searches without a path before the mission has failed",
          Range::between(0, 1e6));
  v.object("planner", planner, "where a path may lead, and how it is searched");
}

}  // namespace swiftlet
