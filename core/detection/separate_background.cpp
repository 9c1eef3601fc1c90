// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/separate_background.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace swiftlet {
namespace {

/// [-] Relative tolerance of the clustering distance, so that rounding does not disconnect voxels exactly that far
/// apart.
constexpr double kDistanceTolerance = 1e-9;

}  // namespace

const std::vector<std::ptrdiff_t>& SeparateBackground::find(const VoxelMap& map, double distance_m,
                                                            int least_confident) {
  look_around(map.grid().size, distance_m / map.grid().edge_m * (1.0 + kDistanceTolerance));
  collect(map);
  join();

  const auto least = static_cast<std::uint32_t>(std::max(least_confident, 0));
  num_confident_.assign(blocks_.size(), 0);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    std::uint32_t& count = num_confident_[parents_[i]];
    if (count >= least) continue;
    for_each_voxel(blocks_[i], [&](std::ptrdiff_t v) { count += map.state(v) == VoxelState::kConfident; });
  }
  separate_.clear();
  for (std::uint32_t i = 0; i < blocks_.size(); ++i) {
    if (num_confident_[parents_[i]] >= least) continue;
    for_each_voxel(blocks_[i], [&](std::ptrdiff_t v) { separate_.push_back(v); });
  }
  std::sort(separate_.begin(), separate_.end());
  return separate_;
}

// Tabulates the neighboring blocks within the clustering distance. The table is kept until the size of the map or the
// distance changes.
void SeparateBackground::look_around(const Cell& size, double distance) {
  if (size == size_ && distance == distance_) return;
  size_ = size;
  distance_ = distance;
  // Blocks of 2 x 2 x 2 voxels need a distance of at least their diagonal; otherwise each voxel is a block.
  edge_ = distance * distance >= 3.0 ? 2 : 1;
  reach_ = static_cast<int>(std::floor((distance + edge_ - 1) / edge_));
  blocks_size_ = (size.array() + edge_ - 1) / edge_ + 2 * reach_;
  numbers_.assign(blocks_size_.cast<std::ptrdiff_t>().prod(), 0);

  const int count = edge_ * edge_ * edge_;
  const auto cell_in_block = [&](int voxel) -> Cell {
    return {voxel % edge_, voxel / edge_ % edge_, voxel / (edge_ * edge_)};
  };
  neighbors_.clear();
  for (int z = -reach_; z <= 0; ++z) {
    for (int y = -reach_; y <= reach_; ++y) {
      for (int x = -reach_; x <= reach_; ++x) {
        if (z == 0 && (y > 0 || (y == 0 && x >= 0))) continue;
        Neighbor neighbor{(static_cast<std::ptrdiff_t>(z) * blocks_size_.y() + y) * blocks_size_.x() + x, {}};
        for (int own = 0; own < count; ++own) {
          for (int other = 0; other < count; ++other) {
            const Cell offset = edge_ * Cell(x, y, z) + cell_in_block(other) - cell_in_block(own);
            if (offset.squaredNorm() > distance * distance) continue;
            for (int voxels = 0; voxels < 256; ++voxels) {
              if ((voxels >> own) & 1) neighbor.near[voxels] |= static_cast<std::uint8_t>(1 << other);
            }
          }
        }
        if (neighbor.near.back() != 0) neighbors_.push_back(neighbor);
      }
    }
  }
}

// Collects the occupied blocks of the map, in ascending order of their index in numbers_.
void SeparateBackground::collect(const VoxelMap& map) {
  for (const Block& block : blocks_) numbers_[block.at] = 0;
  blocks_.clear();
  const int rows = edge_ * edge_;
  const std::uint64_t block_bits = (std::uint64_t{1} << edge_) - 1;
  std::array<const std::uint64_t*, 4> words{};
  for (int z = 0; z < size_.z(); z += edge_) {
    for (int y = 0; y < size_.y(); y += edge_) {
      for (int r = 0; r < rows; ++r) {
        const int row_y = y + r % edge_, row_z = z + r / edge_;
        const bool inside = row_y < size_.y() && row_z < size_.z();
        words[r] = inside ? map.row_bits(static_cast<std::ptrdiff_t>(row_z) * size_.y() + row_y) : nullptr;
      }
      const std::ptrdiff_t at =
          (static_cast<std::ptrdiff_t>(z / edge_ + reach_) * blocks_size_.y() + y / edge_ + reach_) * blocks_size_.x();
      const std::ptrdiff_t voxel = (static_cast<std::ptrdiff_t>(z) * size_.y() + y) * size_.x();
      for (int w = 0; w < map.words_per_row(); ++w) {
        std::uint64_t any = 0;
        for (int r = 0; r < rows; ++r) any |= words[r] != nullptr ? words[r][w] : 0;
        while (any != 0) {
          const int x = std::countr_zero(any) / edge_ * edge_;
          any &= ~(block_bits << x);
          std::uint32_t voxels = 0;
          for (int r = 0; r < rows; ++r) {
            if (words[r] != nullptr) voxels |= static_cast<std::uint32_t>(words[r][w] >> x & block_bits) << (r * edge_);
          }
          blocks_.push_back({at + (64 * w + x) / edge_ + reach_, voxel + 64 * w + x, voxels});
          numbers_[blocks_.back().at] = static_cast<std::uint32_t>(blocks_.size());
        }
      }
    }
  }
}

// Union-find over adjacent blocks. Afterwards the parent of each block is the first block of its cluster.
void SeparateBackground::join() {
  parents_.resize(blocks_.size());
  for (std::uint32_t i = 0; i < parents_.size(); ++i) {
    parents_[i] = i;
    std::uint32_t first = i;
    for (const Neighbor& neighbor : neighbors_) {
      const std::uint32_t number = numbers_[blocks_[i].at + neighbor.step];
      if (number == 0 || parents_[number - 1] == first) continue;
      if ((neighbor.near[blocks_[i].voxels] & blocks_[number - 1].voxels) == 0) continue;
      const std::uint32_t other = root(number - 1);
      parents_[std::max(first, other)] = std::min(first, other);
      first = std::min(first, other);
    }
  }
  for (std::uint32_t& parent : parents_) parent = parents_[parent];
}

std::uint32_t SeparateBackground::root(std::uint32_t block) {
  while (parents_[block] != block) {
    parents_[block] = parents_[parents_[block]];
    block = parents_[block];
  }
  return block;
}

template <class Visit>
void SeparateBackground::for_each_voxel(const Block& block, Visit&& visit) const {
  for (std::uint32_t bits = block.voxels; bits != 0; bits &= bits - 1) {
    const int i = std::countr_zero(bits);
    const int x = i % edge_, y = i / edge_ % edge_, z = i / (edge_ * edge_);
    visit(block.voxel + x + (y + static_cast<std::ptrdiff_t>(z) * size_.y()) * size_.x());
  }
}

}  // namespace swiftlet
