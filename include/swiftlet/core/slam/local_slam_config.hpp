// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/localization/imu_noise.hpp"

namespace swiftlet {

/// Noise of the IMU, and uncertainty at the start.
///
/// The densities of white noise are ten times those of an ADIS16448: on a vehicle they also stand for vibration, jitter
/// of the stamps and errors of scale and alignment.
struct InertialConfig : ImuNoise {
  double start_velocity_sigma_mps = 0.1;
  double start_tilt_sigma_deg = 0.5;
  double time_offset_s = 0.0;
  double time_offset_sigma_s = 0.02;

  InertialConfig() {
    gyro_noise_radps_sqrt_hz = 3.39e-3;
    accel_noise_mps2_sqrt_hz = 4e-2;
  }

  void visit(ConfigVisitor& v);
};

struct SurfaceMapConfig {
  double cell_m = 2.0;
  int levels = 4;          ///< [-] number of cell sizes, each half of the next larger one; more resolve smaller planes
  double fineness = 0.01;  ///< [-] smallest edge of a cell, as a share of the range of its points
  int points_per_cell = 300;    ///< [-] largest number of points of a cell; further ones are ignored
  double plane_sigma_m = 0.06;  ///< [m] largest scatter of the points about a plane
  bool two_faced = true;        ///< a plane holds only points seen from its side; needs the origins of the rays
  double keep_radius_m = 150.0;

  void visit(ConfigVisitor& v);
};

struct ScanToMapConfig {
  /// [-] residual in standard deviations beyond which points lie on no surface and hardly count; larger values let
  /// wrong pairs attract
  double kernel_sigma = 3.0;
  double surface_sigma_m = 0.005;  ///< [m] roughness assumed for the smoothest surface
  double point_weight = 0.02;      ///< [-] weight of points where the map has no plane; 0: they are left out
  double degenerate_share = 0.003;
  int standing_points = 10;
  /// [points] Size of a plane from which it may constrain a scan with an open direction. The curve that one beam draws
  /// across an edge looks like a small plane; larger values leave more directions open.
  float firm_points = 10.0F;
  double floor_position_m = 0.0005;   ///< [m] standard deviation of the position error common to all points of a scan
  double floor_attitude_deg = 0.002;  ///< [deg] standard deviation of the attitude error common to all points of a scan

  void visit(ConfigVisitor& v);
};

struct SurfaceMatchingConfig {
  int map_points = 20000;         ///< [-] largest number of points of a scan that go into the map
  int match_points = 4000;        ///< [-] largest number of points of a scan that are matched
  double insert_after_m = 0.3;    ///< [m] motion after which a scan goes into the map
  double insert_after_deg = 8.0;  ///< [deg] rotation after which a scan goes into the map
  double insert_after_s = 1.0;    ///< [s] time after which a scan goes into the map without motion
  ScanToMapConfig matching;
  SurfaceMapConfig map;
};

struct LocalSlamConfig : SurfaceMatchingConfig {
  InertialConfig imu;
  double range_max_m = 100.0;
  int start_scans = 20;
  double known_share_min = 0.3;
  double vehicle_radius_m = 1.0;
  bool with_imu = true;  ///< set by SlamConfig::imu

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet
