// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/rbl_config.hpp"

namespace swiftlet {

void RblCellConfig::visit(ConfigVisitor& v) {
  v.field("sensing_radius_m", sensing_radius_m, "[m] r_s: sensing radius, radius of the uncut cell S",
          Range::positive());
  v.field("step_m", step_m, "[m] spacing of the samples of a cell; not in the document", Range::positive());
  v.choice("lattice", lattice, {"agent", "world"},
           "[-] samples centered at the agent (symmetric), or on multiples of the step in the local frame");
  v.field("encumbrance_m", encumbrance_m, "[m] delta: radius of the sphere that a vehicle occupies", Range::positive());
  v.field("eta", eta, "[-] scale of the cells: share of the distance to a neighbor that belongs to the agent",
          Range{0.0, 1.0, true, false});
  v.choice("cut", cut, {"program", "buffered", "continued"},
           "[-] interpretation of (2.3): distance from the agent to the plane that cuts its cell, for a neighbor at "
           "distance d and Delta = 2 delta: Delta + eta (d - 2 Delta), but d - Delta for d < 2 Delta (program); half "
           "of d - Delta (buffered); Delta + eta (d - 2 Delta) at any d (continued)");
  v.check(step_m <= sensing_radius_m, "step_m", "at most sensing_radius_m");
  v.check(sensing_radius_m / step_m <= 60.0, "step_m", "at least a sixtieth of sensing_radius_m");
}

void RblRules::visit(ConfigVisitor& v) {
  const Range positive = Range::positive();
  const Range non_negative = Range::non_negative();
  v.field("weight_near_m", weight_near_m,
          "[m] d_1 of (2.7): beta falls if c_A is nearer than this to the agent, and farther than d_2 from c_S",
          non_negative);
  v.field("weight_gap_m", weight_gap_m, "[m] d_2 of (2.7): least distance of c_A from c_S at which beta falls",
          non_negative);
  v.field("weight_goal_m", weight_goal_m,
          "[m] beta falls too if c_A is nearer than d_1 and the goal nearer than this; at r_s, the goal lies in S; 0: "
          "as in the document",
          non_negative);
  v.field("azimuth_near_m", azimuth_near_m,
          "[m] d_3 of (2.8), (2.11): horizontal distance of c_A below which theta grows, with d_4", non_negative);
  v.field("azimuth_gap_m", azimuth_gap_m,
          "[m] d_4 of (2.8), (2.11): horizontal distance of c_A from c_S above which theta grows, with d_3",
          non_negative);
  v.field("elevation_near_m", elevation_near_m,
          "[m] d_5 of (2.15): vertical distance of c_A below which phi changes, with d_6", non_negative);
  v.field("elevation_gap_m", elevation_gap_m,
          "[m] d_6 of (2.15): vertical distance of c_A from c_S above which phi changes, with d_5", non_negative);
  v.field("elevation_shrink_m", elevation_shrink_m,
          "[m] d_7 of (2.15): horizontal distance by which c_A is nearer than c_S, above which phi changes",
          non_negative);
  v.field("beta_desired_m", beta_desired_m,
          "[m] beta^D of (2.7): weighting length without conflict; smaller values fly more directly to the goal",
          positive);
  v.field("beta_min_m", beta_min_m,
          "[m] beta_min of (2.7): least weighting length; not in the document, 0.1 in the authors' later program",
          positive);
  v.field("weight_rate_mps", weight_rate_mps, "[m/s] k of (2.7): rate at which beta falls", non_negative);
  v.field("azimuth_rate_radps", azimuth_rate_radps, "[rad/s] k of (2.8), (2.11): rate at which theta grows",
          non_negative);
  v.field("azimuth_return_radps", azimuth_return_radps,
          "[rad/s] rate at which theta returns to 0; k in print, 2 in the authors' 2D program", non_negative);
  v.field("elevation_rate_radps", elevation_rate_radps, "[rad/s] k of (2.19): rate of phi", non_negative);
  v.field("centering_weight", centering_weight, "[-] w_1 of (2.18): weight of the height of c_S in the sign of phi",
          non_negative);
  v.field("direction_weight", direction_weight,
          "[-] w_2 of (2.18): weight of the direction to the goal in the sign of phi", non_negative);
  v.choice("azimuth_condition", azimuth_condition, {"near", "printed"},
           "[-] turn when c_A is nearer than d_3 (stuck; the authors' program), or farther (as printed)");
  v.choice(
      "azimuth_reset", azimuth_reset, {"detour", "near", "none"},
      "[-] the condition missing in (2.9), (2.12): the direct centroid is farther than the turned one (the authors' "
      "program), or farther than d_3");
  v.choice("elevation_condition", elevation_condition, {"gap", "printed"},
           "[-] first part of (2.15): vertical gap above d_6 and c_A nearer than d_5, or below d_6 as printed");
  v.choice("direction_influence", direction_influence, {"north", "printed", "program"},
           "[-] (2.17): +1 to the north, -1 to the south (the text), the printed formula, or the authors' program");
  v.choice("elevation_sense", elevation_sense, {"level", "up", "printed"},
           "[-] positive phi turns the destination up, and its own turn counts backwards in (2.18); up, and counts as "
           "printed; or down, as (2.20) is printed");
  v.field("azimuth_rule", azimuth_rule, "[-] whether the right-hand rule (2.8) to (2.12) is applied");
  v.check(centering_weight + direction_weight > 0.0, "direction_weight", "a weight above 0 beside centering_weight");
  v.check(beta_min_m <= beta_desired_m, "beta_min_m", "at most beta_desired_m");
}

void RblLidarConfig::visit(ConfigVisitor& v) {
  v.field("enabled", enabled, "[-] whether the vehicle avoids obstacles in its map (mapping) [Kamler 2025, chapter 3]");
  v.choice("legal", legal, {"sensed", "cell"},
           "[-] cell A' of admissible goals in the field of view: cut by the voxels sensed now, or the whole cell A "
           "(authors' "
           "experiment files)");
  v.field("fov_lower_deg", fov_lower_deg,
          "[deg] gamma of (3.2): angle of the lower edge of the field of view below the sensor's horizontal plane",
          Range::between(-90.0, 90.0));
  v.field("fov_deg", fov_deg, "[deg] alpha of (3.3): vertical field of view", Range::between(1.0, 180.0));
  v.field("facing_deg", facing_deg,
          "[deg] largest angle between heading and direction to the centroid at which the vehicle flies",
          Range::between(1.0, 180.0));
}

void RblConfig::visit(ConfigVisitor& v) {
  v.model("model", model, "guidance",
          "preset: rbl_thesis (the document's own settings) or rbl_thesis_files (its authors' experiment files)");
  v.choice("variant", variant, kVariants,
           "[-] shape of S: disc at one height; ball; ball between z_min_m and z_max_m (2.14); the last with the "
           "z-rule (2.15-2.19)");
  v.field("goal_m", goal_m, "[m] goal in the world frame");
  v.field("arrival_radius_m", arrival_radius_m, "[m] r_g: distance to the goal within which the mission is done",
          Range::positive());
  v.field(
      "settle_s", settle_s,
      "[s] time without progress after which the mission ends with the reason: the goal is occupied, or outside of the "
      "limits; 0: never",
      Range::non_negative());
  v.field("speed_mps", speed_mps, "[m/s] largest speed, within the motion limits", Range::positive());
  v.field(
      "ground_m", ground_m,
      "[m] height of the ground, for the variant 3d without height limits: the vehicle stays one encumbrance above");
  v.field("z_min_m", z_min_m, "[m] lowest flight level (2.14)");
  v.field("z_max_m", z_max_m, "[m] highest flight level (2.14)");
  v.object("cells", cells, "cells S and A");
  v.object("rules", rules, "weighting, azimuth and elevation rules");
  v.object("separation", separation, "braking planes, pledges and evasion beyond the cells of the document");
  v.object("neighbors", neighbors, "source of the neighbors");
  v.object("lidar", lidar, "avoidance of obstacles");
  // With a map, the vehicle keeps clear of an obstacle at its goal, and reports it after settle_s. So the goal need not
  // be free of obstacles.
  if (variant != Variant::k2d && !lidar.enabled) v.destinations("goal_m", goal_m);
  v.object("detour", detour, "detour out of a dead end between obstacles");
  v.check(z_max_m > z_min_m, "z_max_m", "more than z_min_m");
}

}  // namespace swiftlet
