// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/stage_tables/guidances.hpp"

#include "swiftlet/core/guidance/agile.hpp"
#include "swiftlet/core/guidance/bird.hpp"
#include "swiftlet/core/guidance/explore.hpp"
#include "swiftlet/core/guidance/flocking.hpp"
#include "swiftlet/core/guidance/follow_guide.hpp"
#include "swiftlet/core/guidance/guide.hpp"
#include "swiftlet/core/guidance/hover.hpp"
#include "swiftlet/core/guidance/navigate.hpp"
#include "swiftlet/core/guidance/orca.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/guidance/share_paths.hpp"
#include "swiftlet/core/guidance/takeoff_land.hpp"
#include "swiftlet/core/guidance/timed_path.hpp"
#include "swiftlet/core/guidance/trajectory.hpp"
#include "swiftlet/core/guidance/waypoints.hpp"
#include "swiftlet/core/interception/intercept.hpp"
#include "swiftlet/core/interception/target.hpp"

namespace swiftlet {
namespace {

/// Adds the net whose captures the simulation records, and the number of captures that ends the mission.
void add_intercept_needs(const ModuleConfig& config, AgentNeeds& needs) {
  const auto& intercept = dynamic_cast<const InterceptConfig&>(config);
  needs.net = intercept.net;
  needs.captures = intercept.captures;
}

constexpr GuidanceType kGuidanceTypes[] = {
    {{"hover", "hovers at the start or at a point", make_module_config<HoverConfig>}, make_hover, nullptr, ""},
    {{"waypoints", "flies from waypoint to waypoint", make_module_config<WaypointsConfig>},
     make_waypoints,
     nullptr,
     "waypoints"},
    {{"trajectory", "flies a circle, a Lissajous curve or a line", make_module_config<TrajectoryConfig>},
     make_trajectory,
     nullptr,
     ""},
    {{"timed_path", "follows a configured trajectory: a spline through points with given times",
      make_module_config<TimedPathConfig>},
     make_timed_path,
     nullptr,
     "path"},
    {{"navigate", "flies from goal to goal along collision-free paths, which it plans in its local map",
      make_module_config<NavigateConfig>},
     make_navigate,
     nullptr,
     "navigate.path"},
    {{"explore", "explores a box: flies to viewpoints until none that is reachable would show unknown space",
      make_module_config<ExploreConfig>},
     make_explore,
     nullptr,
     "explore.path explore.view"},
    {{"agile", "flies smooth random trajectories at high speed in a box", make_module_config<AgileConfig>},
     make_agile,
     nullptr,
     ""},
    {{"bird", "flies like a small bird: sudden turns, bounding flight, and perches", make_module_config<BirdConfig>},
     make_bird,
     nullptr,
     ""},
    {{"takeoff_land", "takes off, hovers and lands", make_module_config<TakeoffLandConfig>},
     make_takeoff_land,
     nullptr,
     ""},
    {{"rbl", "rule-based Lloyd algorithm: flies to the centroid of its cell, in 2D or 3D",
      make_module_config<RblConfig>},
     make_rbl,
     nullptr,
     "rbl.cell rbl.cell_outline rbl.sensing rbl.samples rbl.centroid rbl.sensing_centroid rbl.destination rbl.goal "
     "rbl.voxels rbl.path"},
    {{"pacnav",
      "PACNav flocking: informed vehicles fly to the goal, uninformed ones follow the neighbor with the most "
      "persistent path",
      make_module_config<PacnavConfig>},
     make_pacnav,
     nullptr,
     ""},
    {{"orca", "optimal reciprocal collision avoidance (ORCA), a baseline for comparison",
      make_module_config<OrcaConfig>},
     make_orca,
     nullptr,
     ""},
    {{"share_paths", "broadcasts its planned path and plans around received paths, a baseline for comparison",
      make_module_config<SharePathsConfig>},
     make_share_paths,
     nullptr,
     ""},
    {{"follow_guide", "follows paths that another vehicle sends in the follower's body frame [Pritzl 2024]",
      make_module_config<FollowGuideConfig>},
     make_follow_guide,
     nullptr,
     "guided_path"},
    {{"guide", "plans paths for another vehicle and for itself, and guides the other by radio [Pritzl 2024]",
      make_module_config<GuideConfig>},
     make_guide,
     nullptr,
     "guide.secondary_path guide.primary_path guide.visible guide.overlap guide.viewpoint"},
    {{"intercept", "captures a flying target with a net, by model predictive control or a pursuit law [Vrba 2025]",
      make_module_config<InterceptConfig>},
     make_intercept,
     add_intercept_needs,
     "intercept.prediction intercept.plan intercept.net intercept.fence intercept.search"},
    {{"target", "intruder that hovers, flies lines, curves or random trajectories, or evades tracked vehicles",
      make_module_config<TargetConfig>},
     make_target,
     nullptr,
     ""},
    {{"mezey", "purely vision-based flocking by the projections of neighbors on a 1D retina",
      make_module_config<MezeyConfig>},
     make_mezey,
     nullptr,
     ""},
};

}  // namespace

Registry<GuidanceType>& guidance_registry() {
  static Registry<GuidanceType> table("guidance", kGuidanceTypes);
  return table;
}

std::unique_ptr<Guidance> make_guidance(const Module& config, const GuidanceSetup& setup) {
  return guidance_registry().make(config, setup);
}

}  // namespace swiftlet
