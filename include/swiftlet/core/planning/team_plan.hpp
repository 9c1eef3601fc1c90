// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/planning/clear_path.hpp"
#include "swiftlet/core/planning/plane_region.hpp"
#include "swiftlet/core/planning/viewpoint.hpp"

/// Paths of a primary vehicle, which has the map, and of a secondary one that it guides [Pritzl 2024, alg. 1].
namespace swiftlet {

/// The defaults are those of [Pritzl 2024, tab. I].
struct TeamPlannerConfig {
  double tolerance_m = 0.3;
  double waypoint_spacing_m = 0.5;  ///< [m] greatest distance between waypoints of the guided vehicle
  double goal_search_m = 1.0;
  double primary_width_m = 1.5;
  double primary_height_m = 10.0;
  double secondary_width_m = 1.3;
  double secondary_height_m = 10.0;
  ClearPathConfig primary{.clearance_m = 0.9};
  ClearPathConfig secondary{.clearance_m = 0.8};
  ViewpointRules viewpoint;

  void visit(ConfigVisitor& v);
};

/// A position with a heading, in the local frame of the primary vehicle.
struct PlannedPose {
  Vector3 p_local_m = Vector3::Zero();
  double yaw_rad = 0.0;
};

/// Result of planning: the next action.
struct TeamPlan {
  enum class Next { kGoalReached, kMovePrimary, kMoveSecondary, kFail };
  Next next = Next::kFail;
  std::string reason;  ///< reason of a failure
  ClearPathStatus primary_search = ClearPathStatus::kFound;
  ClearPathStatus secondary_search = ClearPathStatus::kFound;
  Vector3 goal_local_m = Vector3::Zero();
  std::vector<PlannedPose> secondary_path;  ///< from the vehicle's position to the goal
  std::vector<Vector3> primary_local_m;     ///< from the vehicle's position to the viewpoint
  GuidingViewpoint viewpoint;
  std::vector<PlaneRegion> visible;  ///< visibility regions of the waypoints of the secondary's path
};

/// Stages of planning, in their order.
enum class PlanningStage { kSecondaryPath, kViewpoint, kPrimaryPath };

/// Other vehicles, beside the primary and the moving secondary vehicle.
struct TeamTraffic {
  /// Remaining path of the secondary vehicle to the start of this plan. If it is not empty, both vehicles fly at the
  /// same time, and the guide's path also keeps clear of the air of this whole path.
  std::span<const PlannedPose> flying = {};
  std::vector<Vector3> hovering_local_m = {};  ///< other secondary vehicles
};

/// Plans once, from a map without vehicles. The air above and below each vehicle is kept free of the others, because of
/// rotor downwash. Keep-out volumes are overlaid on the map without a copy. A pure function.
///
/// A goal too near to an obstacle is replaced by the nearest clear position within goal_search_m.
/// @param begins  called at the beginning of each stage, for timing
TeamPlan plan_team(const OccupancyView& map, const TeamPlannerConfig& config, const Vector3& primary_local_m,
                   const PlannedPose& secondary, const PlannedPose& goal, const TeamTraffic& traffic = {},
                   const std::function<void(PlanningStage)>& begins = {});

}  // namespace swiftlet
