// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// A flying object found in one scan [Vrba 2025, sec. III-B]. World frame of the agent's own estimate.
struct Detection {
  TimeNs t = 0;  ///< mean firing time of its points
  Vector3 position_m = Vector3::Zero();
  Matrix3 covariance = Matrix3::Identity();
  Vector3 extent_m = Vector3::Zero();  ///< edges of its bounding box
  int num_points = 0;
  double confidence = 0.0;  ///< 0..1
};

}  // namespace swiftlet
