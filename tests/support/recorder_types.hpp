// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <vector>

#include "swiftlet/sim/registry/recorders.hpp"

namespace swiftlet::sim {

/// Recorders that work in any run. `slam_map` rejects runs without a SLAM map and is tested in test_sim_slam_map.
inline std::vector<const char*> recorders_of_any_run() {
  std::vector<const char*> names;
  for (const ModuleType& type : recorder_module_types()) {
    if (std::string_view(type.name) != "slam_map") names.push_back(type.name);
  }
  return names;
}

}  // namespace swiftlet::sim
