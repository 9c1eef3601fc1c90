// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/overlay.hpp"

namespace swiftlet {

/// Overlay of the detections, still without positions.
inline Overlay detection_spheres() {
  Overlay spheres;
  spheres.name = "detections";
  spheres.kind = Overlay::Kind::kSpheres;
  spheres.size_m = 0.35F;  // radius of a small multirotor, for the eye alone
  spheres.legend = {{"detection", {1.0F, 0.3F, 0.3F, 0.35F}}};
  spheres.colors = {spheres.legend.front().color};
  return spheres;
}

}  // namespace swiftlet
