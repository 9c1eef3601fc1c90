// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace swiftlet {

/// What is known of the world before the start [Vrba 2025, sec. III-E]: points of occupied and of free voxels, world
/// frame.
struct PriorMap {
  std::vector<Eigen::Vector3f> occupied_m;
  std::vector<Eigen::Vector3f> free_m;
};

}  // namespace swiftlet
