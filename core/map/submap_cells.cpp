// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/submap_cells.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

#include "core/map/cell_hash.hpp"
#include "core/map/cell_walk.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

std::size_t count_of(const CellBlock::Bits& bits) {
  std::size_t count = 0;
  for (const std::uint64_t word : bits) count += static_cast<std::size_t>(std::popcount(word));
  return count;
}

bool comes_before(const Cell& a, const Cell& b) {
  return std::tie(a.z(), a.y(), a.x()) < std::tie(b.z(), b.y(), b.x());
}

}  // namespace

SubmapCells::SubmapCells(double edge_m, std::span<const CellBlock> blocks) : edge_m_(edge_m) {
  ENSURE(edge_m > 0.0, edge_m);
  at_.reserve(blocks.size());
  free_.reserve(blocks.size());
  occupied_place_.reserve(blocks.size());
  for (const CellBlock& block : blocks) {
    const std::size_t num_occupied = count_of(block.occupied), num_free = count_of(block.free);
    if (num_occupied + num_free == 0) continue;
    at_.push_back(block.at);
    free_.push_back(block.free);
    if (num_occupied > 0) occupied_.push_back(block.occupied);
    occupied_place_.push_back(num_occupied > 0 ? static_cast<std::uint32_t>(occupied_.size()) : 0);
    num_occupied_ += num_occupied;
    num_free_ += num_free;
  }
  occupied_.shrink_to_fit();
  if (at_.empty()) return;
  slots_.assign(std::bit_ceil(2 * at_.size()), 0);
  Cell low = at_.front(), high = low;
  for (std::size_t i = 0; i < at_.size(); ++i) {
    std::uint32_t& slot = slots_[slot_of(at_[i])];
    ENSURE(slot == 0, at_[i]);
    slot = static_cast<std::uint32_t>(i + 1);
    low = low.cwiseMin(at_[i]);
    high = high.cwiseMax(at_[i]);
    groups_.push_back({at_[i].x() >> 2, at_[i].y() >> 2, at_[i].z() >> 2});
  }
  std::sort(groups_.begin(), groups_.end(), comes_before);
  groups_.erase(std::unique(groups_.begin(), groups_.end()), groups_.end());
  groups_.shrink_to_fit();
  const double block_m = kSide * edge_m_;
  const Vector3 size_m = block_m * (high - low + Cell::Ones()).cast<double>();
  middle_m_ = block_m * low.cast<double>() + 0.5 * size_m;
  reach_m_ = 0.5 * size_m.norm();
}

SubmapCells SubmapCells::of_points(double edge_m, std::span<const Eigen::Vector3f> points_cells_m) {
  std::vector<Cell> cells;
  cells.reserve(points_cells_m.size());
  for (const Eigen::Vector3f& p : points_cells_m) {
    cells.emplace_back((p.cast<double>().array() / edge_m).floor().cast<int>());
  }
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) {
    const Cell block_a = block_of(a), block_b = block_of(b);
    return block_a == block_b ? comes_before(a, b) : comes_before(block_a, block_b);
  });
  std::vector<CellBlock> blocks;
  for (const Cell& cell : cells) {
    const Cell at = block_of(cell);
    if (blocks.empty() || blocks.back().at != at) blocks.push_back({at, {}, {}});
    const int i = index_in_block(cell);
    blocks.back().occupied[static_cast<std::size_t>(i >> 6)] |= std::uint64_t{1} << (i & 63);
  }
  return SubmapCells(edge_m, blocks);
}

std::size_t SubmapCells::slot_of(const Cell& block) const {
  std::size_t slot = first_slot(block, slots_.size());
  while (slots_[slot] != 0 && at_[slots_[slot] - 1] != block) slot = (slot + 1) & (slots_.size() - 1);
  return slot;
}

int SubmapCells::find(const Cell& block) const {
  return slots_.empty() ? -1 : static_cast<int>(slots_[slot_of(block)]) - 1;
}

std::size_t SubmapCells::bytes() const {
  return sizeof *this + at_.capacity() * sizeof(Cell) + free_.capacity() * sizeof(Bits) +
         occupied_place_.capacity() * sizeof(std::uint32_t) + occupied_.capacity() * sizeof(Bits) +
         slots_.capacity() * sizeof(std::uint32_t) + groups_.capacity() * sizeof(Cell);
}

}  // namespace swiftlet
