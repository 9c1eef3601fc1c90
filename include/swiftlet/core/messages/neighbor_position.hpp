// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Position of the sender.
struct NeighborPosition {
  static constexpr const char* kTopic = "neighbor";
  static constexpr int kVersion = 1;
  static constexpr const char* kDoc = "estimated position of the sender";

  TimeNs t = 0;
  Vector3 p_world_m = Vector3::Zero();

  static void visit(auto& m, auto& v) {
    v.time("t_s", m.t, "[s] time of validity");
    v.field("*_m", m.p_world_m, "[m] position in the sender's world frame");
  }
};

}  // namespace swiftlet
