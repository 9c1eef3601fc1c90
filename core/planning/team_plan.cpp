// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/team_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

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

TeamPlan& fail(TeamPlan& plan, const char* vehicle, const char* reason) {
  plan.next = TeamPlan::Next::kFail;
  plan.reason = std::string(vehicle) + ": " + reason;
  return plan;
}

}  // namespace

TeamPlan plan_team(const OccupancyView& map, const TeamPlannerConfig& config, const Vector3& primary_local_m,
                   const PlannedPose& secondary, const PlannedPose& goal, const TeamTraffic& traffic,
                   const std::function<void(PlanningStage)>& begins) {
  const auto begin = [&begins](PlanningStage stage) {
    if (begins) begins(stage);
  };
  begin(PlanningStage::kSecondaryPath);
  TeamPlan plan;
  plan.goal_local_m = goal.p_local_m;
  const double edge_m = map.edge_m();
  if (!is_on_map(goal.p_local_m, edge_m)) {
    return fail(plan, "the guided vehicle's path", text_of(ClearPathStatus::kGoalTooFar));
  }

  // The goal, and lines 4 to 8: the secondary's path.
  std::vector<KeepOut> hovering;
  append_columns(traffic.hovering_local_m, config.secondary_width_m, config.secondary_height_m, hovering);
  std::vector<KeepOut> keep_outs_secondary = hovering;
  append_columns({&primary_local_m, 1}, config.primary_width_m, config.primary_height_m, keep_outs_secondary);
  const OverlaidOccupancy map_secondary(map, std::move(keep_outs_secondary));
  const ClearSpace space(map_secondary, config.secondary, secondary.p_local_m);
  if (const auto place = clear_place_near(space, goal.p_local_m, edge_m, config.goal_search_m)) {
    plan.goal_local_m = *place;
  }
  // Lines 1 to 3.
  if ((secondary.p_local_m - plan.goal_local_m).norm() < config.tolerance_m) {
    plan.next = TeamPlan::Next::kGoalReached;
    return plan;
  }
  const ClearPath path_secondary =
      find_clear_path(map_secondary, config.secondary, secondary.p_local_m, plan.goal_local_m);
  plan.secondary_search = path_secondary.status;
  if (path_secondary.status != ClearPathStatus::kFound) {
    return fail(plan, "the guided vehicle's path", text_of(path_secondary.status));
  }
  plan.secondary_path =
      with_headings(path_secondary.corners_local_m, config.waypoint_spacing_m, secondary.yaw_rad, goal.yaw_rad);

  // Lines 9 to 12: the viewpoints.
  begin(PlanningStage::kViewpoint);
  ViewpointRules rules = config.viewpoint;
  rules.clearance_m = config.primary.clearance_m;
  rules.unknown_is_free = config.primary.unknown_is_free;
  GuidingViewpoints viewpoints = find_guiding_viewpoints(map, primary_local_m, places_of(plan.secondary_path), rules,
                                                         places_of(traffic.flying), hovering);
  plan.visible = std::move(viewpoints.visible);
  if (viewpoints.best_first.empty()) return fail(plan, "the viewpoint", "nowhere safe is the path in sight");

  // Lines 13 to 20: the primary's path to the viewpoint; without one, the next viewpoint is tried.
  begin(PlanningStage::kPrimaryPath);
  std::vector<KeepOut> keep_outs_primary = std::move(hovering);
  append_columns(columns_of(plan, traffic.flying), config.secondary_width_m, config.secondary_height_m,
                 keep_outs_primary);
  const OverlaidOccupancy map_primary(map, std::move(keep_outs_primary));
  ClearPath path_primary;
  for (GuidingViewpoint& viewpoint : viewpoints.best_first) {
    plan.viewpoint = std::move(viewpoint);
    if ((primary_local_m - plan.viewpoint.p_local_m).norm() < config.tolerance_m) {
      plan.next = TeamPlan::Next::kMoveSecondary;
      return plan;
    }
    path_primary = find_clear_path(map_primary, config.primary, primary_local_m, plan.viewpoint.p_local_m);
    if (path_primary.status != ClearPathStatus::kFound) continue;
    plan.primary_local_m = path_primary.corners_local_m;
    plan.next = TeamPlan::Next::kMovePrimary;
    return plan;
  }
  plan.primary_search = path_primary.status;
  return fail(plan, "the guide's path to the viewpoint", text_of(path_primary.status));
}

void TeamPlannerConfig::visit(ConfigVisitor& v) {
  v.field("tolerance_m", tolerance_m, "[m] distance within which a goal or a viewpoint is reached", Range::positive());
  v.field("goal_search_m", goal_search_m,
          "[m] radius in which the nearest clear position replaces a goal without clearance",
          Range::between(0.0, 10.0));
  v.field("primary_width_m", primary_width_m, "[m] width of the box around the guide that is kept free",
          Range::positive());
  v.field("primary_height_m", primary_height_m, "[m] height of that box, half of it above", Range::positive());
  v.field("secondary_width_m", secondary_width_m, "[m] width of the box around the guided vehicle that is kept free",
          Range::positive());
  v.field("secondary_height_m", secondary_height_m, "[m] height of that box, half of it above", Range::positive());
  v.object("primary", primary, "limits and search of the guide's path");
  v.object("secondary", secondary, "limits and search of the guided vehicle's path");
  v.object("viewpoint", viewpoint, "viewpoints of the path");
}

}  // namespace swiftlet
