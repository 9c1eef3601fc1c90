// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/prior_map.hpp"
#include "swiftlet/core/detection/field_of_view.hpp"
#include "swiftlet/core/map/voxel_map.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"

namespace swiftlet {

/// Margin of raycasting beyond a scrolling map, which may have moved when the rays are applied.
inline constexpr int kRayScroll_voxels = 32;

/// Interpretations of the method where the paper is ambiguous or differs from the authors' released code.
/// docs/detection.md gives the figures behind the defaults.
struct VofodChoices {
  enum class Clustering { kPoints, kVoxels } clustering = Clustering::kPoints;
  enum class Position { kCentroid, kBoxCenter } position = Position::kCentroid;
  enum class Search { kSphere, kOctahedron } search = Search::kSphere;
  enum class MapUpdate { kAfter, kBefore } map_update = MapUpdate::kAfter;
  enum class SeparateBecomes { kUnknown, kFree } separate_becomes = SeparateBecomes::kUnknown;

  void visit(ConfigVisitor& v);
};

/// Sources of the first background in an unknown world.
enum class VofodSeed { kLargeAndAltimeter, kLarge, kAltimeter, kNone };
enum class DetectionCovariance { kConstant, kPoseNoise };

/// Timing of the three concurrent modules; the defaults are the means of Table VI.
struct VofodTiming {
  double classification_latency_s = 0.1123;
  double raycasting_latency_s = 0.3195;
  double separation_latency_s = 0.1596;
  double separation_period_s = 0.1;

  void visit(ConfigVisitor& v);
};

/// The flying-object detector of Vrba 2025; distances and weights of Table II, but for d_cluster (docs/detection.md).
struct VofodConfig : ModuleConfigOf<VofodConfig> {
  std::string sensor;
  VoxelMapConfig map;
  std::string clusterer = "swiftlet";
  double cluster_distance_m = 0.7;
  double close_distance_m = 0.7;
  double search_distance_m = 3.0;
  double ray_max_m = 20.0;
  /// [-] w_int: updates by a ray along the diagonal of a voxel; larger values free air sooner, and thin background too
  double ray_weight = 0.003;
  FieldOfView field_of_view;
  int separate_min_confident = 24;
  double max_size_m = 3.0;
  double still_s = 0.2;
  VofodSeed seed = VofodSeed::kLargeAndAltimeter;
  DetectionCovariance covariance = DetectionCovariance::kConstant;
  double sigma_m = 0.3;
  double sigma_range_m = 0.03;
  double sigma_position_m = 0.05;
  double sigma_attitude_rad = 0.005;
  VofodChoices choices;
  VofodTiming timing;
  PriorConfig prior;

  void visit(ConfigVisitor& v) override;
  double map_bytes() const;         ///< memory of the map's voxels
  double ray_window_bytes() const;  ///< memory of the raycasting window: around the sensor, at most about the map
};

}  // namespace swiftlet
