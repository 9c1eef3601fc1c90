// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// State of a teammate as estimated by the observer, predicted to now. Local frame between stages, world in Action.
struct RelativeEstimate {
  static constexpr const char* kName = "relatives";
  using Covariance = Eigen::Matrix<double, 7, 7>;

  TimeNs t = 0;  ///< current time
  VehicleId other = kNoVehicle;
  Vector3 position_m = Vector3::Zero();
  Vector3 velocity_mps = Vector3::Zero();
  double yaw_rad = 0.0;
  Covariance covariance = Covariance::Identity();  ///< position [m], velocity [m/s], heading [rad]
  TimeNs seen = 0;          ///< time of the last sighting; earlier than now: the estimate is coasting
  TimeNs report_t = 0;      ///< validity time of the newest odometry report, by the observer's clock
  TimeNs report_stamp = 0;  ///< validity time of that report, by the teammate's clock
  Vector3 report_position_m = Vector3::Zero();  ///< position then; origin of a GuidingPath's frame
  double report_yaw_rad = 0.0;

  static void visit(auto& r, auto& v) {
    v.time("t_s", r.t, "[s] time of validity");
    v.vehicle("other", r.other, "[-] localized vehicle");
    v.field("*_m", r.position_m, "[m] position in the world frame as estimated by the vehicle");
    v.field("v*_mps", r.velocity_mps, "[m/s] velocity, in the same axes");
    v.field("yaw_rad", r.yaw_rad, "[rad] heading, counter-clockwise from the x axis of that world");
    v.covariance("cov_*_m2", r.covariance, "[m^2] covariance of the position");
    v.time("seen_s", r.seen, "[s] time of the last sighting");
    v.time("heard_s", r.report_t, "[s] time of validity of the newest odometry report");
    v.time("heard_stamp_s", r.report_stamp, "[s] time of validity of that report, by the teammate's clock");
    v.field("heard_*_m", r.report_position_m, "[m] position at that instant, in the same world");
    v.field("heard_yaw_rad", r.report_yaw_rad, "[rad] heading at that instant");
  }
};

}  // namespace swiftlet
