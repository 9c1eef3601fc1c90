// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/interception/chase_mpc.hpp"
#include "swiftlet/core/localization/frame_change.hpp"

namespace swiftlet {

/// Flight area of an interceptor: a box in the world, and the waiting time for a target that has left it.
struct GeofenceConfig {
  Eigen::Vector3d min_m = {-100.0, -100.0, 2.0};
  Eigen::Vector3d max_m = {100.0, 100.0, 50.0};
  double patience_s = 2.0;

  void visit(ConfigVisitor& v);
};

/// The fence in the present local frame: six half-spaces, not necessarily aligned with its axes.
class Geofence {
 public:
  Geofence() = default;
  Geofence(const GeofenceConfig& config, const FrameChange& to_local);

  /// Distance of the point outside of the fence; negative inside [m].
  double excess_m(const Vector3& p_local_m) const;
  /// Nearest point inside.
  Vector3 inside(Vector3 p_local_m) const;
  const std::array<Wall, 6>& sides() const { return sides_; }

 private:
  std::array<Wall, 6> sides_;
};

}  // namespace swiftlet
