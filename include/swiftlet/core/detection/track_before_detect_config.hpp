// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/detection/air_map.hpp"

namespace swiftlet {

/// Model of a target and of not yet detected targets.
struct ExpectedTarget {
  double radius_m = 0.325;
  double return_share = 0.25;
  double return_variation = 1.0;
  double least_share = 0.065;
  double small_share = 0.02;
  double small_prior = 0.05;
  double small_within_m = 25.0;
  double max_size_m = 4.0;
  double body_m = 2.0;
  double seen_side_m = 0.05;
  double sigma_sampling_m = 0.15;
  double sigma_velocity_mps = 4.0;
  double acceleration_density = 1.5;
  double birth_per_m3 = 2e-4;
  double strangers_per_m3 = 2e-6;
  double lifetime_s = 60.0;
  double seen_for_s = 5.0;
  double hidden_for_s = 2.0;

  void visit(ConfigVisitor& v);
};

/// Sigma_w of the pose by which beams are registered, and noise of their ranges [Vrba 2025, eq. 66].
struct ExpectedNoise {
  double sigma_range_m = 0.03;
  double sigma_position_m = 0.05;
  double sigma_attitude_rad = 0.005;

  void visit(ConfigVisitor& v);
};

/// Fuses sweeps before it decides whether an object flies; docs/detection.md.
struct TrackBeforeDetectConfig : ModuleConfigOf<TrackBeforeDetectConfig> {
  std::string sensor;
  AirMapConfig air;
  ExpectedTarget target;
  ExpectedNoise noise;
  double told_existence = 0.5;
  double background_share = 0.02;
  double free_share = 0.001;
  double hit_share = 0.01;
  double free_reach_m = 1.0;
  double free_air_share = 1e-6;
  double learning_delay_s = 1.0;
  double cluster_distance_m = 0.7;
  double sigma_lost_m = 1.3;
  double sigma_hidden_m = 20.0;
  double max_range_m = 60.0;
  double ray_max_m = 60.0;
  double empty_ray_m = 40.0;
  int rays_per_sweep = 10000;
  int max_hypotheses = 128;
  double latency_s = 0.08;

  void visit(ConfigVisitor& v) override;
};

}  // namespace swiftlet
