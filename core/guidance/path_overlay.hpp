// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/base/overlay.hpp"

namespace swiftlet {

/// Overlay of a path in orange: a sphere of radius size_m at each point. Callers may change its kind and color.
inline Overlay path_overlay(const std::string& name, std::span<const Vector3> points_local_m, float size_m) {
  Overlay overlay;
  overlay.name = name;
  overlay.kind = Overlay::Kind::kSpheres;
  overlay.size_m = size_m;
  for (const Vector3& p_local_m : points_local_m) overlay.positions.push_back(p_local_m.cast<float>());
  overlay.colors = {{1.0F, 0.7F, 0.1F, 1.0F}};
  return overlay;
}

}  // namespace swiftlet
