// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/sight.hpp"

#include <utility>

namespace swiftlet::sim {
namespace {

// [-] Number of leaves on a line of sight from which the line counts as blocked. Larger values cost time in dense
// crowns.
constexpr int kBlockingLeaves = 64;
// [m] Distance behind a leaf at which tracing continues. Smaller values may meet the same leaf again.
constexpr double kBehind_m = 0.01;

bool is_leaf(SurfaceClass surface_class) {
  return surface_class == SurfaceClass::kVegetation || surface_class == SurfaceClass::kUndergrowth;
}

}  // namespace

BlocksSight sight_in(std::shared_ptr<const StaticScene> world) {
  if (!world) return {};
  return [world = std::move(world)](const Eigen::Vector3d& a_world_m, const Eigen::Vector3d& b_world_m) {
    const double length_m = (b_world_m - a_world_m).norm();
    if (length_m <= kBehind_m) return false;
    const Eigen::Vector3d direction = (b_world_m - a_world_m) / length_m;
    double from_m = 0.0;
    for (int leaf = 0; leaf < kBlockingLeaves; ++leaf) {
      if (from_m >= length_m) return false;
      const RayHit hit = world->trace(a_world_m + from_m * direction, direction, length_m - from_m);
      if (hit.range_m <= 0.0F) return false;
      if (!is_leaf(hit.surface_class)) return true;
      from_m += static_cast<double>(hit.range_m) + kBehind_m;
    }
    return true;
  };
}

}  // namespace swiftlet::sim
