// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "core/interception/geofence.hpp"
#include "swiftlet/core/base/capture_volume.hpp"
#include "swiftlet/core/base/overlay.hpp"

namespace swiftlet {

/// A curve from now on, as a polyline through points at equal intervals.
void append_curve(const char* name, const char* meaning, const Eigen::Vector4f& color, double duration_s,
                  const std::function<Vector3(double t_s)>& place_local_m, std::vector<Overlay>& overlays);
void append_net(const CaptureVolume& net, const Vector3& p_local_m, double yaw_rad, std::vector<Overlay>& overlays);
void append_fence(const Geofence& fence, std::vector<Overlay>& overlays);

}  // namespace swiftlet
