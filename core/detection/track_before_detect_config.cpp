// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/track_before_detect_config.hpp"

namespace swiftlet {

void ExpectedTarget::visit(ConfigVisitor& v) {
  v.field("radius_m", radius_m, "[m] of the disc as which a target is seen", Range{0.0, 10.0, true});
  v.field("return_share", return_share, "[-] of the beams through that disc that are returned, in the mean",
          Range{0.0, 1.0, true});
  v.field("return_variation", return_variation,
          "[-] shape of that share's gamma distribution over sweeps; 1: exponential", Range{0.0, 1e6, true});
  v.field("least_share", least_share, "[-] the same of the smallest UAV, at which birds are told from UAVs",
          Range{0.0, 1.0, true});
  v.field("small_share", small_share, "[-] the same of what is too small for a UAV", Range{0.0, 1.0, true});
  v.field("small_prior", small_prior, "[-] share of those that fly that are too small; 0: nobody asks",
          Range::between(0.0, 0.99));
  v.field("small_within_m", small_within_m,
          "[m] farther targets may return less because they are far, and are not asked", Range::non_negative());
  v.check(small_share < least_share, "small_share", "less than least_share");
  v.field("max_size_m", max_size_m, "[m] diagonal of the box around the returns of one sweep", Range{0.0, 100.0, true});
  v.field("body_m", body_m,
          "[m] targets nearer to each other than this may be parts of one body, which is decided by what is returned "
          "between them; 0: never",
          Range::between(0.0, 20.0));
  v.field("seen_side_m", seen_side_m, "[m] from the mean of the returns to the middle of a target, along the beam",
          Range::non_negative());
  v.field("sigma_sampling_m", sigma_sampling_m, "[m] deviation of single returns from the middle, by axis",
          Range::non_negative());
  v.field("sigma_velocity_mps", sigma_velocity_mps, "[m/s] of a target of which one return is known, by axis",
          Range::positive());
  v.field("acceleration_density", acceleration_density, "[m^2/s^3] white acceleration of a target, by axis",
          Range::positive());
  v.field("birth_per_m3", birth_per_m3, "[1/m^3] targets that nobody knows of yet, anywhere", Range{0.0, 1.0, true});
  v.field("strangers_per_m3", strangers_per_m3,
          "[1/m^3] targets that come into view and were never seen, against those that come back",
          Range{0.0, 1.0, true});
  v.field("lifetime_s", lifetime_s, "[s] that a target stays, in the mean", Range::positive());
  v.field("seen_for_s", seen_for_s, "[s] until something hides it that the beams do not tell of, in the mean",
          Range::positive());
  v.field("hidden_for_s", hidden_for_s, "[s] that it is hidden so, in the mean", Range::positive());
}

void ExpectedNoise::visit(ConfigVisitor& v) {
  v.field("sigma_range_m", sigma_range_m, "[m] of the range", Range::positive());
  v.field("sigma_position_m", sigma_position_m, "[m] of the sensor's position by axis", Range::non_negative());
  v.field("sigma_attitude_rad", sigma_attitude_rad, "[rad] of its attitude by axis", Range::non_negative());
}

void TrackBeforeDetectConfig::visit(ConfigVisitor& v) {
  v.field("sensor", sensor, "LiDAR to listen to; empty: all");
  v.object("air", air, "where beams pass, and where the background returns them");
  v.object("target", target, "what is expected of a target");
  v.object("noise", noise, "Sigma_w: noise of range and pose");
  v.field("told_existence", told_existence, "[-] hypotheses that exist with at least this probability are detections",
          Range::probability());
  v.field("background_share", background_share,
          "[-] where more of the beams end in the background, nothing is taken for a target", Range::probability());
  v.field("free_share", free_share,
          "[-] hypotheses begin only where in the next voxels fewer of the beams end; the prior of `air` says how many "
          "must have passed",
          Range::probability());
  v.field("hit_share", hit_share, "[-] and where in no voxel within free_reach_m more of them end",
          Range::probability());
  v.field("free_reach_m", free_reach_m, "[m] as far as that; farther by the noise of the attitude",
          Range::between(0.0, 20.0));
  v.field("free_air_share", free_air_share,
          "[-] of the beams through a voxel of such free air that something other than a target returns",
          Range{0.0, 1.0, true});
  v.check(free_share <= background_share, "free_share", "at most background_share");
  v.field("learning_delay_s", learning_delay_s, "[s] after which what is no target has become background",
          Range::between(0.0, 60.0));
  v.field("cluster_distance_m", cluster_distance_m, "[m] returns as near as this are of one target",
          Range{0.0, 100.0, true});
  v.field("sigma_lost_m", sigma_lost_m, "[m] a hypothesis whose place is less sure by any axis is given up",
          Range::positive());
  v.field(
      "sigma_hidden_m", sigma_hidden_m,
      "[m] a target that was given up is known again as long as its place is surer than this by every axis; 0: never",
      Range::non_negative());
  v.field("max_range_m", max_range_m, "[m] from the sensor to a target", Range::positive());
  v.field("ray_max_m", ray_max_m, "[m] so far the air before a return is cleared", Range{0.0, 1000.0, true});
  v.field("empty_ray_m", empty_ray_m, "[m] and that of a beam without return; 0: not at all",
          Range::between(0.0, 1000.0));
  v.field("rays_per_sweep", rays_per_sweep, "[-] beams of a sweep that clear air, at most; others follow in the next",
          Range::between(1.0, 1e7));
  v.field("max_hypotheses", max_hypotheses, "[-] the most likely ones are kept", Range::between(1.0, 4096.0));
  v.field("latency_s", latency_s, "[s] from a sweep to its detections; of those that wait, the newest wins",
          Range::non_negative());
}

}  // namespace swiftlet
