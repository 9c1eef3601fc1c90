// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/interception/intercept.hpp"

namespace swiftlet {

void ChasePlanConfig::visit(ConfigVisitor& v) {
  v.field("steps", steps, "[-] of the plan", Range::between(2, ChaseMpc::kMaxSteps));
  v.field("horizon_min_s", horizon_min_s, "[s] the plan is no shorter", Range{0.1, 60.0});
  v.field("horizon_max_s", horizon_max_s, "[s] and no longer; otherwise 1.3 times the time to go", Range{0.1, 60.0});
  v.field("weight_before", weight_before, "[-] of squared distances before the meeting, against 1 at it",
          Range::probability());
  v.field("weight_after", weight_after, "[-] and after it; 1: it stays with the target, and comes later for that",
          Range::probability());
  v.field("meeting_s", meeting_s, "[s] how long the meeting lasts", Range::positive());
  v.field("velocity_weight", velocity_weight, "[s^2] of the squared difference of velocities at the meeting",
          Range::non_negative());
  v.field("hold_m", hold_m, "[m] a disc stays above or below the target by this until they meet",
          Range::non_negative());
  v.field("through_m", through_m, "[m] and then goes through it by this", Range::non_negative());
  v.field("crossing_mps", crossing_mps, "[m/s] at which a disc goes through the target's height", Range::positive());
  v.field("crossing_delay_s", crossing_delay_s,
          "[s] after the target is within reach a disc goes through, earlier when it would be out of reach by then",
          Range::non_negative());
  v.object("solver", solver, "of the condensed problem");
  v.check(horizon_max_s >= horizon_min_s, "horizon_max_s", "at least horizon_min_s");
}

void InterceptConfig::visit(ConfigVisitor& v) {
  v.choice("method", method, {"mpc", "frpn", "proportional_navigation", "pure_pursuit"},
           "[-] plan by model predictive control, or one of the laws with which that is compared");
  v.field("target", target, "[-] vehicle to catch, with tracker ground_truth only; empty: the nearest track");
  v.field("captures", captures, "[-] then it is done; 0: goes on for ever", Range::non_negative());
  v.object("net", net, "what catches");
  v.field("sure_share", sure_share,
          "[-] share of the net's size within which a track is a capture; a precise track is one anywhere in the net",
          Range{0.0, 1.0, true, false});
  v.object("fence", fence, "where it may fly");
  v.choice("walls", walls, {"none", "map"},
           "[-] what it keeps clear of beside the fence: what the mapping stage knows");
  v.field("clearance_m", clearance_m, "[m] from its center to what the map knows", Range::positive());
  v.field("target_clearance_m", target_clearance_m, "[m] from its center to that of the target; 0: any",
          Range::non_negative());
  v.field("bystander_clearance_m", bystander_clearance_m, "[m] from its center to that of any other track",
          Range::non_negative());
  v.field("yield_clearance_m", yield_clearance_m,
          "[m] plans keep this distance to another interceptor that is there sooner", Range::non_negative());
  v.field("period_s", period_s, "[s] from plan to plan", Range{0.004, 1.0});
  v.field("track_timeout_s", track_timeout_s, "[s] a track that is older is lost", Range::positive());
  v.field("after_capture_s", after_capture_s, "[s] it leaves a target that it caught for this at most, if it goes on",
          Range::non_negative());
  v.object("plan", plan, "of method mpc");
  v.object("prediction", prediction, "of the target");
  v.object("gains", gains, "of the other methods");
  v.object("search", search, "for a target that was lost");
}

}  // namespace swiftlet
