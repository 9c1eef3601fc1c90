// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet {

/// Transmitted part of a submap.
struct CompactCloudConfig {
  /// [-] Bits of each coordinate within its voxel. Larger values place points more precisely and take more of the data
  /// rate.
  static constexpr int kBits = 5;

  double voxel_m = 0.5;       ///< [m] edge of the cubes that keep one point of upright structure
  double flat_voxel_m = 1.5;  ///< [m] edge of the cubes that keep one point of the ground and all else
  /// [-] approximate limit of points of upright structure; whole columns beyond it are left out
  int upright_points = 1200;
  int chunk_bytes = 1000;  ///< [B] largest size of the cloud in one message
};

/// Acceptance of closures between two vehicles.
struct MapJoinConfig {
  int closures_min = 2;
  /// [-] largest chi-square of the loop through two closures, with 6 degrees of freedom, for them to be consistent
  double chi2_max = 16.81;
  double closure_position_m = 0.03;   ///< [m] standard deviation of the position of a closure between vehicles
  double closure_attitude_deg = 0.1;  ///< [deg] standard deviation of the attitude of a closure between vehicles
  /// [m/sqrt(m)] position noise of either vehicle's odometry per root of the flown distance
  double odometry_position_m_sqrt_m = 0.02;
  /// [deg/sqrt(m)] attitude noise of either vehicle's odometry per root of the flown distance
  double odometry_attitude_deg_sqrt_m = 0.05;
  double closure_huber = 3.0;  ///< [-] Huber threshold of closures, in standard deviations; larger residuals count less
  double gravity_sigma_deg = 0.2;  ///< [deg] standard deviation of a submap's tilt

  void visit(ConfigVisitor& v);
};

/// Exchange of submaps by radio, to estimate the relative pose of the vehicles' local frames.
struct MapSharingConfig {
  bool enabled = false;
  double latency_s = 0.5;
  double budget_kbps = 100.0;
  /// [s] interval of repeated reports of submap poses and closures, in case a message was lost
  double report_interval_s = 5.0;
  double retry_after_s = 3.0;  ///< [s] time without a reply after which missing data is requested again
  double likeness_min = 0.5;   ///< [-] least similarity of the descriptors of two submaps that are compared
  int search_submaps = 8;      ///< [-] largest number of own submaps searched at once for another vehicle's submap
  int closures_enough = 8;     ///< [-] consistent closures with one vehicle after which no more clouds are requested
  CompactCloudConfig cloud;
  MapJoinConfig join;

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet
