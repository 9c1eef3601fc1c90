// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Interface of a SLAM with submaps along its path, in the order of their beginning. The last one grows.
class SubmapProvider {
 public:
  virtual ~SubmapProvider() = default;
  virtual int num_submaps() const = 0;
  /// Points of a finished submap, which is immutable.
  virtual std::span<const Eigen::Vector3f> points_submap_m(int submap) const = 0;
  /// Present estimate of the submap's pose.
  virtual const Pose& T_local_submap(int submap) const = 0;
  /// Path length of the flight at the submap's beginning.
  virtual double path_length_m(int submap) const = 0;
  /// Increases whenever a pose changes or a submap begins.
  virtual std::uint64_t places_revision() const = 0;
};

}  // namespace swiftlet
