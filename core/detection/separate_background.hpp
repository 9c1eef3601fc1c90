// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/map/voxel_map.hpp"

namespace swiftlet {

/// Clusters of occupied voxels that hang together with no confident background (000, sec. III-D).
///
/// Voxels that are at least tentative are clustered by the distance of their centres; clusters with fewer than
/// `least_confident` confident voxels are separate (eqs. 23, 24). Works on runs of the map's bits. Keeps its memory.
class SeparateBackground {
 public:
  /// Indices of V_sep in ascending order; valid until the next call.
  const std::vector<std::ptrdiff_t>& find(const VoxelMap& map, double distance_m, int least_confident);

  /// Clusters that were not separate.
  int num_kept() const { return num_kept_; }

 private:
  /// Occupied voxels of a row with gaps that the distance bridges.
  struct Run {
    int first, last;
  };
  void fill_runs(const VoxelMap& map, int bridged);
  void join_rows(const VoxelMap& map, std::ptrdiff_t row, std::ptrdiff_t other, int reach);
  std::uint32_t root(std::uint32_t run);
  void join(std::uint32_t a, std::uint32_t b);

  std::vector<Run> runs_;
  std::vector<std::uint32_t> row_start_;  // of each row in runs_, and the end
  std::vector<std::uint32_t> parents_, num_confident_;
  std::vector<std::ptrdiff_t> separate_;
  int num_kept_ = 0;
};

}  // namespace swiftlet
