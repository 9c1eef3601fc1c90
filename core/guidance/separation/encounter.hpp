// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "core/guidance/separation/neighbor_memory.hpp"

namespace swiftlet {

/// Motion of a neighbor relative to the vehicle.
struct Encounter {
  /// [m/s] Closing speed above which a neighbor is evaded. Smaller values react to braking neighbors.
  static constexpr double kClosing_mps = 0.5;

  const Neighbor& neighbor;
  Vector3 p_local_m, v_local_mps;  ///< neighbor; horizontal for a planar vehicle
  Vector3 to_local_m;              ///< from the vehicle to the neighbor
  double distance_m = to_local_m.norm();
  /// Speed of the neighbor towards the vehicle.
  double closing_mps = distance_m > 0.0 ? std::max(0.0, -v_local_mps.dot(to_local_m) / distance_m) : 0.0;

  /// Standard deviation along the line from the vehicle to the neighbor.
  double sigma(const Matrix3& covariance) const {
    return distance_m > 0.0 ? std::sqrt(to_local_m.dot(covariance * to_local_m)) / distance_m : 0.0;
  }
  double speed_sigma_mps() const { return sigma(neighbor.velocity_covariance_local_m2ps2); }
};

}  // namespace swiftlet
