// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Poses of the SLAM submaps in the sender's local frame, as of now. The last submap still grows.
struct SubmapPlaces {
  static constexpr const char* kTopic = "submap_places";
  static constexpr int kVersion = 1;
  static constexpr const char* kDoc = "poses of the sender's SLAM submaps in its local frame";

  struct Place {
    Eigen::Vector3f p_local_m = Eigen::Vector3f::Zero();
    Eigen::Vector3f turn_local_rad = Eigen::Vector3f::Zero();
    float path_length_m = 0.0F;

    static void visit(auto& p, auto& v) {
      v.field("*_m", p.p_local_m, "[m] origin of the submap");
      v.field("turn_*_rad", p.turn_local_rad, "[rad] rotation vector from the submap's axes to that frame");
      v.field("path_length_m", p.path_length_m, "[m] length of the path flown before the submap began");
    }
  };

  std::uint32_t num_finished = 0;
  std::uint32_t first = 0;
  std::vector<Place> places;

  static void visit(auto& m, auto& v) {
    v.field("num_finished", m.num_finished, "[-] number of finished submaps");
    v.field("first", m.first, "[-] number of the first submap of the list");
    v.list("num_places", m.places, "[-] submaps: origin [m] and rotation vector [rad] in that frame, path length [m]");
  }
};

}  // namespace swiftlet
