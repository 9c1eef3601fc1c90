// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/chase_mpc.hpp"
#include "swiftlet/core/interception/intercept.hpp"

namespace swiftlet {

void ChasePlanConfig::visit(ConfigVisitor& v) {
  v.field("steps", steps, "[-] number of steps of the plan", Range::between(2, ChaseMpc::kMaxSteps));
  v.field("reach_share", reach_share,
          "[-] share of the net's radius within which plans meet the target; larger values meet earlier, but nearer to "
          "the rim",
          Range{0.0, 1.0, true, false});
}

void InterceptConfig::visit(ConfigVisitor& v) {
  v.choice("method", method, {"mpc", "frpn", "proportional_navigation", "pure_pursuit"},
           "[-] method: plan by model predictive control, or a pursuit law as a baseline");
  v.field("target", target,
          "[-] name of the vehicle to capture, with the tracker ground_truth only; empty: the nearest track");
  v.field("captures", captures, "[-] number of captures until the mission is done; 0: without end",
          Range::non_negative());
  v.object("net", net, "the capture volume");
  v.object("fence", fence, "limits of the flight");
  v.choice("walls", walls, {"none", "map"},
           "[-] obstacles in addition to the fence: none, or the map of the mapping stage");
  v.field("clearance_m", clearance_m, "[m] minimum distance from the vehicle's center to occupied cells of the map",
          Range::positive());
  v.field("target_clearance_m", target_clearance_m,
          "[m] minimum distance between the centers of vehicle and target; 0: any", Range::non_negative());
  v.field("bystander_clearance_m", bystander_clearance_m,
          "[m] minimum distance between the centers of vehicle and any other track", Range::non_negative());
  v.field("yield_clearance_m", yield_clearance_m, "[m] distance of plans from another interceptor that arrives sooner",
          Range::non_negative());
  v.field("period_s", period_s, "[s] period of planning", Range{0.004, 1.0});
  v.object("plan", plan, "plan of method mpc");
  v.object("prediction", prediction, "prediction of the target");
  v.object("gains", gains, "gains of the other methods");
  v.object("search", search, "search for a lost target");
}

}  // namespace swiftlet
