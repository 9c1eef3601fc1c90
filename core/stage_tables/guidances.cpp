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

void need_net(const ModuleConfig& config, AgentNeeds& needs) {
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
    {{"trajectory", "circle, lissajous curve or line", make_module_config<TrajectoryConfig>},
     make_trajectory,
     nullptr,
     ""},
    {{"timed_path", "follows a planned path with its times, a spline", make_module_config<TimedPathConfig>},
     make_timed_path,
     nullptr,
     "path"},
    {{"navigate", "flies from goal to goal along clear paths in its own map", make_module_config<NavigateConfig>},
     make_navigate,
     nullptr,
     "navigate.path"},
    {{"explore", "flies from view to view until no reachable view in a box shows unknown space",
      make_module_config<ExploreConfig>},
     make_explore,
     nullptr,
     "explore.path explore.view"},
    {{"agile", "random smooth flight at high speed in a box", make_module_config<AgileConfig>},
     make_agile,
     nullptr,
     ""},
    {{"bird", "a small bird: sudden turns, bounding flight, and perches", make_module_config<BirdConfig>},
     make_bird,
     nullptr,
     ""},
    {{"takeoff_land", "takes off, hovers and lands", make_module_config<TakeoffLandConfig>},
     make_takeoff_land,
     nullptr,
     ""},
    {{"rbl", "rule-based Lloyd: flies to the centroid of its cell, in 2D or 3D", make_module_config<RblConfig>},
     make_rbl,
     nullptr,
     "rbl.cell rbl.cell_outline rbl.sensing rbl.samples rbl.centroid rbl.sensing_centroid rbl.destination rbl.goal "
     "rbl.voxels rbl.path"},
    {{"pacnav", "informed vehicles fly to the goal, uninformed ones follow persistent paths",
      make_module_config<PacnavConfig>},
     make_pacnav,
     nullptr,
     ""},
    {{"orca", "reciprocal velocity avoidance, a baseline for comparison", make_module_config<OrcaConfig>},
     make_orca,
     nullptr,
     ""},
    {{"share_paths", "broadcasts the planned path, and plans around received paths",
      make_module_config<SharePathsConfig>},
     make_share_paths,
     nullptr,
     ""},
    {{"follow_guide", "follows paths that another vehicle sends in the follower's body frame [Pritzl 2024]",
      make_module_config<FollowGuideConfig>},
     make_follow_guide,
     nullptr,
     "guided_path"},
    {{"guide", "plans for another vehicle and itself, and guides it by radio [Pritzl 2024]",
      make_module_config<GuideConfig>},
     make_guide,
     nullptr,
     "guide.secondary_path guide.primary_path guide.visible guide.overlap guide.viewpoint"},
    {{"intercept", "captures a flying target with a net, by model predictive control or a pursuit law [Vrba 2025]",
      make_module_config<InterceptConfig>},
     make_intercept,
     need_net,
     "intercept.prediction intercept.plan intercept.net intercept.fence intercept.search"},
    {{"target", "an intruder: hovers, flies lines, curves or at random, or flees from tracked vehicles",
      make_module_config<TargetConfig>},
     make_target,
     nullptr,
     ""},
    {{"mezey", "flocking by the neighbors' projections on a 1D retina", make_module_config<MezeyConfig>},
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
