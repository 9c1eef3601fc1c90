// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "core/guidance/separation/neighbor_memory.hpp"

namespace swiftlet {

/// Motion of a neighbor relative to the vehicle.
struct Encounter {
  /// Lowest closing speed of a neighbor that is evaded or kept in view. Lower values react to braking neighbors.
  static constexpr double kClosing_mps = 0.5;

  const Neighbor& neighbor;
  Vector3 p_local_m, v_local_mps;  ///< neighbor; horizontal for a planar vehicle
  Vector3 to_local_m;              ///< from the vehicle to the neighbor
  double distance_m = to_local_m.norm();
  /// Speed of the neighbor towards the vehicle.
  double closing_mps = distance_m > 0.0 ? std::max(0.0, -v_local_mps.dot(to_local_m) / distance_m) : 0.0;

  /// Standard deviation along the line of both.
  double sigma(const Matrix3& covariance) const {
    return distance_m > 0.0 ? std::sqrt(to_local_m.dot(covariance * to_local_m)) / distance_m : 0.0;
  }
  double speed_sigma_mps() const { return sigma(neighbor.velocity_covariance_local_m2ps2); }

  /// Standard deviation of the neighbor's lateral position when it arrives.
  double side_sigma_m() const {
    const Vector3 across(v_local_mps.y(), -v_local_mps.x(), 0.0);
    if (across.norm() < kClosing_mps) return 0.0;
    const double time_s = distance_m / closing_mps;
    const Vector3 side = across.normalized();
    return std::sqrt(side.dot(neighbor.covariance_local_m2 * side) +
                     time_s * time_s * side.dot(neighbor.velocity_covariance_local_m2ps2 * side));
  }
};

}  // namespace swiftlet
