// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/vofod_config.hpp"

#include <cmath>

#include "core/detection/separate_removal.hpp"
#include "swiftlet/core/detection/clusterer.hpp"

namespace swiftlet {
namespace {

// [-] Largest number of voxels of the window, which are numbered in 32 bits; larger windows are refused.
constexpr double kMaxWindowCells = 2e9;
// [m] Largest motion of the sensor during a sweep, by which the window exceeds the rays. Larger values require memory.
constexpr double kWindowMargin_m = 10.0;
/// [voxels] Largest distance of a search, which bounds its time; larger distances are refused.
constexpr double kMaxReach_voxels = 50.0;

}  // namespace

void VofodChoices::visit(ConfigVisitor& v) {
  v.choice("clustering", clustering, {"points", "voxels"},
           "distances between points (paper) or between centers of voxels that hold points (released code)");
  v.choice("position", position, {"centroid", "box_center"},
           "position of a detection: mean of its points (paper, eq. 19) or center of its oriented box (released code)");
  v.choice("search", search, {"sphere", "octahedron"},
           "rule B: border at search_distance_m from the start (paper), or at a number of steps that the object's size "
           "adds to (released code)");
  v.choice("map_update", map_update, {"after", "before"},
           "points go into the map after the classification, detections as exactly unknown (paper), or before it, "
           "detections as other unknown points (released code)");
  v.choice("separate_becomes", separate_becomes, {"unknown", "free"},
           "separate background moves to g_unknown (overview of sec. III) or to g_free (eq. 9)");
}

void VofodTiming::visit(ConfigVisitor& v) {
  v.field("classification_latency_s", classification_latency_s,
          "[s] time from a scan to its detections; of the scans that arrive meanwhile only the newest is processed",
          Range::non_negative());
  v.field("raycasting_latency_s", raycasting_latency_s,
          "[s] time from the start of a ray casting to its effect on the map", Range::non_negative());
  v.field("separation_latency_s", separation_latency_s, "[s] duration of the removal of separate background",
          Range::non_negative());
  v.field("separation_period_s", separation_period_s, "[s] minimum time between the starts of two removals",
          Range::positive());
}

void VofodConfig::visit(ConfigVisitor& v) {
  v.field("sensor", sensor, "name of the LiDAR; empty: all");
  v.object("map", map, "multi-state occupancy map");
  v.choice("clusterer", clusterer, {"swiftlet", "pcl"},
           "implementation of the clustering, with equal results; pcl: in programs that were built with PCL");
  v.check(has_clusterer(clusterer), "clusterer", "swiftlet: this program was built without PCL");
  v.field("cluster_distance_m", cluster_distance_m,
          "[m] d_cluster: largest distance between neighboring points of a cluster (paper: 0.25)",
          Range{0.0, 100.0, true});
  v.field("close_distance_m", close_distance_m,
          "[m] d_close: distance to background within which a cluster is background (rule A)", Range{0.0, 100.0, true});
  v.field("search_distance_m", search_distance_m,
          "[m] d_search: distance within which free air must enclose a flying cluster (rule B)",
          Range{0.0, 100.0, true});
  v.field("ray_max_m", ray_max_m, "[m] d_max: largest length of a ray", Range{0.0, 1000.0, true});
  v.object("field_of_view", field_of_view,
           "field of view of a LiDAR whose driver reports no directions of shots without return");
  v.field("separate_min_confident", separate_min_confident,
          "[-] n_conf,min: confident voxels from which a cluster of background is kept", Range::non_negative());
  v.field("max_size_m", max_size_m, "[m] largest diagonal of the oriented box of a detection", Range{0.0, 100.0, true});
  v.field("still_s", still_s,
          "[s] time without motion after which a cluster at the lower edge of the field of view is no longer reported, "
          "until "
          "it moves; 0: always reported",
          Range::non_negative());
  v.choice("seed", seed, {"large_and_altimeter", "large", "altimeter", "none"},
           "first background in an unknown world: clusters larger than max_size_m, the ground below the altimeter");
  v.choice("covariance", covariance, {"constant", "pose_noise"},
           "covariance of detections: sigma_m, or in addition the noise of range and pose (sec. IV-A)");
  v.field("sigma_m", sigma_m, "[m] constant part of the standard deviation, per axis", Range::positive());
  v.field("sigma_range_m", sigma_range_m, "[m] pose_noise: standard deviation of the range", Range::non_negative());
  v.field("sigma_position_m", sigma_position_m, "[m] pose_noise: standard deviation of the sensor's position, per axis",
          Range::non_negative());
  v.field("sigma_attitude_rad", sigma_attitude_rad,
          "[rad] pose_noise: standard deviation of the sensor's attitude, per axis", Range::non_negative());
  v.object("choices", choices, "interpretations of ambiguous passages of the paper");
  v.object("prior", prior, "prior knowledge of the world");
  v.object("timing", timing, "durations of the modules");
  const double reach_m = kMaxReach_voxels * map.voxel_m;
  v.check(SeparateRemoval::kDistance_m <= reach_m, "map.voxel_m", "at least 0.014");
  v.check(search_distance_m <= reach_m, "search_distance_m", "at most 50 times map.voxel_m");
  v.check(close_distance_m <= reach_m, "close_distance_m", "at most 50 times map.voxel_m");
  v.check(cluster_distance_m <= reach_m, "cluster_distance_m", "at most 50 times map.voxel_m");
  v.check(ray_window_bytes() <= kMaxWindowCells * sizeof(float), "ray_max_m",
          "so small that at most 2e9 voxels lie near sensor and map");
}

double VofodConfig::map_bytes() const { return (map.size_m / map.voxel_m).prod() * (sizeof(float) + 1.0 / 8.0); }

double VofodConfig::ray_window_bytes() const {
  const double around = (2.0 * ray_max_m + kWindowMargin_m) / map.voxel_m;
  return (map.size_m.array() / map.voxel_m + 2.0 * kRayScroll_voxels).min(around).prod() * sizeof(float);
}

}  // namespace swiftlet
