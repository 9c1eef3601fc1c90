// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/sim/sensors/outage_config.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {

/// Satellite navigation. The error of position is a sum:
/// - white noise;
/// - stationary Gauss-Markov drift;
/// - random walk of the altitude, not contained in the reported sigma (0.8 m between take-off and landing in [Orsulic
/// 2021]);
/// - multipath where the sky is blocked.
///
/// Defaults model the receiver of [Orsulic 2021] (u-blox M8P): the standard deviation of its position at the site,
/// white noise and drift together, was above 1.5 m.
struct GnssConfig : SensorConfigOf<GnssConfig> {
  std::string model;
  double rate_hz = 5.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double sigma_xy_m = 0.3;
  double sigma_z_m = 0.5;
  double drift_sigma_xy_m = 1.5;
  double drift_sigma_z_m = 2.0;
  double drift_time_s = 60.0;
  double altitude_walk_m_psqrts = 0.05;
  double sigma_velocity_xy_mps = 0.1;
  double sigma_velocity_z_mps = 0.2;
  std::vector<OutageConfig> outages;
  double random_outages_per_min = 0.0;
  double random_outage_mean_s = 5.0;
  bool sky_view = false;
  int num_satellites = 12;
  double elevation_mask_deg = 10.0;
  double multipath_sigma_m = 5.0;

  void visit(ConfigVisitor& v) override;
};

/// With `sky_view` a ray is traced to each of the satellites: a fixed constellation, spread evenly over the sky,
/// rotated by a random azimuth. Blocked satellites are lost. Noise and drift grow with sqrt(satellites / visible),
/// multipath with the blocked share. With fewer than four visible satellites there is no fix. The sample's sigmas are
/// the standard deviations of the whole error except the altitude's random walk, which a receiver cannot estimate.
std::unique_ptr<Sensor> make_gnss_sensor(const ModuleConfig& config, SensorSetup setup);

}  // namespace swiftlet::sim
