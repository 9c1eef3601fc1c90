// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/interception/chase_mpc.hpp"
#include "swiftlet/core/interception/intercept_config.hpp"
#include "swiftlet/core/localization/frame_change.hpp"

namespace swiftlet {

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
