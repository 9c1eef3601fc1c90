// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <vector>

#include "swiftlet/core/guidance/neighbor_memory.hpp"
#include "swiftlet/core/neighbor_view.hpp"

namespace swiftlet {

/// Where a vehicle looks whose sensor of neighbors has a blind sector.
class RblSight {
 public:
  /// @param views  none: all around
  explicit RblSight(std::vector<NeighborView> views) : views_(std::move(views)) {}

  /// The heading that keeps neighbors out of the blind sector, longest unseen and soonest here first, and then looks
  /// where it flies. It turns to where it has not looked for long: one that flies only as far as it sees where it
  /// flies.
  /// @param coming_local_m  places of those whom it may have to step aside for; they stay in view
  double heading(const Pose& T_local_body, const Vector3& to_local_m, std::span<const Neighbor> neighbors,
                 std::span<const Vector3> coming_local_m, double last_yaw_rad, TimeNs now);

  /// Could it see who is where it flies? A little beside the view is near enough.
  bool sees_ahead(const Pose& T_local_body, const Vector3& to_local_m) const;

 private:
  static constexpr int kHeadings = 24;

  bool sees(const Vector3& p_body_m) const;
  /// A direction of unit length; a little beside the view is near enough.
  bool sees_beside(const Vector3& direction_body) const;
  void look(const Matrix3& R_local_body, TimeNs now);

  std::vector<NeighborView> views_;
  std::array<TimeNs, kHeadings> looked_{};  // last time, by azimuth in the local frame
  int glance_ = -1;                         // the azimuth that it wants to see next; -1: it has seen all that it can
};

}  // namespace swiftlet
