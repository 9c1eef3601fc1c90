// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/separate_removal.hpp"

namespace swiftlet {

SeparateRemoval::SeparateRemoval(const VofodConfig& config)
    : g_(config.choices.separate_becomes == VofodChoices::SeparateBecomes::kFree ? config.map.g_free
                                                                                 : config.map.g_unknown),
      min_confident_(config.separate_min_confident) {}

void SeparateRemoval::find(const VoxelMap& map) {
  separate_.clear();
  for (const std::ptrdiff_t index : separator_.find(map, kDistance_m, min_confident_)) {
    separate_.push_back(map.grid().cell(index));
  }
}

void SeparateRemoval::remove(int num_classifications, VoxelMap& map) {
  for (const Cell& cell : separate_) {
    if (map.grid().contains(cell)) map.update(map.grid().index(cell), num_classifications, g_);
  }
  separate_.clear();
}

}  // namespace swiftlet
