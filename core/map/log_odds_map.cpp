// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/log_odds_map.hpp"

#include <algorithm>

namespace swiftlet {

void LogOddsConfig::visit(ConfigVisitor& v) {
  v.field("voxel_m", voxel_m, "[m] edge of a voxel", Range::between(0.01, 100.0));
  v.field("l_occupied", l_occupied, "[-] log-odds of a hit", Range::positive());
  v.field("l_free", l_free, "[-] log-odds of a miss");
  v.field("L_min", L_min, "[-] lower limit of the log-odds");
  v.field("L_max", L_max, "[-] upper limit of the log-odds");
  v.field("L_occupied", L_occupied, "[-] log-odds from which a voxel is confident occupied");
  v.field("L_free", L_free, "[-] log-odds up to which a voxel is confident free");
  v.field("center_m", center_m, "[m] center of the box", Range::between(-1e5, 1e5));
  v.field("size_m", size_m, "[m] edges of the box", Range{0.0, 1e5, true});
  v.check(l_free < 0.0, "l_free", "a value < 0");
  v.check(L_min < L_free && L_free < L_occupied && L_occupied < L_max, "L_occupied",
          "L_min < L_free < L_occupied < L_max");
}

LogOddsMap::LogOddsMap(const LogOddsConfig& config)
    : config_(config),
      grid_(VoxelGrid::covering(config.center_m, config.size_m, config.voxel_m)),
      values_(grid_.num_cells(), 0.0F) {}

void LogOddsMap::insert(const Vector3& origin_m, std::span<const Vector3> ends_m,
                        std::span<const std::uint8_t> is_point) {
  if (!origin_m.allFinite()) return;
  double reach_m = 0.0;
  for (const Vector3& end : ends_m) {
    if (end.allFinite()) reach_m = std::max(reach_m, (end - origin_m).norm());
  }
  rays_.begin(Eigen::AlignedBox3d(origin_m), reach_m * (1.0 + 1e-9), grid_.edge_m, &grid_);
  occupied_.clear();
  for (std::size_t i = 0; i < ends_m.size(); ++i) {
    const Vector3 ray = ends_m[i] - origin_m;
    const double length_m = ray.norm();
    if (!(length_m > 0.0) || !ends_m[i].allFinite()) continue;
    rays_.add(origin_m, ray / length_m, length_m);
    if (is_point[i] && grid_.contains(ends_m[i])) occupied_.push_back(grid_.index(grid_.cell_of(ends_m[i])));
  }
  std::sort(occupied_.begin(), occupied_.end());
  occupied_.erase(std::unique(occupied_.begin(), occupied_.end()), occupied_.end());

  const auto move = [&](std::ptrdiff_t index, double l) {
    values_[index] = static_cast<float>(log_odds_updated(values_[index], l, config_));
  };
  for (const Cell& cell : rays_.cells()) {
    if (!grid_.contains(cell)) continue;
    const std::ptrdiff_t index = grid_.index(cell);
    if (!std::binary_search(occupied_.begin(), occupied_.end(), index)) move(index, config_.l_free);
  }
  for (const std::ptrdiff_t index : occupied_) move(index, config_.l_occupied);
}

}  // namespace swiftlet
