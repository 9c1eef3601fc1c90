// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/rbl_config.hpp"

namespace swiftlet {

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
