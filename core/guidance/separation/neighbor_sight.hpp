// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/guidance/separation/neighbor_memory.hpp"
#include "swiftlet/core/base/neighbor_view.hpp"

namespace swiftlet {

/// Heading of a vehicle whose sensor of neighbors has a blind sector.
class NeighborSight {
 public:
  /// @param views  none: all around
  explicit NeighborSight(std::vector<NeighborView> views) : views_(std::move(views)) {}

  /// Heading [rad] that keeps neighbors out of the blind sector, with priority for those unseen for longest and closest
  /// in time, and then the flight direction in view.
  double heading(const Pose& T_local_body, const Vector3& to_local_m, std::span<const Neighbor> neighbors,
                 double last_yaw_rad, TimeNs now) const;

  /// True if neighbors in the flight direction would be in view. Tolerates directions slightly outside the view.
  bool sees_ahead(const Pose& T_local_body, const Vector3& to_local_m) const;

 private:
  /// [-] Headings that are compared, evenly spaced over a turn. More headings cost time and turn in finer steps.
  static constexpr int kHeadings = 24;

  bool sees(const Vector3& p_body_m) const;
  /// True if a unit direction is in view, or slightly outside.
  bool sees_beside(const Vector3& direction_body) const;

  std::vector<NeighborView> views_;
};

}  // namespace swiftlet
