// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "swiftlet/core/map/voxel_map.hpp"

namespace swiftlet {

/// Clusters of occupied voxels that hang together with no confident background [Vrba 2025, sec. III-D].
///
/// Voxels that are at least tentative are clustered by the distance of their centers; clusters with fewer than
/// `least_confident` confident voxels are separate (eqs. 23, 24). Voxels of a block of 2 x 2 x 2 are near each other
/// anyway (if the distance is that large), so blocks are joined instead of voxels. Keeps its memory.
class SeparateBackground {
 public:
  /// Indices of V_sep in ascending order; valid until the next call.
  const std::vector<std::ptrdiff_t>& find(const VoxelMap& map, double distance_m, int least_confident);

  /// Clusters that were not separate.
  int num_kept() const { return num_kept_; }

 private:
  struct Block {
    std::ptrdiff_t at;     // in numbers_
    std::ptrdiff_t voxel;  // index in the map of its lowest corner
    std::uint32_t voxels;  // a bit for each occupied one, x first, then y, then z
  };
  /// A place near a block where another one can be, and which of that one's voxels a block's voxels are near.
  struct Neighbor {
    std::ptrdiff_t step;
    std::array<std::uint8_t, 256> near;  // by the block's voxels
  };
  void look_around(const Cell& size, double distance);
  void collect(const VoxelMap& map);
  void join();
  std::uint32_t root(std::uint32_t block);
  template <class Visit>
  void for_each_voxel(const Block& block, Visit&& visit) const;

  Cell size_ = Cell::Zero();  // of the map
  double distance_ = -1.0;    // in edges
  int edge_ = 1, reach_ = 1;  // of a block in voxels; of the neighbors in blocks
  Cell blocks_size_ = Cell::Zero();
  std::vector<Neighbor> neighbors_;     // those that come before a block in the order of numbers_
  std::vector<std::uint32_t> numbers_;  // 1 + number of the block at each place, 0: none; with a border of empty ones
  std::vector<Block> blocks_;
  std::vector<std::uint32_t> parents_, num_confident_;
  std::vector<std::ptrdiff_t> separate_;
  int num_kept_ = 0;
};

}  // namespace swiftlet
