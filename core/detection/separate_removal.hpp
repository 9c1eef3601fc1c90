// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/detection/separate_background.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"

namespace swiftlet {

/// Removal of separate background from a map [Vrba 2025, sec. III-D].
class SeparateRemoval {
 public:
  explicit SeparateRemoval(const VofodConfig& config);

  /// Computes V_sep, for remove(). Voxels are stored as cells: the map may scroll meanwhile.
  void find(const VoxelMap& map);
  /// Removes V_sep from the map [Vrba 2025, eq. 25].
  /// @param num_classifications  N_cls: classifications since the last removal
  void remove(int num_classifications, VoxelMap& map);
  /// Number of clusters that were not separate.
  int num_kept() const { return separator_.num_kept(); }

 private:
  void append_spheres(std::span<const std::ptrdiff_t> centers, const VoxelGrid& grid);

  double distance_m_, g_;
  int min_confident_;
  VofodChoices::SeparateReach reach_;
  SeparateBackground separator_;
  std::vector<Cell> separate_;
  std::vector<std::ptrdiff_t> separate_index_;
};

}  // namespace swiftlet
