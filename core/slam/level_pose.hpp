// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"

namespace swiftlet {

/// Heading and position of a body, without tilt: z up, as in the local frame and in frames of submaps.
inline Pose level_pose(const Pose& T) {
  return make_pose(T.translation(), rotation_by({0.0, 0.0, yaw_of(T.linear())}));
}

}  // namespace swiftlet
