// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "swiftlet/core/guidance/rbl_cell.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// Where a vehicle has been or looked of late. Its map shows obstacles, but not which air it has seen.
class RblViewed {
 public:
  /// @param reach_m    how far it sees that a place is free
  /// @param own_half_m  radius of the vehicle: where it has been, there is at least that much room
  RblViewed(double reach_m, double own_half_m);

  /// From where it looks now. Nothing is added until it has moved or turned.
  /// @param yaw_rad  of its heading, in the local frame
  /// @param view     what it sees, relative to the vehicle
  void look(const Vector3& p_local_m, double yaw_rad, const std::array<HalfSpace, 2>& view);

  /// Has it been there, or looked there along a line that is free in the map of now?
  bool contains(const Vector3& q_local_m, const OccupancyView& map) const;

 private:
  struct Look {
    Vector3 p_local_m = Vector3::Zero();
    double yaw_rad = 0.0;
    std::array<HalfSpace, 2> view;
  };

  double reach_m_, own_half_m_;
  std::vector<Look> looks_;  // the last ones, in a ring
  std::size_t next_ = 0;     // that is written
};

}  // namespace swiftlet
