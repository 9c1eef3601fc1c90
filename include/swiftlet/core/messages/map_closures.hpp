// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// All closures between the sender's submaps and those of the receiver. Replaces the previous message.
struct MapClosures {
  static constexpr const char* kTopic = "map_closures";
  static constexpr int kVersion = 1;
  static constexpr const char* kDoc = "closures between submaps of the sender and of the receiver";

  /// T_own_other, as position and rotation vector.
  struct Closure {
    std::uint32_t own = 0, other = 0;
    Eigen::Vector3f p_own_m = Eigen::Vector3f::Zero();
    Eigen::Vector3f turn_own_rad = Eigen::Vector3f::Zero();

    static void visit(auto& c, auto& v) {
      v.field("own", c.own, "[-] number of the sender's submap");
      v.field("other", c.other, "[-] number of the receiver's submap");
      v.field("*_m", c.p_own_m, "[m] origin of the receiver's submap in the frame of the sender's");
      v.field("turn_*_rad", c.turn_own_rad,
              "[rad] rotation vector from the axes of the receiver's submap to those of the sender's");
    }
  };

  std::vector<Closure> closures;

  static void visit(auto& m, auto& v) {
    v.list("num_closures", m.closures,
           "[-] closures: submap numbers, and pose of the receiver's in the sender's [m, rad]");
  }
};

}  // namespace swiftlet
