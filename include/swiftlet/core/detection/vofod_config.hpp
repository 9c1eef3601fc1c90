// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/map/voxel_map.hpp"
#include "swiftlet/core/prior_map.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"

namespace swiftlet {

/// How the parts of the method that the paper leaves open, or that the authors' released code does otherwise, are read
/// (docs/detection.md has the numbers behind the defaults).
struct VofodChoices {
  std::string clustering = "points";
  std::string position = "centroid";
  std::string close_to = "tentative";
  std::string search = "sphere";
  std::string failed_search = "keep";
  std::string sufficiency = "none";
  double sufficient_ratio = 0.15;
  std::string map_update = "after";
  std::string ray_end = "point";
  std::string hit_voxels = "update";
  std::string separate_becomes = "unknown";
  std::string separate_reach = "cluster";

  void visit(ConfigVisitor& v);
};

/// The three modules run beside each other, each at its own rate; the defaults are the means of Table VI.
struct VofodTiming {
  double classification_latency_s = 0.1123;
  double raycasting_latency_s = 0.3195;
  double separation_latency_s = 0.1596;
  double separation_period_s = 0.1;

  void visit(ConfigVisitor& v);
};

/// The flying-object detector of Vrba 2025; distances and weights of Table II.
struct VofodConfig : ModuleConfigOf<VofodConfig> {
  std::string sensor;
  VoxelMapConfig map;
  std::string clusterer = "swiftlet";
  double cluster_distance_m = 0.25;
  double close_distance_m = 0.7;
  double search_distance_m = 3.0;
  double ray_max_m = 20.0;
  double ray_weight = 0.003;
  bool empty_returns = true;
  double separate_distance_m = 0.7;
  int separate_min_confident = 24;
  int min_points = 2;
  double max_size_m = 3.0;
  double max_range_m = 0.0;
  std::string seed = "large_and_altimeter";
  std::string covariance = "constant";
  double sigma_m = 0.3;
  double sigma_range_m = 0.03;
  double sigma_position_m = 0.05;
  double sigma_attitude_rad = 0.005;
  VofodChoices choices;
  VofodTiming timing;
  PriorConfig prior;

  void visit(ConfigVisitor& v) override;
  double map_bytes() const;         ///< of the map's voxels
  double ray_window_bytes() const;  ///< of the voxels around the sensor in which rays are followed
};

}  // namespace swiftlet
