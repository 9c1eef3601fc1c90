// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"

namespace swiftlet {

/// Covariance of the positions that correct tracks.
struct TrackMeasurementConfig {
  enum class Noise { kConstant, kSigmaW };
  Noise noise = Noise::kConstant;
  double sigma_m = 0.3;            ///< [m] square root of Z, with constant noise
  MeasurementNoise sensor;         ///< Sigma_w, with sensor noise
  double sigma_sampling_m = 0.15;  ///< additional standard deviation, because only one side of the target is visible

  void visit(ConfigVisitor& v);
};

/// Algorithm 2 of Vrba 2025. The defaults are those of Table II; docs/tracking.md describes where the paper and its
/// released code differ and which is the default here.
struct CloudTrackerConfig {
  int buffer_size = 10;  ///< [-] N_buf: buffered clouds
  enum class RadiusLaw { kPrinted, kSphere };
  RadiusLaw radius_law = RadiusLaw::kPrinted;
  double radius_max_m = 5.0;           ///< [m] r_max: r_unc above which a track is lost
  double cluster_distance_m = 0.7;     ///< [m] d_cluster, equal to that of the detector
  double background_distance_m = 1.0;  ///< [m] d_min: distance to background below which a cluster is background
  enum class Background { kMap, kCloud, kNone };
  Background background = Background::kMap;
  double max_size_m = 3.0;
  enum class Position { kCentroid, kBoxCenter };
  Position position = Position::kCentroid;
  enum class Assignment { kExclusive, kNearest };
  Assignment assignment = Assignment::kExclusive;
  double association_radius_min_m = 0.5;
  double merge_radius_max_m = 0.5;
  int min_detections = 2;
  TrackMeasurementConfig measurement;

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet
