// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet::support {

/// Root mean square distance of two paths after their best alignment.
inline double absolute_error_m(const std::vector<Vector3>& p_m, const std::vector<Vector3>& p_true_m) {
  const Eigen::Map<const Eigen::Matrix3Xd> from(p_m[0].data(), 3, p_m.size());
  const Eigen::Map<const Eigen::Matrix3Xd> to(p_true_m[0].data(), 3, p_true_m.size());
  const Eigen::Matrix4d T = Eigen::umeyama(from, to, false);
  const Eigen::Matrix3Xd off_m = (T.topLeftCorner<3, 3>() * from).colwise() + T.topRightCorner<3, 1>() - to;
  return std::sqrt(off_m.squaredNorm() / static_cast<double>(p_true_m.size()));
}

}  // namespace swiftlet::support
