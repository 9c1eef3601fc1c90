// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace swiftlet {

/// Part of a submap's compact cloud; decodable without the other parts (core/slam/compact_cloud).
struct SubmapChunk {
  static constexpr const char* kTopic = "submap_cloud";
  static constexpr int kVersion = 1;
  static constexpr const char* kDoc = "part of the compact cloud of a submap of the sender";

  std::uint32_t submap = 0;
  std::uint16_t chunk = 0;
  std::uint16_t num_points = 0;
  std::uint16_t bits = 0;
  float voxel_m = 0.0F;
  std::vector<std::uint8_t> data;

  static void visit(auto& m, auto& v) {
    v.field("submap", m.submap, "[-] number of the submap");
    v.field("chunk", m.chunk, "[-] number of the chunk, from 0 on");
    v.field("num_points", m.num_points, "[-] number of points of the chunk");
    v.field("bits", m.bits, "[-] bits of each coordinate within a voxel");
    v.field("voxel_m", m.voxel_m, "[m] edge of the voxels, each of which has one point");
    v.field("data", m.data, "[-] an octree of voxels, depth first, and the places within");
  }
};

}  // namespace swiftlet
