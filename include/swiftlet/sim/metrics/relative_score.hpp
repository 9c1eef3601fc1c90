// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet::sim {

/// Error of a vehicle's estimate of another vehicle's pose, in one tick.
struct RelativeScore {
  static constexpr const char* kName = "relative_scores";
  TimeNs t = 0;
  VehicleId other = kNoVehicle;
  double distance_m = 0.0;
  Vector3 error_world_m = Vector3::Zero();
  double yaw_error_rad = 0.0;
  double sigma_m = 0.0;
  double sigma_yaw_rad = 0.0;
  double nees = 0.0;
  double unseen_s = 0.0;

  static void visit(auto& s, auto& v) {
    v.time("t_s", s.t, "[s] time of the score");
    v.vehicle("other", s.other, "[-] localized vehicle");
    v.field("distance_m", s.distance_m, "[m] true distance between the two");
    v.field("error_*_m", s.error_world_m,
            "[m] error of the position relative to the observer, in the axes of the world");
    v.field("yaw_error_rad", s.yaw_error_rad, "[rad] error of the heading relative to the observer");
    v.field("sigma_m", s.sigma_m, "[m] reported standard deviation of the position, over all axes");
    v.field("sigma_yaw_rad", s.sigma_yaw_rad, "[rad] reported standard deviation of the heading");
    v.field("nees", s.nees, "[-] normalized estimation error squared of the position; mean 3 for a correct covariance");
    v.field("unseen_s", s.unseen_s, "[s] time since the last sighting");
  }
};

}  // namespace swiftlet::sim
