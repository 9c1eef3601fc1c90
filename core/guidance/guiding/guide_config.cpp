// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "swiftlet/core/guidance/guide.hpp"

namespace swiftlet {

void GuideAdvanceConfig::visit(ConfigVisitor& v) {
  v.field("step_m", step_m, "[m] displacement from the guided vehicle to its next goal, world axes; 0: goals_m",
          Range::between(-1000.0, 1000.0));
  v.field("distance_m", distance_m, "[m] horizontal distance from the first position at which the mission is done",
          Range::positive());
}

void GuidedVehicleConfig::visit(ConfigVisitor& v) {
  v.field("name", name, "[-] name of the vehicle");
  v.field("goals_m", goals_m, "[m] goals of the guided vehicle in order, world frame", Range::between(-1e5, 1e5));
  v.field("goal_yaws_deg", goal_yaws_deg, "[deg] headings at the goals; none: the heading is kept");
  v.check(goal_yaws_deg.empty() || goal_yaws_deg.size() == goals_m.size(), "goal_yaws_deg",
          "as many as goals_m, or none");
}

void GuideConfig::visit(ConfigVisitor& v) {
  v.field("secondary", secondary, "[-] name of the guided vehicle");
  v.list("secondaries", secondaries,
         "several guided vehicles, in turn goal by goal: one moves, the others hover. Then secondary and goals_m stay "
         "empty");
  v.field("goals_m", goals_m, "[m] goals of the guided vehicle in order, world frame", Range::between(-1e5, 1e5));
  v.field("goal_yaws_deg", goal_yaws_deg, "[deg] headings at the goals; none: the heading is kept");
  v.object("advance", advance, "goals relative to the guided vehicle's position, instead of goals_m");
  v.field("loop", loop, "[-] whether the first goal follows the last");
  v.field("periodic", periodic, "[-] whether the rest of the path is sent periodically; false: the path once");
  v.choice("motion", motion, {"alternate", "ahead", "together"},
           "[-] the next leg is planned while both hover, while the guided vehicle flies, or so that both fly at once");
  v.field("visited_m", visited_m, "[m] distance within which a waypoint counts as visited", Range::positive());
  v.field("speed_mps", speed_mps, "[m/s] highest speed of the guide, horizontal and vertical each", Range::positive());
  v.field("planning_latency_s", planning_latency_s,
          "[s] delay from the start of a search to its result, as of the onboard computer",
          Range::between(0.0, 1000.0));
  v.field("settle_s", settle_s, "[s] time for which both hover before planning", Range::between(0.0, 1000.0));
  v.field("link_timeout_s", link_timeout_s, "[s] time without odometry of the guided vehicle after which both hover",
          Range::positive());
  v.field("sigma_max_m", sigma_max_m,
          "[m] standard deviation of the guided vehicle's position along the worst axis above which both hover",
          Range::positive());
  v.field(
      "search_after_s", search_after_s,
      "[s] time without an estimate after which the guide requests a motion that makes the guided vehicle observable",
      Range::positive());
  v.field("stage_timeout_s", stage_timeout_s, "[s] time after which the search, planning or a motion has failed",
          Range::positive());
  v.field("retries", retries, "[-] new plans after failures; the next failure then fails the mission",
          Range::between(0, 1e6));
  v.field("retry_after_s", retry_after_s, "[s] delay after a failure until the next plan", Range::non_negative());
  v.object("planner", planner, "paths of both vehicles and the viewpoint");
  v.check(goal_yaws_deg.empty() || goal_yaws_deg.size() == goals_m.size(), "goal_yaws_deg",
          "as many as goals_m, or none");
  v.check(secondaries.empty() || secondary.empty(), "secondary", "none beside secondaries");
  v.check(secondaries.empty() || goals_m.empty(), "goals_m", "none beside secondaries, which have their own");
  v.check(secondaries.empty() || motion == Motion::kAlternate, "motion", "alternate with secondaries");
  const bool all_have_goals =
      secondaries.empty() ? !goals_m.empty()
                          : std::ranges::none_of(secondaries, [](const auto& one) { return one.goals_m.empty(); });
  v.check(!loop || all_have_goals, "loop", "false without goals_m");
}

}  // namespace swiftlet
