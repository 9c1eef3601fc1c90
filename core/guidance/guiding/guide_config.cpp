// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "swiftlet/core/guidance/guide.hpp"

namespace swiftlet {

void GuideAdvanceConfig::visit(ConfigVisitor& v) {
  v.field("step_m", step_m,
          "[m] displacement of each goal from the guided vehicle's position, world axes; 0: goals_m is used",
          Range::between(-1000.0, 1000.0));
  v.field("distance_m", distance_m,
          "[m] horizontal distance from the first position after which the mission is complete", Range::positive());
}

void GuidedVehicleConfig::visit(ConfigVisitor& v) {
  v.field("name", name, "[-] name of the vehicle");
  v.field("goals_m", goals_m, "[m] goals of the guided vehicle in order, world frame", Range::between(-1e5, 1e5));
  v.field("goal_yaws_deg", goal_yaws_deg, "[deg] headings at the goals; empty: the heading is kept");
  v.check(goal_yaws_deg.empty() || goal_yaws_deg.size() == goals_m.size(), "goal_yaws_deg",
          "as many as goals_m, or none");
}

void GuideConfig::visit(ConfigVisitor& v) {
  v.field("secondary", secondary, "[-] name of the guided vehicle");
  v.list("secondaries", secondaries,
         "several guided vehicles, which move in turn, one goal each, while the others hover. Then secondary and "
         "goals_m must be empty");
  v.field("goals_m", goals_m, "[m] goals of the guided vehicle in order, world frame", Range::between(-1e5, 1e5));
  v.field("goal_yaws_deg", goal_yaws_deg, "[deg] headings at the goals; empty: the heading is kept");
  v.object("advance", advance, "goals relative to the guided vehicle's position, instead of goals_m");
  v.field("loop", loop, "[-] whether the first goal follows the last");
  v.field("periodic", periodic, "[-] whether the remaining path is sent periodically; false: the path is sent once");
  v.choice("motion", motion, {"alternate", "ahead", "together"},
           "[-] alternate: the next leg is planned while both vehicles hover; ahead: while the guided vehicle flies; "
           "together: as ahead, and both fly at the same time");
  v.field("visited_m", visited_m, "[m] distance within which a waypoint counts as visited", Range::positive());
  v.field("speed_mps", speed_mps, "[m/s] greatest horizontal and greatest vertical speed of the guide",
          Range::positive());
  v.field("planning_latency_s", planning_latency_s,
          "[s] delay from the start of a search to its result, for the computing time on board",
          Range::between(0.0, 1000.0));
  v.field("settle_s", settle_s, "[s] time for which both vehicles hover before planning", Range::between(0.0, 1000.0));
  v.field("link_timeout_s", link_timeout_s,
          "[s] time without odometry from the guided vehicle after which both vehicles hover", Range::positive());
  v.field("sigma_max_m", sigma_max_m,
          "[m] standard deviation of the guided vehicle's position, along its most uncertain axis, above which both "
          "vehicles hover",
          Range::positive());
  v.field("stage_timeout_s", stage_timeout_s,
          "[s] time limit of each stage: search for the guided vehicle, planning, motion; a longer stage has failed",
          Range::positive());
  v.field("retries", retries,
          "[-] number of failures after which the guide plans again; one more failure ends the mission",
          Range::between(0, 1e6));
  v.object("planner", planner, "paths of both vehicles and the viewpoint");
  v.check(goal_yaws_deg.empty() || goal_yaws_deg.size() == goals_m.size(), "goal_yaws_deg",
          "as many as goals_m, or none");
  v.check(secondaries.empty() || secondary.empty(), "secondary", "an empty name together with secondaries");
  v.check(secondaries.empty() || goals_m.empty(), "goals_m",
          "no goals together with secondaries, which have goals of their own");
  v.check(secondaries.empty() || motion == Motion::kAlternate, "motion", "alternate together with secondaries");
  const bool all_have_goals =
      secondaries.empty() ? !goals_m.empty()
                          : std::ranges::none_of(secondaries, [](const auto& one) { return one.goals_m.empty(); });
  v.check(!loop || all_have_goals, "loop", "false unless every guided vehicle has goals_m");
}

}  // namespace swiftlet
