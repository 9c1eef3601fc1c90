// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/separate_removal.hpp"

#include <algorithm>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet {

SeparateRemoval::SeparateRemoval(const VofodConfig& config)
    : distance_m_(config.separate_distance_m),
      g_(config.choices.separate_becomes == VofodChoices::SeparateBecomes::kFree ? config.map.g_free
                                                                                 : config.map.g_unknown),
      min_confident_(config.separate_min_confident),
      reach_(config.choices.separate_reach) {}

void SeparateRemoval::find(const VoxelMap& map) {
  const auto& found = separator_.find(map, distance_m_, min_confident_);
  separate_.clear();
  switch (reach_) {
    case VofodChoices::SeparateReach::kCluster:
      for (const std::ptrdiff_t index : found) separate_.push_back(map.grid().cell(index));
      break;
    case VofodChoices::SeparateReach::kSphere:
      append_spheres(found, map.grid());
      break;
  }
}

// Appends every voxel within d_sep of a center, once.
void SeparateRemoval::append_spheres(std::span<const std::ptrdiff_t> centers, const VoxelGrid& grid) {
  const int reach = static_cast<int>(distance_m_ / grid.edge_m);
  const double reach_sq = elementary::pow(distance_m_ / grid.edge_m, 2);
  separate_index_.clear();
  for (const std::ptrdiff_t index : centers) {
    const Cell center = grid.cell(index);
    for (int z = -reach; z <= reach; ++z) {
      for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
          const Cell cell = center + Cell(x, y, z);
          if (x * x + y * y + z * z <= reach_sq && grid.contains(cell)) {
            separate_index_.push_back(grid.index(cell));
          }
        }
      }
    }
  }
  std::sort(separate_index_.begin(), separate_index_.end());
  separate_index_.erase(std::unique(separate_index_.begin(), separate_index_.end()), separate_index_.end());
  for (const std::ptrdiff_t index : separate_index_) separate_.push_back(grid.cell(index));
}

void SeparateRemoval::remove(int num_classifications, VoxelMap& map) {
  for (const Cell& cell : separate_) {
    if (map.grid().contains(cell)) map.update(map.grid().index(cell), num_classifications, g_);
  }
  separate_.clear();
}

}  // namespace swiftlet
