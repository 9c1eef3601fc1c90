// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Net of an interceptor: a disc, or an upright cylinder, that hangs below its vehicle and stays level.
struct CaptureVolume {
  Eigen::Vector3d offset_m = {0.0, 0.0, -1.2};
  double radius_m = 2.0;
  double height_m = 0.0;
  double rearm_m = 4.0;

  void visit(ConfigVisitor& v);

  /// Center of the net. Any frame, the same for all arguments.
  Vector3 center(const Vector3& p_m, double yaw_rad) const;
  /// Smallest distance of a target from the net's axis while it is inside the net; nothing when it misses the net. The
  /// target moves straight between two positions relative to the net's center. Any frame, the same for all arguments.
  std::optional<double> met_m(const Vector3& from_net_m, const Vector3& to_net_m) const;
};

}  // namespace swiftlet
