// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "core/guidance/half_space.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// Recent positions and fields of view of a vehicle, by which observed free space differs from space never seen: the
/// map only has the obstacles.
class RblViewed {
 public:
  /// @param reach_m    range within which a position is observed to be free
  /// @param own_half_m  radius of the vehicle: free space around its past positions
  RblViewed(double reach_m, double own_half_m);

  /// Adds the present view, if the vehicle has moved or turned since the last one.
  /// @param yaw_rad  heading in the local frame
  /// @param view     field of view, relative to the vehicle
  void look(const Vector3& p_local_m, double yaw_rad, const std::array<HalfSpace, 2>& view);

  /// True when the vehicle has been at the position, or looked there along a line that is free in the present map.
  bool contains(const Vector3& q_local_m, const OccupancyView& map) const;

 private:
  struct Look {
    Vector3 p_local_m = Vector3::Zero();
    double yaw_rad = 0.0;
    std::array<HalfSpace, 2> view;
  };

  double reach_m_, own_half_m_;
  std::vector<Look> looks_;  // ring of the last views
  std::size_t next_ = 0;     // index of the next view to overwrite
};

}  // namespace swiftlet
