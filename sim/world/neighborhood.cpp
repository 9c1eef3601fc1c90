// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/neighborhood.hpp"

#include <algorithm>
#include <limits>

namespace swiftlet::sim {
namespace {

// A vehicle whose distance exceeds the least one by this remains farther until a vehicle has moved by a quarter of it,
// since both distances change by at most twice the displacement.
constexpr double kSlack_m = 2.0;
constexpr double kMaxDisplacement_m = 0.2499 * kSlack_m;

// [-] Candidates of a vehicle for which memory is reserved.
constexpr std::size_t kUsualNeighbors = 64;

}  // namespace

Neighborhood::Neighborhood(std::vector<double> radii_m)
    : radii_m_(std::move(radii_m)), candidates_(radii_m_.size()), gaps_m_(radii_m_.size()) {
  from_world_m_.assign(radii_m_.size(), Vector3::Constant(std::numeric_limits<double>::infinity()));
  for (auto& candidates : candidates_) candidates.reserve(std::min(radii_m_.size(), kUsualNeighbors));
}

void Neighborhood::update(std::span<const VehicleState> states) {
  for (std::size_t i = 0; i < from_world_m_.size(); ++i) {
    if ((states[i].p_world_m - from_world_m_[i]).squaredNorm() <= kMaxDisplacement_m * kMaxDisplacement_m) continue;
    search(states);
    return;
  }
}

void Neighborhood::search(std::span<const VehicleState> states) {
  const std::size_t count = from_world_m_.size();
  for (std::size_t i = 0; i < count; ++i) from_world_m_[i] = states[i].p_world_m;
  for (std::size_t i = 0; i < count; ++i) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < count; ++j) {
      gaps_m_[j] = (from_world_m_[i] - from_world_m_[j]).norm() - radii_m_[j];
      if (j != i) nearest_m = std::min(nearest_m, gaps_m_[j]);
    }
    candidates_[i].clear();
    for (std::size_t j = 0; j < count; ++j) {
      if (j != i && gaps_m_[j] <= nearest_m + kSlack_m) candidates_[i].push_back(static_cast<VehicleId>(j));
    }
  }
}

}  // namespace swiftlet::sim
