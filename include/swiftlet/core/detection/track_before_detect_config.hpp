// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <Eigen/Core>
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/detection/field_of_view.hpp"

namespace swiftlet {

/// Map of the numbers of beams that pass each voxel and that end in it.
struct AirMapConfig {
  double voxel_m = 0.5;  ///< [m] edge of a voxel
  Eigen::Vector3d size_m = {128.0, 128.0, 64.0};
  int memory_beams = 64;  ///< [-] largest number of beams that a voxel counts; older ones fade
  /// [-] prior count of beams that end in an unknown voxel; larger values learn the voxel later
  double prior_hits = 0.02;
  double prior_passes = 0.08;  ///< [-] prior count of beams that pass an unknown voxel

  void visit(ConfigVisitor& v);
  double bytes() const;
};

/// Model of a target and of not yet detected targets.
struct ExpectedTarget {
  double radius_m = 0.325;
  double return_share = 0.25;     ///< [-] mean share of the beams through the disc of radius_m that return
  double return_variation = 1.0;  ///< [-] shape of the gamma distribution of return_share over sweeps; 1: exponential
  double least_share = 0.065;
  double small_share = 0.02;
  double small_prior = 0.05;  ///< [-] prior share of flying objects too small for a UAV; 0: no distinction
  /// [m] largest range at which small objects are distinguished; farther targets return less because of their range
  double small_within_m = 25.0;
  double max_size_m = 4.0;
  double body_m = 2.0;
  double seen_side_m = 0.05;  ///< [m] distance from the mean of the returns to the center of a target, along the beam
  double sigma_velocity_mps = 4.0;
  double acceleration_density = 1.5;  ///< [m^2/s^3] spectral density of a target's white acceleration, per axis
  double birth_per_m3 = 2e-4;         ///< [1/m^3] density of unknown targets
  double lifetime_s = 60.0;           ///< [s] mean lifetime of a target
  double seen_for_s = 5.0;            ///< [s] mean time until an obstruction that the beams do not show hides a target

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
  FieldOfView field_of_view;
  AirMapConfig air;
  ExpectedTarget target;
  ExpectedNoise noise;
  double reported_existence = 0.5;
  double background_share = 0.02;  ///< [-] share of beams that end in the background above which a return is no target
  /// [-] largest share of beams that end in the voxels around a new hypothesis; the prior of `air` determines how many
  /// must have passed
  double free_share = 0.001;
  /// [-] largest share of beams that end in any voxel within 1 m of a new hypothesis
  double hit_share = 0.01;
  double free_air_share = 1e-6;
  double learning_delay_s = 1.0;  ///< [s] delay until returns that are no target become background
  double cluster_distance_m = 0.7;
  /// [m] standard deviation of the position, on any axis, above which a hypothesis is dropped
  double sigma_lost_m = 1.3;
  int rays_per_sweep = 10000;  ///< [-] largest number of beams of a sweep that clear air; the next sweep uses others
  int max_hypotheses = 128;    ///< [-] largest number of hypotheses; the most likely ones are kept
  double latency_s = 0.08;

  void visit(ConfigVisitor& v) override;
};

}  // namespace swiftlet
