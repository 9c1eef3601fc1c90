// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <vector>

#include "swiftlet/core/base/prior_map.hpp"
#include "swiftlet/core/base/scan.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"

namespace swiftlet::testing {

inline Pose pose_at(const Vector3& p_m, double yaw_rad = 0.0) {
  return make_pose(p_m, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ())));
}

/// A spinning LiDAR: rows x cols beams between two elevations.
inline std::shared_ptr<const BeamTable> make_beams(int rows, int cols, double top_deg = 45.0,
                                                   double bottom_deg = -45.0) {
  auto beams = std::make_shared<BeamTable>();
  beams->rows = rows;
  beams->cols = cols;
  for (int r = 0; r < rows; ++r) {
    const double elevation = (top_deg + (bottom_deg - top_deg) * (r + 0.5) / rows) * std::numbers::pi / 180.0;
    for (int c = 0; c < cols; ++c) {
      const double azimuth = -2.0 * std::numbers::pi * (c + 0.5) / cols;
      beams->directions_lidar.emplace_back(std::cos(elevation) * std::cos(azimuth),
                                           std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      beams->origins_lidar.emplace_back(Eigen::Vector3f::Zero());
    }
  }
  for (int c = 0; c < cols; ++c)
    beams->column_offset_s.push_back(0.1F * static_cast<float>(c) / static_cast<float>(cols));
  return beams;
}

/// Distance along a ray to the nearest surface, 0 for none.
using World = std::function<double(const Vector3& origin_m, const Vector3& direction)>;

inline World sphere(const Vector3& center_m, double radius_m) {
  return [=](const Vector3& o, const Vector3& d) {
    const Vector3 r = o - center_m;
    const double b = r.dot(d), c = r.squaredNorm() - radius_m * radius_m;
    if (b * b - c < 0.0) return 0.0;
    const double t = -b - std::sqrt(b * b - c);
    return t > 0.0 ? t : 0.0;
  };
}

/// A round bar between two points.
inline World bar(const Vector3& from_m, const Vector3& to_m, double radius_m) {
  return [=](const Vector3& o, const Vector3& d) {
    const Vector3 axis = (to_m - from_m).normalized(), r = o - from_m;
    const Vector3 d_across = d - d.dot(axis) * axis, r_across = r - r.dot(axis) * axis;
    const double a = d_across.squaredNorm(), b = d_across.dot(r_across),
                 c = r_across.squaredNorm() - radius_m * radius_m;
    if (a == 0.0 || b * b - a * c < 0.0) return 0.0;
    const double t = (-b - std::sqrt(b * b - a * c)) / a;
    const double along_m = (r + t * d).dot(axis);
    return t > 0.0 && along_m >= 0.0 && along_m <= (to_m - from_m).norm() ? t : 0.0;
  };
}

inline World ground(double height_m = 0.0) {
  return [=](const Vector3& o, const Vector3& d) {
    const double t = d.z() < 0.0 ? (height_m - o.z()) / d.z() : 0.0;
    return t > 0.0 ? t : 0.0;
  };
}

inline World all_of(std::vector<World> worlds) {
  return [worlds = std::move(worlds)](const Vector3& o, const Vector3& d) {
    double nearest = 0.0;
    for (const World& world : worlds) {
      const double t = world(o, d);
      if (t > 0.0 && (nearest == 0.0 || t < nearest)) nearest = t;
    }
    return nearest;
  };
}

/// A frozen scan of a world.
inline std::shared_ptr<const Scan> scan_world(const World& world, const Pose& T_local_lidar,
                                              const std::shared_ptr<const BeamTable>& beams, TimeNs stamp,
                                              double range_max_m = 60.0) {
  auto scan = std::make_shared<Scan>();
  scan->sensor = "lidar";
  scan->stamp = stamp;
  scan->beams = beams;
  scan->range_max_m = range_max_m;
  for (const Eigen::Vector3f& d : beams->directions_lidar) {
    const double t = world(T_local_lidar.translation(), T_local_lidar.linear() * d.cast<double>());
    scan->range_m.push_back(t < range_max_m ? static_cast<float>(t) : 0.0F);
  }
  scan->external_poses = {{stamp, T_local_lidar}};
  return scan;
}

/// A copy without the directions of beams that have no return.
inline std::shared_ptr<const Scan> points_alone(const Scan& full) {
  auto scan = std::make_shared<Scan>(full);
  auto beams = std::make_shared<BeamTable>(*full.beams);
  for (int i = 0; i < full.size(); ++i) {
    if (!full.hit(i)) beams->directions_lidar[i].setZero();
  }
  scan->beams = beams;
  return scan;
}

inline std::shared_ptr<const LocalCloud> cloud_of(const std::shared_ptr<const Scan>& scan) {
  auto cloud = std::make_shared<LocalCloud>();
  CloudRegistrar(0.0).make(scan, *cloud);
  return cloud;
}

/// Points measured from a position, without rays.
inline LocalCloud cloud_from(const Vector3& sensor_m, const std::vector<Eigen::Vector3f>& points_m) {
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 1;
  beams->cols = std::max(static_cast<int>(points_m.size()), 1);
  beams->column_offset_s.assign(beams->cols, 0.0F);
  beams->directions_lidar.assign(beams->size(), Eigen::Vector3f::UnitX());
  beams->origins_lidar.assign(beams->size(), Eigen::Vector3f::Zero());
  auto scan = std::make_shared<Scan>();
  scan->beams = beams;
  scan->range_m.assign(beams->size(), 3.0F);
  LocalCloud cloud;
  cloud.scan = scan;
  cloud.T_local_lidar.assign(beams->cols, pose_at(sensor_m));
  cloud.points_local_m = points_m;
  for (std::uint32_t i = 0; i < points_m.size(); ++i) cloud.beam.push_back(i);
  return cloud;
}

/// The ground at height 0 as a map that is known beforehand.
inline PriorMap known_ground(float half_m = 15.0F) {
  PriorMap prior;
  for (float x = -half_m; x < half_m; x += 0.2F) {
    for (float y = -half_m; y < half_m; y += 0.2F) prior.occupied_world_m.emplace_back(x, y, -0.01F);
  }
  return prior;
}

}  // namespace swiftlet::testing
