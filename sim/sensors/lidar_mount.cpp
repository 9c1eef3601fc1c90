// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/lidar_mount.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "sim/sensors/noise.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/sensors/lidar_pattern.hpp"

namespace swiftlet::sim {
namespace {

// [m] Step and greatest height of the search for a mast.
constexpr double kStep_m = 0.005;
constexpr double kHighest_m = 1.0;
// Margin for the width of the beams, and for directions of other sweeps
constexpr double kMargin_rad = 0.5 * kRadPerDeg;
constexpr int kRimPoints = 64;

/// Points whose convex hull contains the vehicle without its sensor housing, with rotors at any angle.
std::vector<Vector3> hull_points(const VehicleShape& shape) {
  std::vector<Vector3> points;
  for (const Mesh& mesh : shape.meshes) {
    if (mesh.part == VehiclePart::kSensor) continue;
    for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) points.push_back(vertex.cast<double>());
  }
  for (const VehicleShape::RotorShape& rotor : shape.rotors) {
    const double around_m = rotor.radius_m / elementary::cos(std::numbers::pi / kRimPoints);
    for (int i = 0; i < kRimPoints; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kRimPoints;
      points.push_back(rotor.hub_body_m.cast<double>() +
                       around_m * Vector3(elementary::cos(angle), elementary::sin(angle), 0.0));
    }
  }
  return points;
}

double lowest_elevation_rad(const Module& pattern) {
  // [s] Duration of a sweep that contains all directions of a pattern.
  constexpr double kSweep_s = 0.1;
  BeamTable beams;
  make_lidar_pattern(pattern, kSweep_s)->fill(0, beams);
  float lowest = 1.0F;
  for (const Eigen::Vector3f& direction : beams.directions_lidar) lowest = std::min(lowest, direction.z());
  return elementary::asin(std::clamp(static_cast<double>(lowest), -1.0, 1.0)) - kMargin_rad;
}

}  // namespace

void MountConfig::visit(ConfigVisitor& v) {
  v.field("position_m", position_m, "[m] position of the sensor in the body frame");
  v.field("rpy_deg", rpy_deg, "[deg] roll, pitch, yaw of the sensor in the body frame: R = Rz(yaw) Ry(pitch) Rx(roll)");
  v.field("clear_of_hull", clear_of_hull,
          "[-] whether the sensor is raised on its airframe until no beam can intersect the own vehicle");
}

Pose MountConfig::T_body_lidar() const { return make_pose(position_m, rotation_of_rpy(rpy_deg * kRadPerDeg)); }

// The region below the lowest beams of a turn is a convex hanging cone, so it contains the hull if it contains these
// points.
Pose MountConfig::place_on(const VehicleShape& shape, const Module& pattern) const {
  Pose T_body_lidar = this->T_body_lidar();
  if (!clear_of_hull) return T_body_lidar;
  const std::vector<Vector3> points = hull_points(shape);
  const double fall = elementary::tan(std::min(lowest_elevation_rad(pattern), 0.0));
  const double lowest_m = position_m.z();
  for (int step = 0; step * kStep_m <= kHighest_m; ++step) {
    T_body_lidar.translation().z() = lowest_m + step * kStep_m;
    const Pose T_lidar_body = T_body_lidar.inverse();
    if (std::ranges::all_of(points, [&](const Vector3& p_body) {
          const Vector3 p_lidar = T_lidar_body * p_body;
          return p_lidar.z() < fall * p_lidar.head<2>().norm();
        })) {
      return T_body_lidar;
    }
  }
  throw std::invalid_argument("mount.clear_of_hull: no mast of up to 1 m takes the beams over the own vehicle");
}

}  // namespace swiftlet::sim
