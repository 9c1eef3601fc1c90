// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/base/time.hpp"

namespace swiftlet {

/// A goal that is set once in a period and moves there linearly until the next one: a reference governor would respond
/// to each jump with full jerk.
struct GlidingGoal {
  Vector3 from_local_m = Vector3::Zero(), to_local_m = Vector3::Zero();  ///< at the last and at the next update

  /// @param tick  without ticks between updates the goal jumps
  Vector3 at(TimeNs now, TimeNs next_update, TimeNs period, TimeNs tick) const {
    const bool jumps = period <= tick;
    const double left = jumps ? 0.0 : std::clamp(to_seconds(next_update - now) / to_seconds(period), 0.0, 1.0);
    return left * from_local_m + (1.0 - left) * to_local_m;
  }
};

}  // namespace swiftlet
