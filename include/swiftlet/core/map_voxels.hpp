// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// A copy of what a stage's map knows at one instant, for whoever looks at it: every voxel that was ever seen.
struct MapVoxels {
  std::string name;                 ///< of the stage that keeps it: "detector", "mapping"
  double edge_m = 0.0;              ///< of a voxel
  std::vector<std::string> states;  ///< by number, from the freest to the surest
  std::uint8_t occupied_from = 0;   ///< this state and those after it are occupied
  std::vector<Eigen::Vector3f> centers_local_m;
  std::vector<std::uint8_t> state;  ///< of each voxel
  std::vector<float> value;         ///< from which its state follows: G, log-odds
  bool log_odds = false;            ///< values are OctoMap's, and cells stand for what its library has

  std::size_t size() const { return centers_local_m.size(); }
  void add(const Vector3& center_local_m, std::uint8_t its_state, float its_value) {
    centers_local_m.push_back(center_local_m.cast<float>());
    state.push_back(its_state);
    value.push_back(its_value);
  }
};

}  // namespace swiftlet
