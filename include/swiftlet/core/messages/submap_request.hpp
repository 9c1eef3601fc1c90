// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace swiftlet {

/// Request for data of the receiver's submaps. Lists everything that is still missing, so it replaces the previous
/// request.
struct SubmapRequest {
  static constexpr const char* kTopic = "submap_request";
  static constexpr int kVersion = 1;
  static constexpr const char* kDoc = "request for missing data of the receiver's submaps";

  enum class Content { kDescriptors, kCloud };
  static constexpr std::array<const char*, 2> kContents = {"descriptors", "cloud"};

  Content content = Content::kCloud;
  std::uint32_t submap = 0;
  std::vector<std::uint8_t> missing;

  static void visit(auto& m, auto& v) {
    v.choice("content", m.content, kContents,
             "[-] descriptors: of submaps; cloud: chunks of one submap's compact cloud");
    v.field("submap", m.submap, "[-] number of the submap, or of the first submap");
    v.field("missing", m.missing, "[-] one bit for each chunk, or for each submap from the first on, lowest bit first");
  }
};

}  // namespace swiftlet
