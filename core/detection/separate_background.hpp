// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "swiftlet/core/map/voxel_map.hpp"

namespace swiftlet {

/// Clusters of occupied voxels without a connection to confident background [Vrba 2025, sec. III-D].
///
/// Voxels that are at least tentative are clustered by the distance of their centers; clusters with fewer than
/// `least_confident` confident voxels are separate (eqs. 23, 24). Voxels of a block of 2 x 2 x 2 are always connected
/// if the distance is large enough, so blocks are joined instead of voxels. Reuses its memory.
class SeparateBackground {
 public:
  /// Map indices of the voxels V_sep in ascending order; valid until the next call.
  const std::vector<std::ptrdiff_t>& find(const VoxelMap& map, double distance_m, int least_confident);

 private:
  struct Block {
    std::ptrdiff_t at;     // index in numbers_
    std::ptrdiff_t voxel;  // map index of its lowest corner
    std::uint32_t voxels;  // occupancy bits, x first, then y, then z
  };
  /// Relative position of a neighboring block, and the adjacency of the voxels of both blocks.
  struct Neighbor {
    std::ptrdiff_t step;
    std::array<std::uint8_t, 256> near;  // adjacent voxels of the neighbor, by voxel mask of the block
  };
  void look_around(const Cell& size, double distance);
  void collect(const VoxelMap& map);
  void join();
  std::uint32_t root(std::uint32_t block);
  template <class Visit>
  void for_each_voxel(const Block& block, Visit&& visit) const;

  Cell size_ = Cell::Zero();  // size of the map
  double distance_ = -1.0;    // clustering distance in voxel edges
  int edge_ = 1, reach_ = 1;  // edge of a block in voxels; reach of the neighbors in blocks
  Cell blocks_size_ = Cell::Zero();
  std::vector<Neighbor> neighbors_;     // neighbors before a block in the order of numbers_
  std::vector<std::uint32_t> numbers_;  // 1 + index of the block at each position, 0: none; with an empty border
  std::vector<Block> blocks_;
  std::vector<std::uint32_t> parents_, num_confident_;
  std::vector<std::ptrdiff_t> separate_;
};

}  // namespace swiftlet
