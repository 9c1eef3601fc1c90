// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/moved_things.hpp"

#include <algorithm>

namespace swiftlet {
namespace {

/// Constants of remembered clusters.
struct ThingLimits {
  /// [m] Distance of two sightings of one cluster, and displacement from which it has moved. Covers the noise of the
  /// center of few returns; larger values take longer to see that a slow target moves.
  static constexpr float kRadius_m = 0.5F;
  /// [ns] Time without a sighting after which a cluster is dropped. Smaller values lose objects of few returns.
  static constexpr TimeNs kForgotten = 2'000'000'000;
  /// [-] Largest number of clusters; a further one replaces the cluster not seen for longest. Larger values cost time.
  static constexpr std::size_t kMost = 512;
};

}  // namespace

MovedThings::MovedThings() { things_.reserve(ThingLimits::kMost); }

MovedThings::Motion MovedThings::see(TimeNs t, const Vector3& center_local_m, bool in_free_air) {
  const Eigen::Vector3f center_m = center_local_m.cast<float>();
  Thing& thing = thing_at(t, center_m, in_free_air);
  thing.last_local_m = center_m;
  thing.last = t;
  thing.has_moved = thing.has_moved || (center_m - thing.first_local_m).norm() > ThingLimits::kRadius_m;
  return {thing.has_moved, t - thing.first};
}

MovedThings::Thing& MovedThings::thing_at(TimeNs t, const Eigen::Vector3f& center_local_m, bool in_free_air) {
  std::erase_if(things_, [&](const Thing& thing) { return t - thing.last > ThingLimits::kForgotten; });
  Thing* nearest = nullptr;
  float nearest_sq = ThingLimits::kRadius_m * ThingLimits::kRadius_m;
  for (Thing& thing : things_) {
    const float distance_sq = (thing.last_local_m - center_local_m).squaredNorm();
    if (!(distance_sq < nearest_sq)) continue;
    nearest_sq = distance_sq;
    nearest = &thing;
  }
  if (nearest != nullptr) return *nearest;
  const Thing begun{center_local_m, center_local_m, t, t, in_free_air};
  if (things_.size() < ThingLimits::kMost) return things_.emplace_back(begun);
  Thing& oldest =
      *std::min_element(things_.begin(), things_.end(), [](const Thing& a, const Thing& b) { return a.last < b.last; });
  return oldest = begun;
}

}  // namespace swiftlet
