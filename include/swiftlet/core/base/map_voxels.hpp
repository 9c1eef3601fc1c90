// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Copy of a stage's map at one instant, for recorders and renderers: every voxel ever observed.
struct MapVoxels {
  std::string name;                 ///< name of the stage: "detector", "mapping"
  double edge_m = 0.0;              ///< edge of a voxel
  std::vector<std::string> states;  ///< names of the states by number, from free to occupied
  std::uint8_t occupied_from = 0;   ///< first state that counts as occupied, like all after it
  std::vector<Eigen::Vector3f> centers_local_m;
  std::vector<std::uint8_t> state;  ///< state of each voxel
  std::vector<float> value;         ///< value that determines the state: G, log-odds
  bool log_odds = false;            ///< values are OctoMap's log-odds; writers of octrees keep them

  std::size_t size() const { return centers_local_m.size(); }
  void add(const Vector3& center_local_m, std::uint8_t its_state, float its_value) {
    centers_local_m.push_back(center_local_m.cast<float>());
    state.push_back(its_state);
    value.push_back(its_value);
  }
};

}  // namespace swiftlet
