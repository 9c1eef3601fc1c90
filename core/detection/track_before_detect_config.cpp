// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/track_before_detect_config.hpp"

namespace swiftlet {

void ExpectedTarget::visit(ConfigVisitor& v) {
  v.field("radius_m", radius_m,
          "[m] radius of the disc that models the silhouette of a target in the view of the LiDAR",
          Range{0.0, 10.0, true});
  v.field("least_share", least_share,
          "[-] share of the beams through the disc of radius_m that return from the smallest UAV, compared with "
          "small_share to reject birds",
          Range{0.0, 1.0, true});
  v.field(
      "small_share", small_share,
      "[-] share of the beams through the disc of radius_m that return from objects too small for a UAV, such as birds",
      Range{0.0, 1.0, true});
  v.check(small_share < least_share, "small_share", "less than least_share");
  v.field("max_size_m", max_size_m, "[m] largest diagonal of the box around the returns of a target in one sweep",
          Range{0.0, 100.0, true});
  v.field("body_m", body_m,
          "[m] distance between two targets below which they are merged into one body if beams return from between "
          "them; 0: never",
          Range::between(0.0, 20.0));
  v.field("sigma_velocity_mps", sigma_velocity_mps,
          "[m/s] standard deviation of the velocity of a new hypothesis, per axis", Range::positive());
}

void ExpectedNoise::visit(ConfigVisitor& v) {
  v.field("sigma_range_m", sigma_range_m, "[m] standard deviation of the range", Range::positive());
  v.field("sigma_position_m", sigma_position_m, "[m] standard deviation of the sensor's position, per axis",
          Range::non_negative());
  v.field("sigma_attitude_rad", sigma_attitude_rad, "[rad] standard deviation of the sensor's attitude, per axis",
          Range::non_negative());
}

void TrackBeforeDetectConfig::visit(ConfigVisitor& v) {
  v.field("sensor", sensor, "name of the LiDAR; empty: all");
  v.object("field_of_view", field_of_view,
           "field of view of a LiDAR whose driver reports no directions of shots without return");
  v.object("air", air, "map of free air and background");
  v.object("target", target, "expected targets");
  v.object("noise", noise, "Sigma_w: noise of range and pose");
  v.field("reported_existence", reported_existence,
          "[-] existence probability from which a hypothesis is reported as a detection", Range::probability());
  v.field("free_air_share", free_air_share,
          "[-] clutter share: share of the beams through a voxel of free air that return from insects, rain or false "
          "alarms",
          Range{0.0, 1.0, true});
  v.field("cluster_distance_m", cluster_distance_m, "[m] largest distance between neighboring returns of one target",
          Range{0.0, 100.0, true});
  v.field("max_hypotheses", max_hypotheses, "[-] largest number of hypotheses; the most likely ones are kept",
          Range::between(1.0, 4096.0));
  v.field("latency_s", latency_s,
          "[s] time from a sweep to its detections; of several waiting sweeps only the newest is processed",
          Range::non_negative());
}

}  // namespace swiftlet
