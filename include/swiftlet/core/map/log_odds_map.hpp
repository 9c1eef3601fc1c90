// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/elementary.hpp"
#include "swiftlet/core/map/ray_lengths.hpp"
#include "swiftlet/core/map/voxel_grid.hpp"
#include "swiftlet/core/map/voxel_map.hpp"

namespace swiftlet {

/// Conventional occupancy map, as a baseline [Vrba 2025, eqs. 1-5]. The defaults are OctoMap's: hit 0.7, miss 0.4,
/// clamped to 0.1192 and 0.971, occupied from 0.5 on; free below the prior by one miss.
struct LogOddsConfig {
  double voxel_m = 0.25;
  double l_occupied = 0.8473;
  double l_free = -0.4055;
  double L_min = -2.0;
  double L_max = 3.5;
  double L_occupied = 0.0;
  double L_free = -0.4;
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_m = {80.0, 80.0, 30.0};

  void visit(ConfigVisitor& v);
};

/// Log-odds of a cell after a measurement, eqs. (3) and (4) with saturation.
inline double log_odds_updated(double L, double l, const LogOddsConfig& config) {
  return std::min(std::max(L + l, config.L_min), config.L_max);
}

/// Any frame, the same for all arguments.
class LogOddsMap {
 public:
  explicit LogOddsMap(const LogOddsConfig& config);

  /// Inserts one scan: cells that contain a point change by l_occupied, other cells on a ray by l_free, once each.
  /// @param ends_m  end points of the rays; those not marked in `is_point` only clear cells
  void insert(const Vector3& origin_m, std::span<const Vector3> ends_m, std::span<const std::uint8_t> is_point);

  const VoxelGrid& grid() const { return grid_; }
  float value(std::ptrdiff_t index) const { return values_[index]; }
  double probability(std::ptrdiff_t index) const { return 1.0 / (1.0 + elementary::exp(-values_[index])); }
  /// State by eq. (5): confident occupied, confident free, or uncertain.
  VoxelState state(std::ptrdiff_t index) const {
    if (values_[index] >= config_.L_occupied && values_[index] != 0.0F) return VoxelState::kConfident;
    return values_[index] <= config_.L_free ? VoxelState::kFree : VoxelState::kUncertain;
  }

 private:
  LogOddsConfig config_;
  VoxelGrid grid_;
  std::vector<float> values_;
  RayLengths rays_;
  std::vector<std::ptrdiff_t> occupied_;
};

}  // namespace swiftlet
