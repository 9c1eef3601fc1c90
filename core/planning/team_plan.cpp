// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/team_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/planning/guiding_viewpoint.hpp"
#include "core/planning/polyline.hpp"
#include "swiftlet/core/map/overlaid_occupancy.hpp"

namespace swiftlet {
namespace {

/// Boxes around vehicles, as COPY_MAP_AND_ADD_OBSTACLE adds to a map, without the copy.
void append_columns(std::span<const Vector3> places_local_m, double width_m, double height_m,
                    std::vector<KeepOut>& columns) {
  columns.reserve(columns.size() + places_local_m.size());
  for (const Vector3& p_local_m : places_local_m) {
    columns.push_back(KeepOut::box(p_local_m, {width_m, width_m, height_m}));
  }
}

/// Positions above and below which the guide does not fly: that of the guided vehicle, or its whole path if both fly at
/// once.
std::vector<Vector3> columns_of(const TeamPlan& plan, std::span<const PlannedPose> flying) {
  if (flying.empty()) return {plan.secondary_path.front().p_local_m};
  std::vector<Vector3> places_local_m;
  places_local_m.reserve(flying.size() + plan.secondary_path.size());
  for (const PlannedPose& pose : flying) places_local_m.push_back(pose.p_local_m);
  for (const PlannedPose& pose : plan.secondary_path) places_local_m.push_back(pose.p_local_m);
  return places_local_m;
}

/// The nearest clear position to the goal; vertical distance counts twice.
std::optional<Vector3> clear_place_near(const ClearSpace& space, const Vector3& goal_local_m, double edge_m,
                                        double radius_m) {
  if (space.is_clear(goal_local_m)) return goal_local_m;
  const int reach = static_cast<int>(radius_m / edge_m);
  std::optional<Vector3> nearest;
  double least_m = radius_m;
  for (int z = -reach; z <= reach; ++z) {
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        const Vector3 offset_m = edge_m * Vector3(x, y, z);
        const double distance_m = offset_m.head<2>().norm() + 2.0 * std::abs(offset_m.z());
        if (distance_m >= least_m || !space.is_clear(goal_local_m + offset_m)) continue;
        least_m = distance_m;
        nearest = goal_local_m + offset_m;
      }
    }
  }
  return nearest;
}

/// Points at most `spacing_m` apart; the heading turns evenly from the start to the goal.
std::vector<PlannedPose> with_headings(const std::vector<Vector3>& corners_local_m, double spacing_m, double yaw_rad,
                                       double goal_yaw_rad) {
  const double whole_m = length_m(corners_local_m);
  const double turn_rad = std::remainder(goal_yaw_rad - yaw_rad, 2.0 * std::numbers::pi);
  std::vector<PlannedPose> path;
  double flown_m = 0.0;
  for (const Vector3& p_local_m : with_points_between(corners_local_m, spacing_m)) {
    if (!path.empty()) flown_m += (p_local_m - path.back().p_local_m).norm();
    path.push_back({p_local_m, yaw_rad + (whole_m > 0.0 ? flown_m / whole_m : 1.0) * turn_rad});
  }
  return path;
}

std::vector<Vector3> places_of(std::span<const PlannedPose> path) {
  std::vector<Vector3> places_local_m;
  places_local_m.reserve(path.size());
  for (const PlannedPose& pose : path) places_local_m.push_back(pose.p_local_m);
  return places_local_m;
}

/// Plans in parts; each part returns false when the plan ends with it.
class TeamPlanning {
 public:
  TeamPlanning(const OccupancyView& map, const TeamPlannerConfig& config, const Vector3& primary_local_m,
               const TeamTraffic& traffic)
      : map_(map), config_(config), primary_local_m_(primary_local_m), flying_(traffic.flying) {
    append_columns(traffic.hovering_local_m, config.secondary_width_m, config.secondary_height_m, hovering_);
  }

  /// The goal, and lines 1 to 8: the secondary's path.
  bool plan_secondary(const PlannedPose& secondary, const PlannedPose& goal) {
    plan_.goal_local_m = goal.p_local_m;
    if (!is_on_map(goal.p_local_m, map_.edge_m())) return fail(kSecondary, text_of(ClearPathStatus::kGoalTooFar));
    const OverlaidOccupancy map_hovering(map_, hovering_);
    const ClearSpace space(map_hovering, config_.secondary, secondary.p_local_m);
    if (const auto place = clear_place_near(space, goal.p_local_m, map_.edge_m(), config_.goal_search_m)) {
      plan_.goal_local_m = *place;
    }
    if ((secondary.p_local_m - plan_.goal_local_m).norm() < config_.tolerance_m) {
      plan_.next = TeamPlan::Next::kGoalReached;
      return false;
    }
    std::vector<KeepOut> keep_outs = hovering_;
    append_columns({&primary_local_m_, 1}, config_.primary_width_m, config_.primary_height_m, keep_outs);
    const OverlaidOccupancy map_both(map_, std::move(keep_outs));
    ClearPath path = find_clear_path(map_both, config_.secondary, secondary.p_local_m, plan_.goal_local_m);
    // A primary on the path leaves first, to a viewpoint clear of the path. When both fly at once, it cannot.
    const bool searched = path.status == ClearPathStatus::kFound || path.status == ClearPathStatus::kBudgetSpent;
    if (!searched && flying_.empty()) {
      path = find_clear_path(map_hovering, config_.secondary, secondary.p_local_m, plan_.goal_local_m);
    }
    plan_.secondary_search = path.status;
    if (path.status != ClearPathStatus::kFound) return fail(kSecondary, text_of(path.status));
    plan_.secondary_path =
        with_headings(path.corners_local_m, config_.waypoint_spacing_m, secondary.yaw_rad, goal.yaw_rad);
    return true;
  }

  /// Lines 9 to 12: the viewpoints.
  bool find_viewpoints() {
    ViewpointRules rules = config_.viewpoint;
    rules.clearance_m = config_.primary.clearance_m;
    rules.unknown_is_free = config_.primary.unknown_is_free;
    GuidingViewpoints found = find_guiding_viewpoints(map_, primary_local_m_, places_of(plan_.secondary_path), rules,
                                                      places_of(flying_), hovering_);
    plan_.visible = std::move(found.visible);
    viewpoints_ = std::move(found.best_first);
    return !viewpoints_.empty() || fail("the viewpoint", "nowhere safe is the path in sight");
  }

  /// Lines 13 to 20: the primary's path to the viewpoint; without one, the next viewpoint is tried.
  void plan_primary() {
    append_columns(columns_of(plan_, flying_), config_.secondary_width_m, config_.secondary_height_m, hovering_);
    const OverlaidOccupancy map_primary(map_, std::move(hovering_));
    ClearPath path;
    for (GuidingViewpoint& viewpoint : viewpoints_) {
      plan_.viewpoint = std::move(viewpoint);
      if ((primary_local_m_ - plan_.viewpoint.p_local_m).norm() < config_.tolerance_m) {
        plan_.next = TeamPlan::Next::kMoveSecondary;
        return;
      }
      path = find_clear_path(map_primary, config_.primary, primary_local_m_, plan_.viewpoint.p_local_m);
      if (path.status != ClearPathStatus::kFound) continue;
      plan_.primary_local_m = std::move(path.corners_local_m);
      plan_.next = TeamPlan::Next::kMovePrimary;
      return;
    }
    plan_.primary_search = path.status;
    fail("the guide's path to the viewpoint", text_of(path.status));
  }

  TeamPlan& plan() { return plan_; }

 private:
  static constexpr const char* kSecondary = "the guided vehicle's path";

  /// A plan fails unless it sets what comes next.
  bool fail(const char* part, const char* reason) {
    plan_.reason = std::string(part) + ": " + reason;
    return false;
  }

  const OccupancyView& map_;
  const TeamPlannerConfig& config_;
  Vector3 primary_local_m_;
  std::span<const PlannedPose> flying_;
  std::vector<KeepOut> hovering_;
  std::vector<GuidingViewpoint> viewpoints_;
  TeamPlan plan_;
};

}  // namespace

TeamPlan plan_team(const OccupancyView& map, const TeamPlannerConfig& config, const Vector3& primary_local_m,
                   const PlannedPose& secondary, const PlannedPose& goal, const TeamTraffic& traffic,
                   const std::function<void(PlanningStage)>& begins) {
  const auto begin = [&begins](PlanningStage stage) {
    if (begins) begins(stage);
  };
  TeamPlanning planning(map, config, primary_local_m, traffic);
  begin(PlanningStage::kSecondaryPath);
  if (!planning.plan_secondary(secondary, goal)) return std::move(planning.plan());
  begin(PlanningStage::kViewpoint);
  if (!planning.find_viewpoints()) return std::move(planning.plan());
  begin(PlanningStage::kPrimaryPath);
  planning.plan_primary();
  return std::move(planning.plan());
}

void TeamPlannerConfig::visit(ConfigVisitor& v) {
  v.field("tolerance_m", tolerance_m, "[m] distance within which a goal or a viewpoint is reached", Range::positive());
  v.field("goal_search_m", goal_search_m,
          "[m] radius in which the nearest clear position replaces a goal without clearance",
          Range::between(0.0, 10.0));
  v.field("primary_width_m", primary_width_m, "[m] width of the box around the guide that is kept free",
          Range::positive());
  v.field("primary_height_m", primary_height_m, "[m] height of that box, with the vehicle in the middle",
          Range::positive());
  v.field("secondary_width_m", secondary_width_m, "[m] width of the box around the guided vehicle that is kept free",
          Range::positive());
  v.field("secondary_height_m", secondary_height_m, "[m] height of that box, with the vehicle in the middle",
          Range::positive());
  v.object("primary", primary, "limits and search of the guide's path");
  v.object("secondary", secondary, "limits and search of the guided vehicle's path");
  v.object("viewpoint", viewpoint, "viewpoints of the path");
}

}  // namespace swiftlet
