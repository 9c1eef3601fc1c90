// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/interception/intercept.hpp"

namespace swiftlet {

void ChasePlanConfig::visit(ConfigVisitor& v) {
  v.field("steps", steps, "[-] number of steps of the plan", Range::between(2, ChaseMpc::kMaxSteps));
  v.field("horizon_min_s", horizon_min_s, "[s] shortest horizon of the plan", Range{0.1, 60.0});
  v.field("horizon_max_s", horizon_max_s, "[s] longest horizon; between both, 1.3 times the time to go",
          Range{0.1, 60.0});
  v.field("weight_before", weight_before, "[-] weight of squared distances before the meeting, relative to 1 at it",
          Range::probability());
  v.field("weight_after", weight_after,
          "[-] weight after the meeting; at 1 the vehicle stays with the target, and arrives later",
          Range::probability());
  v.field("meeting_s", meeting_s, "[s] duration of the meeting", Range::positive());
  v.field("velocity_weight", velocity_weight, "[s^2] weight of the squared difference of velocities at the meeting",
          Range::non_negative());
  v.field("hold_m", hold_m, "[m] vertical distance that a disc keeps from the target until they meet",
          Range::non_negative());
  v.field("through_m", through_m, "[m] vertical distance by which a disc then passes the target",
          Range::non_negative());
  v.field("crossing_mps", crossing_mps, "[m/s] vertical speed at which a disc crosses the target's height",
          Range::positive());
  v.field("crossing_delay_s", crossing_delay_s,
          "[s] delay from the target within reach to the crossing; less if the target would be out of reach by then",
          Range::non_negative());
  v.object("solver", solver, "solver of the condensed problem");
  v.check(horizon_max_s >= horizon_min_s, "horizon_max_s", "at least horizon_min_s");
}

void InterceptConfig::visit(ConfigVisitor& v) {
  v.choice("method", method, {"mpc", "frpn", "proportional_navigation", "pure_pursuit"},
           "[-] plan by model predictive control, or one of the laws with which that is compared");
  v.field("target", target, "[-] vehicle to catch, with tracker ground_truth only; empty: the nearest track");
  v.field("captures", captures, "[-] number of captures until the mission is done; 0: without end",
          Range::non_negative());
  v.object("net", net, "the capture volume");
  v.field("sure_share", sure_share,
          "[-] share of the net's size within which a track is a capture; a precise track is one anywhere in the net",
          Range{0.0, 1.0, true, false});
  v.object("fence", fence, "limits of the flight");
  v.choice("walls", walls, {"none", "map"},
           "[-] obstacles in addition to the fence: none, or the map of the mapping stage");
  v.field("clearance_m", clearance_m, "[m] least distance from the vehicle's center to occupied cells of the map",
          Range::positive());
  v.field("target_clearance_m", target_clearance_m,
          "[m] least distance between the centers of vehicle and target; 0: any", Range::non_negative());
  v.field("bystander_clearance_m", bystander_clearance_m,
          "[m] least distance between the centers of vehicle and any other track", Range::non_negative());
  v.field("yield_clearance_m", yield_clearance_m, "[m] distance of plans from another interceptor that arrives sooner",
          Range::non_negative());
  v.field("period_s", period_s, "[s] period of planning", Range{0.004, 1.0});
  v.field("track_timeout_s", track_timeout_s, "[s] age beyond which a track is lost", Range::positive());
  v.field("after_capture_s", after_capture_s,
          "[s] longest time for which a caught target is left before the next approach", Range::non_negative());
  v.object("plan", plan, "plan of method mpc");
  v.object("prediction", prediction, "prediction of the target");
  v.object("gains", gains, "gains of the other methods");
  v.object("search", search, "search for a lost target");
}

}  // namespace swiftlet
