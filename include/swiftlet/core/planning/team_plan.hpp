// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/planning/clear_path.hpp"
#include "swiftlet/core/planning/guiding_viewpoint.hpp"

/// Paths for a primary vehicle, which has the map, and for a secondary one that it guides [Pritzl 2024, alg. 1].
namespace swiftlet {

/// The defaults are those of [Pritzl 2024, tab. I].
struct TeamPlannerConfig {
  double tolerance_m = 0.3;
  double waypoint_spacing_m = 0.5;
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

/// A place with a heading, in the local frame of the primary vehicle.
struct PlannedPose {
  Vector3 p_local_m = Vector3::Zero();
  double yaw_rad = 0.0;
};

/// What is to be done next.
struct TeamPlan {
  enum class Next { kGoalReached, kMovePrimary, kMoveSecondary, kFail };
  Next next = Next::kFail;
  std::string reason;  ///< why it failed
  ClearPathStatus primary_search = ClearPathStatus::kFound;
  ClearPathStatus secondary_search = ClearPathStatus::kFound;
  Vector3 goal_local_m = Vector3::Zero();
  std::vector<PlannedPose> secondary_path;  ///< from where it stands to the goal
  std::vector<Vector3> primary_local_m;     ///< from where it stands to the viewpoint
  GuidingViewpoint viewpoint;
  std::vector<PlaneRegion> visible;  ///< from where the waypoints of the secondary's path are seen
};

/// What planning does one after the other.
enum class PlanningStage { kSecondaryPath, kViewpoint, kPrimaryPath };

/// Who else is in the air beside the primary vehicle and the secondary one that is to move.
struct TeamTraffic {
  /// What the secondary vehicle still has to fly to the place from which this plan begins. When it is not empty, both
  /// vehicles fly at once: the guide's path keeps out of the air of the whole path, too.
  std::span<const PlannedPose> flying = {};
  std::vector<Vector3> hovering_local_m = {};  ///< other secondary vehicles
};

/// Plans once, from a map in which no vehicle is. The air above and below each is kept free of the others,
/// because of the wind of its rotors. It is laid over the map, which is not copied. A pure function.
///
/// The goal may lie too near to an obstacle. Then the nearest clear place within goal_search_m takes its stead.
/// @param begins  told when a stage begins, for those who time them
TeamPlan plan_team(const OccupancyView& map, const TeamPlannerConfig& config, const Vector3& primary_local_m,
                   const PlannedPose& secondary, const PlannedPose& goal, const TeamTraffic& traffic = {},
                   const std::function<void(PlanningStage)>& begins = {});

}  // namespace swiftlet
