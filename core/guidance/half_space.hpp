// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/guidance/guidance_constants.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// The points q with normal . q <= offset_m, q relative to the agent.
struct HalfSpace {
  Vector3 normal_local = Vector3::UnitX();  ///< unit length
  double offset_m = 0.0;
};

/// Unit vector along a displacement; the x axis for one too short to have a direction. Any frame, the same for all
/// arguments.
inline Vector3 unit_along(const Vector3& displacement_m) {
  const double length_m = displacement_m.norm();
  return length_m > kSamePlace_m ? Vector3(displacement_m / length_m) : Vector3(Vector3::UnitX());
}

}  // namespace swiftlet
