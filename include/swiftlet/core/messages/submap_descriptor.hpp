// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace swiftlet {

/// Compact, nearly heading-invariant descriptor of a finished SLAM submap. Vehicles with a similar submap may request
/// its cloud.
struct SubmapDescriptor {
  static constexpr const char* kTopic = "submap";
  static constexpr int kVersion = 1;
  static constexpr const char* kDoc = "descriptor of a finished submap of the sender, without the cloud";

  std::uint32_t submap = 0;
  std::uint32_t num_points = 0;
  std::uint16_t num_chunks = 0;
  std::vector<std::uint8_t> directions;
  std::vector<std::uint8_t> heights;

  static void visit(auto& m, auto& v) {
    v.field("submap", m.submap, "[-] number of the submap, from 0 on");
    v.field("num_points", m.num_points, "[-] number of points of the compact cloud");
    v.field("num_chunks", m.num_chunks, "[-] number of messages with the compact cloud");
    v.field("directions", m.directions,
            "[-] histogram of surface directions about the vertical, over half a turn; maximum 255");
    v.field("heights", m.heights, "[-] histogram of upright structure by meters above the ground; maximum 255");
  }
};

}  // namespace swiftlet
