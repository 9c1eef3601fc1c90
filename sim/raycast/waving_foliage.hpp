// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>

#include "sim/raycast/embree_scene.hpp"
#include "swiftlet/core/base/time.hpp"
#include "swiftlet/sim/raycast/sweep_scene.hpp"

namespace swiftlet::sim {

/// The leaves of the world at one instant, for one sensor. World frame. Every leaf cluster is translated rigidly by
/// FoliageMotion, so that only the corners of its triangles change.
class WavingFoliage {
 public:
  /// @param world  must have foliage
  explicit WavingFoliage(std::shared_ptr<const StaticScene> world);

  /// Moves the leaves to their positions at time t.
  void move_to(TimeNs t);
  const TriangleScene& leaves() const { return leaves_; }

 private:
  const Foliage& foliage() const { return *world_->impl().foliage; }

  std::shared_ptr<const StaticScene> world_;
  std::vector<std::array<Eigen::Vector3f, 3>> enlarged_at_rest_m_;
  std::vector<Eigen::Vector3f> sway_m_;                                 // displacement of each tree's top
  std::array<Eigen::Vector3f, FoliageMotion::kNumPatterns> flutter_m_;  // displacement of each flutter pattern
  TriangleScene leaves_;
};

/// Separates the moving leaves from the rest; null where the scene has none.
std::unique_ptr<Foliage> make_foliage(const Scene& scene, const TriangleScene& world,
                                      const std::vector<std::uint32_t>& first_triangle);

}  // namespace swiftlet::sim
