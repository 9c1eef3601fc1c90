// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/detection/separate_background.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"

namespace swiftlet {

/// Removal of separate background from a map [Vrba 2025, sec. III-D].
class SeparateRemoval {
 public:
  /// [m] d_sep: distance between clusters of background. Larger values connect more voxels to confident background and
  /// so remove fewer.
  static constexpr double kDistance_m = 0.7;

  explicit SeparateRemoval(const VofodConfig& config);

  /// Computes V_sep, for remove(). Voxels are stored as cells: the map may scroll meanwhile.
  void find(const VoxelMap& map);
  /// Removes V_sep from the map [Vrba 2025, eq. 25].
  /// @param num_classifications  N_cls: classifications since the last removal
  void remove(int num_classifications, VoxelMap& map);

 private:
  double g_;
  int min_confident_;
  SeparateBackground separator_;
  std::vector<Cell> separate_;
};

}  // namespace swiftlet
