// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/base/capture_volume.hpp"

#include <algorithm>
#include <utility>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet {

void CaptureVolume::visit(ConfigVisitor& v) {
  v.field("offset_m", offset_m,
          "[m] center of the volume relative to that of the vehicle: ahead, left, up; level at any tilt");
  v.field("radius_m", radius_m, "[m] radius of the opening", Range::positive());
  v.field("height_m", height_m, "[m] height of the volume; 0: a disc", Range::non_negative());
  v.field("rearm_m", rearm_m, "[m] distance from the center beyond which a captured target can be captured again",
          Range::non_negative());
}

Vector3 CaptureVolume::center(const Vector3& p_m, double yaw_rad) const {
  const double c = elementary::cos(yaw_rad), s = elementary::sin(yaw_rad);
  return p_m + Vector3(c * offset_m.x() - s * offset_m.y(), s * offset_m.x() + c * offset_m.y(), offset_m.z());
}

std::optional<double> CaptureVolume::met_m(const Vector3& from_net_m, const Vector3& to_net_m) const {
  const Vector3 motion_m = to_net_m - from_net_m;
  // The part of the segment between bottom and top.
  double first = 0.0, last = 1.0;
  const double low = -0.5 * height_m - from_net_m.z(), high = 0.5 * height_m - from_net_m.z();
  if (motion_m.z() == 0.0) {
    if (low > 0.0 || high < 0.0) return std::nullopt;
  } else {
    double a = low / motion_m.z(), b = high / motion_m.z();
    if (a > b) std::swap(a, b);
    first = std::max(first, a);
    last = std::min(last, b);
    if (first > last) return std::nullopt;
  }
  // Its point nearest to the axis.
  const double length_sq = motion_m.head<2>().squaredNorm();
  const double nearest = length_sq > 0.0 ? -from_net_m.head<2>().dot(motion_m.head<2>()) / length_sq : first;
  const double at = std::clamp(nearest, first, last);
  const double miss_m = (from_net_m.head<2>() + at * motion_m.head<2>()).norm();
  if (miss_m > radius_m) return std::nullopt;
  return miss_m;
}

}  // namespace swiftlet
