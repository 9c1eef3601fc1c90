// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>

#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// Who has submaps of its way, in the order in which they began. The last one grows.
class TellsSubmaps {
 public:
  virtual ~TellsSubmaps() = default;
  virtual int num_submaps() const = 0;
  /// Of one that is finished: they stay what they are.
  virtual std::span<const Eigen::Vector3f> points_submap_m(int submap) const = 0;
  /// As far as is known by now.
  virtual const Pose& T_local_submap(int submap) const = 0;
  /// Of the flight, when it began.
  virtual double way_m(int submap) const = 0;
  /// Grows whenever a pose changes or a submap begins.
  virtual std::uint64_t places_revision() const = 0;
};

}  // namespace swiftlet
