// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// A flying object found in one scan [Vrba 2025, sec. III-B]. Local frame between stages, world in Action.
struct Detection {
  static constexpr const char* kName = "detections";
  TimeNs t = 0;  ///< mean firing time of the detection's points
  Vector3 position_m = Vector3::Zero();
  Matrix3 covariance = Matrix3::Identity();
  Vector3 extent_m = Vector3::Zero();  ///< edges of the bounding box
  int num_points = 0;
  double confidence = 0.0;    ///< 0..1
  double reflectivity = 0.0;  ///< maximum over the returns; 1 = white Lambertian, markers are far brighter

  static void visit(auto& d, auto& v) {
    v.time("t_s", d.t, "[s] mean firing time of the points");
    v.field("*_m", d.position_m, "[m] position in the world frame as estimated by the vehicle");
    v.covariance("cov_*_m2", d.covariance, "[m^2] covariance of the position");
    v.field("extent_*_m", d.extent_m, "[m] edges of the bounding box");
    v.field("num_points", d.num_points, "[-] number of points of the scan in the detection");
    v.field("confidence", d.confidence, "[-] 0 to 1");
    v.field("reflectivity", d.reflectivity, "[-] maximum reflectivity of the returns; 1: white Lambertian");
  }
};

}  // namespace swiftlet
