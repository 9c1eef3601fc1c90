// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// The points q with normal . q <= offset_m, q relative to the agent.
struct HalfSpace {
  Vector3 normal_local = Vector3::UnitX();  ///< unit length
  double offset_m = 0.0;
};

}  // namespace swiftlet
