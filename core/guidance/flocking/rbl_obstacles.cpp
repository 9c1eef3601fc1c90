// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_obstacles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/guidance/flocking/rbl_planner.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [m] Distance to a voxel below which the agent counts as inside. The direction to the nearest point is then
/// undefined, so that to the center of the voxel is used.
constexpr float kInside_m = 0.01F;

Matrix3 turn_y(double angle_rad) { return Eigen::AngleAxisd(angle_rad, Vector3::UnitY()).toRotationMatrix(); }

/// Plane that keeps the agent clear of a voxel. For an agent inside of the voxel, the plane lies behind the agent.
HalfSpace voxel_cut(const Vector3& nearest_agent_m, const Vector3& center_agent_m, double encumbrance_m, double eta) {
  if (nearest_agent_m.norm() > kInside_m) return obstacle_cut(nearest_agent_m, encumbrance_m, eta);
  return {center_agent_m.norm() > kInside_m ? Vector3(center_agent_m.normalized()) : Vector3(Vector3::UnitZ()),
          -encumbrance_m};
}

}  // namespace

void ObstacleCutter::cut(RblCell& cell, const Vector3& p_local_m, std::span<const Vector3> voxels_local_m,
                         double edge_m, double encumbrance_m, double eta, std::vector<HalfSpace>& cuts) {
  remaining_.clear();
  for (const Vector3& voxel_local_m : voxels_local_m) {
    const Vector3 center = voxel_local_m - p_local_m;
    const Eigen::Vector3f nearest = nearest_in_voxel(Vector3::Zero(), center, edge_m).cast<float>();
    remaining_.push_back({nearest, center.cast<float>(), nearest.squaredNorm()});
  }
  while (!remaining_.empty()) {
    const auto first =
        std::min_element(remaining_.begin(), remaining_.end(),
                         [](const Candidate& a, const Candidate& b) { return a.distance_sq < b.distance_sq; });
    const Candidate at = *first;
    const HalfSpace plane =
        voxel_cut(at.nearest_agent_m.cast<double>(), at.center_agent_m.cast<double>(), encumbrance_m, eta);
    cuts.push_back(plane);
    cell.cut(plane);
    // Voxels beyond the plane through the nearest point are at least as far from the cell as that point.
    const Eigen::Vector3f normal = plane.normal_local.cast<float>();
    const float beyond = std::sqrt(at.distance_sq) - static_cast<float>(kPlaneSlack_m);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < remaining_.size(); ++i) {
      if (&remaining_[i] == &*first || normal.dot(remaining_[i].nearest_agent_m) >= beyond) continue;
      remaining_[kept++] = remaining_[i];
    }
    remaining_.resize(kept);
  }
}

std::array<HalfSpace, 2> field_of_view(const Matrix3& R_local_body, double fov_lower_deg, double fov_deg,
                                       const Vector3& p_lidar_body_m) {
  const Vector3 lidar_agent_m = R_local_body * p_lidar_body_m;
  const Vector3 n1 = R_local_body * turn_y(fov_lower_deg * kRadPerDeg) * Vector3::UnitZ();
  const Vector3 n2 = R_local_body * turn_y((fov_lower_deg - fov_deg) * kRadPerDeg) * Vector3::UnitZ();
  return {HalfSpace{-n1, -n1.dot(lidar_agent_m)}, HalfSpace{n2, n2.dot(lidar_agent_m)}};
}

}  // namespace swiftlet
