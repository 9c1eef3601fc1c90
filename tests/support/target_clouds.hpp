// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/background_query.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet::testing {

/// Builds a cloud point by point, each with its firing time after the start of the sweep.
class CloudMaker {
 public:
  explicit CloudMaker(TimeNs stamp, TimeNs duration = 0) : stamp_(stamp), duration_(duration) {}

  CloudMaker& add(const Vector3& p_m, double offset_s = 0.0, double reflectivity = 0.0) {
    points_.push_back(p_m.cast<float>());
    reflectivity_.push_back(static_cast<float>(reflectivity));
    offsets_s_.push_back(static_cast<float>(offset_s));
    return *this;
  }
  /// Points on the half of a sphere that faces the sensor in the origin, noise-free: their mean is nearer than the
  /// center.
  CloudMaker& add_target(const Vector3& center_m, double radius_m = 0.3, int num_points = 40, double offset_s = 0.0) {
    const Vector3 to_sensor = center_m.norm() > 0.0 ? Vector3(-center_m.normalized()) : Vector3::UnitX();
    for (int i = 0, added = 0; added < num_points; ++i) {
      // Evenly spaced directions (Fibonacci lattice).
      const double z = 1.0 - 2.0 * std::fmod((i + 0.5) / (2.0 * num_points), 1.0);
      const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0)), r = std::sqrt(std::max(0.0, 1.0 - z * z));
      const Vector3 n(r * std::cos(angle), r * std::sin(angle), z);
      if (n.dot(to_sensor) < 0.0 && i < 4 * num_points) continue;
      add(center_m + radius_m * n, offset_s);
      ++added;
    }
    return *this;
  }
  LocalCloud make() const {
    auto beams = std::make_shared<BeamTable>();
    auto scan = std::make_shared<Scan>();
    beams->rows = 1;
    beams->cols = static_cast<int>(points_.size());
    beams->column_offset_s = offsets_s_;
    scan->stamp = stamp_;
    scan->duration = duration_;
    scan->beams = beams;
    scan->reflectivity = reflectivity_;
    LocalCloud cloud;
    cloud.scan = scan;
    cloud.T_local_lidar = {Pose::Identity()};
    cloud.points_local_m = points_;
    for (std::uint32_t i = 0; i < points_.size(); ++i) cloud.beam.push_back(i);
    return cloud;
  }

 private:
  TimeNs stamp_, duration_;
  std::vector<Eigen::Vector3f> points_;
  std::vector<float> offsets_s_, reflectivity_;
};

inline Detection detection_at(const Vector3& p_m, TimeNs t) {
  Detection detection;
  detection.t = t;
  detection.position_m = p_m;
  detection.num_points = 10;
  return detection;
}

/// Occupied voxels as a list of their centers.
struct ListedBackground : BackgroundQuery {
  std::vector<Vector3> centers_m;
  bool occupied_within(const Vector3& p_world_m, double radius_m) const override {
    for (const Vector3& c : centers_m) {
      if ((c - p_world_m).norm() <= radius_m) return true;
    }
    return false;
  }
};

}  // namespace swiftlet::testing
