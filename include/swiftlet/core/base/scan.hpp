// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Geometry and timing of the beams of one sweep. Row-major (rows x cols). For a spinning sensor, row 0 is the top beam
/// and a column is one firing. For a sensor without rows, `rows` is the number of beams fired at once. Constant for a
/// spinning sensor, hence shared between its scans.
struct BeamTable {
  int rows = 0;
  int cols = 0;
  /// Unit vectors; zero for a beam without return whose direction the driver does not report     (rows x cols)
  std::vector<Eigen::Vector3f> directions_lidar;
  std::vector<Eigen::Vector3f> origins_lidar;  ///< points from which ranges are measured [m]             (rows x cols)
  std::vector<float> column_offset_s;          ///< firing time after the start of the sweep      (cols)
  std::vector<float> row_offset_s;  ///< firing time after that of the column    (rows, or empty: all at once)
  std::vector<std::uint8_t>
      masked;  ///< 1: the beam hits the vehicle itself and is ignored [Vrba 2025, sec. III-C] (rows x cols or empty)

  int size() const { return rows * cols; }
  /// Firing time of beam i after the start of the sweep [s].
  double offset_s(int i) const {
    return column_offset_s[i % cols] + (row_offset_s.empty() ? 0.0 : row_offset_s[i / cols]);
  }
};

/// One sweep of one LiDAR, as its driver publishes it. A range of 0 means no return.
struct Scan {
  std::string sensor;                    ///< name of the sensor on its vehicle
  TimeNs stamp = 0;                      ///< start of the sweep
  TimeNs duration = 0;                   ///< length of the sweep; 0 for a frozen scan
  Pose T_body_lidar = Pose::Identity();  ///< calibrated mounting pose
  double range_max_m = 0.0;              ///< largest range that the sensor returns
  double sigma_range_m = 0.0;            ///< standard deviation of the range noise, as known to the agent
  std::shared_ptr<const BeamTable> beams;
  std::vector<float> range_m;    ///< along the beam from its origin; 0: no return      (rows x cols)
  std::vector<float> intensity;  ///< received power, 1 = white Lambertian wall at 10 m, normal incidence (rows x cols)
  std::vector<float> reflectivity;  ///< range-corrected intensity, 1 = white Lambertian (rows x cols)
  /// Poses of the body from an external localization with the noise of Sigma_w [Vrba 2025, eq. 66]. One for a frozen
  /// scan, several over the sweep otherwise, and none when the vehicle localizes itself.
  std::vector<StampedPose> external_poses;

  /// Visits everything that differs between scans; `beams` is a property of the sensor.
  static void visit(auto& s, auto& v) {
    v.field("sensor", s.sensor, "[-] name of the sensor on its vehicle");
    v.time("t_s", s.stamp, "[s] start of the sweep");
    v.time("duration_s", s.duration, "[s] length of the sweep; 0 for a frozen scan");
    v.field("mount_*", s.T_body_lidar, "[m, -] mounting pose, as calibrated");
    v.field("range_max_m", s.range_max_m, "[m] largest range of the sensor");
    v.field("sigma_range_m", s.sigma_range_m, "[m] standard deviation of the range noise");
    v.field("range_m", s.range_m, "[m] along each beam; 0: no return");
    v.field("intensity", s.intensity, "[-] received power of each beam");
    v.field("reflectivity", s.reflectivity, "[-] range-corrected intensity of each beam");
    v.list("external_poses", s.external_poses,
           "[m, -] poses of the body during the sweep from an external localization");
  }

  int rows() const { return beams->rows; }
  int cols() const { return beams->cols; }
  int size() const { return beams->size(); }
  bool hit(int i) const { return range_m[i] > 0.0F; }
  /// Range as reported by the driver of a spinning sensor: from the axis, including the offset to the beam's origin.
  float range_from_axis_m(int i) const { return range_m[i] + beams->origins_lidar[i].head<2>().norm(); }
  Eigen::Vector3f point_lidar(int i) const { return beams->origins_lidar[i] + range_m[i] * beams->directions_lidar[i]; }
  TimeNs time_of(int i) const { return duration == 0 ? stamp : stamp + from_seconds(beams->offset_s(i)); }
};

}  // namespace swiftlet
