// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "core/guidance/flocking/rbl_cell.hpp"
#include "core/guidance/half_space.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Point of a voxel that is nearest to `p_m` (3.1). Any frame, the same for all arguments.
inline Vector3 nearest_in_voxel(const Vector3& p_m, const Vector3& center_m, double edge_m) {
  const auto along = [half_m = 0.5 * edge_m](double p, double center) {
    return std::min(std::max(p, center - half_m), center + half_m);
  };
  return {along(p_m.x(), center_m.x()), along(p_m.y(), center_m.y()), along(p_m.z(), center_m.z())};
}

/// Cuts cells by occupied voxels with half-spaces, so that a cell stays convex, and keeps the agent's encumbrance away
/// from every voxel that faces it [Kamler 2025, sec. 3.1.3]. The first plane touches the nearest point of the nearest
/// voxel. Each further one touches the nearest voxel not yet outside of the cut cell.
class ObstacleCutter {
 public:
  /// @param p_local_m  position of the agent, the origin of the cell
  /// @param cuts  the planes are appended to it
  void cut(RblCell& cell, const Vector3& p_local_m, std::span<const Vector3> voxels_local_m, double edge_m,
           double encumbrance_m, double eta, std::vector<HalfSpace>& cuts);

 private:
  struct Candidate {
    Eigen::Vector3f nearest_agent_m;  // nearest point of the voxel
    Eigen::Vector3f center_agent_m;
    float distance_sq;
  };

  std::vector<Candidate> remaining_;
};

/// Field of view of the tilted sensor (3.2-3.4) as two half-spaces relative to the vehicle: the region ahead between
/// two planes, from fov_lower_deg below the sensor's horizontal plane.
/// @param p_lidar_body_m  point that both planes contain
std::array<HalfSpace, 2> field_of_view(const Matrix3& R_local_body, double fov_lower_deg, double fov_deg,
                                       const Vector3& p_lidar_body_m = Vector3::Zero());

}  // namespace swiftlet
