// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/distance_tiles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>

#include "core/map/lanes.hpp"
#include "swiftlet/core/ensure.hpp"

namespace swiftlet {
namespace {

using Squares = std::int16_t __attribute__((vector_size(16)));  // of a row of eight cells

[[gnu::always_inline]] inline Squares least_of(const Squares& a, const Squares& b) { return a < b ? a : b; }

/// Cells between two blocks, along one axis: at least, and at most.
int least_gap(int offset) { return offset == 0 ? 0 : RayCells::kSide * (std::abs(offset) - 1) + 1; }
int most_gap(int offset) { return RayCells::kSide * (std::abs(offset) + 1) - 1; }

int squared_norm(int x, int y, int z) { return x * x + y * y + z * z; }

/// Squares of the distances of a row's eight cells to the nearest occupied one of them.
std::array<std::int16_t, RayCells::kSide> squares_within(unsigned row) {
  std::array<std::int16_t, RayCells::kSide> squares{};
  for (int x = 0; x < RayCells::kSide; ++x) {
    int gap = RayCells::kSide;
    for (int other = 0; other < RayCells::kSide; ++other) {
      if ((row >> other & 1U) != 0) gap = std::min(gap, std::abs(other - x));
    }
    squares[static_cast<std::size_t>(x)] = static_cast<std::int16_t>(gap * gap);
  }
  return squares;
}

/// The same for every row.
struct RowTable {
  RowTable() {
    for (unsigned row = 0; row < of.size(); ++row) of[row] = squares_within(row);
  }
  std::array<std::array<std::int16_t, RayCells::kSide>, 256> of;
};

/// Eight times the square of each number, for gaps in cells.
struct SquareTable {
  static constexpr int kMost = DistanceTiles::kMostReach + 2 * RayCells::kSide;
  SquareTable() {
    for (int gap = -kMost; gap <= kMost; ++gap) of[gap + kMost] = Squares{} + static_cast<std::int16_t>(gap * gap);
  }
  const Squares& operator[](int gap) const { return of[gap + kMost]; }
  Squares of[2 * kMost + 1];
};

std::int16_t most_of(std::span<const std::int16_t> squares) {
  std::int16_t most = 0;
  for (const std::int16_t square : squares) most = std::max(most, square);
  return most;
}

/// And to the nearest cell of a row that lies so many blocks farther along x.
[[gnu::always_inline]] inline Squares squares_to(unsigned row, int blocks, const RowTable& table) {
  if (blocks == 0) return lanes::load<Squares>(table.of[row].data());
  const int nearest =
      RayCells::kSide * blocks + (blocks > 0 ? std::countr_zero(row) : static_cast<int>(std::bit_width(row)) - 1);
  const Squares gap = static_cast<std::int16_t>(nearest) - Squares{0, 1, 2, 3, 4, 5, 6, 7};
  return gap * gap;
}

}  // namespace

DistanceTiles::DistanceTiles(int reach) : reach_(reach) {
  const int blocks = (reach + kSide - 1) / kSide;
  for (int z = -blocks; z <= blocks; ++z) {
    for (int y = -blocks; y <= blocks; ++y) {
      for (int x = -blocks; x <= blocks; ++x) {
        const int least_sq = squared_norm(least_gap(x), least_gap(y), least_gap(z));
        if (least_sq > reach * reach) continue;
        offsets_.push_back({Cell(x, y, z), least_sq, squared_norm(most_gap(x), most_gap(y), most_gap(z))});
      }
    }
  }
  std::stable_sort(offsets_.begin(), offsets_.end(),
                   [](const Offset& a, const Offset& b) { return a.least_sq < b.least_sq; });
}

std::int16_t DistanceTiles::squared(const Cell& cell, const OccupiedBlocks& map, std::uint64_t revision) {
  const Cell block(cell.x() >> 3, cell.y() >> 3, cell.z() >> 3);
  Tile& tile = last_ != nullptr && last_->at == block ? *last_ : tile_for(block);
  last_ = &tile;
  if (!tile.ready || tile.checked != revision) {
    if (!tile.ready || !holds(tile, map)) {
      compute(tile, map);
      tile.computed = revision;
      tile.ready = true;
    }
    tile.checked = revision;
  }
  return tile.squared[static_cast<std::size_t>((cell.x() & 7) | (cell.y() & 7) << 3 | (cell.z() & 7) << 6)];
}

bool DistanceTiles::holds(const Tile& tile, const OccupiedBlocks& map) const {
  for (const Offset& offset : offsets_) {
    if (offset.least_sq > tile.reach * tile.reach) return true;
    if (map.occupied_changed(tile.at + offset.blocks) > tile.computed) return false;
  }
  return true;
}

// What is near is looked at first: when no cell of the tile is farther from an occupied one than that reaches, the rest
// does not matter.
void DistanceTiles::compute(Tile& tile, const OccupiedBlocks& map) {
  ++num_computed_;
  near_.clear();
  tile.squared.fill(kFar);
  tile.reach = reach_;
  auto offset = offsets_.begin();
  int bound_sq = reach_ * reach_;
  for (int seen = kSide;; seen += kSide) {
    const std::size_t before = near_.size();
    for (; offset != offsets_.end() && offset->least_sq <= std::min(seen * seen, bound_sq); ++offset) {
      const RayCells::Bits* bits = map.occupied_of(tile.at + offset->blocks);
      if (bits == nullptr) continue;
      bound_sq = std::min(bound_sq, offset->most_sq);
      near_.push_back({bits, offset->blocks});
    }
    if (near_.size() > before) measure(tile);
    const std::int16_t most = most_of(tile.squared);
    if (most < kFar) bound_sq = std::min<int>(bound_sq, most);
    if (offset == offsets_.end() || offset->least_sq > bound_sq) break;
  }
  const auto reach_sq = static_cast<std::int16_t>(reach_ * reach_);
  for (std::int16_t& square : tile.squared) square = square > reach_sq ? kFar : square;
  const std::int16_t most = most_of(tile.squared);
  if (most < kFar) tile.reach = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(most))));
}

// Distances to the occupied cells of the blocks in near_.
void DistanceTiles::measure(Tile& tile) {
  static const RowTable table;
  static const SquareTable square_of;
  Cell low = near_.front().blocks, high = low;
  for (const Near& near : near_) low = low.cwiseMin(near.blocks), high = high.cwiseMax(near.blocks);
  const int num_y = kSide * (high.y() - low.y() + 1), num_z = kSide * (high.z() - low.z() + 1);
  // Along x: the nearest occupied cell of every row.
  rows_.resize(static_cast<std::size_t>(num_y) * num_z);
  row_used_.assign(rows_.size(), 0);
  for (const Near& near : near_) {
    const int first_y = (near.blocks.y() - low.y()) * kSide, first_z = (near.blocks.z() - low.z()) * kSide;
    for (int z = 0; z < kSide; ++z) {
      const std::size_t first = static_cast<std::size_t>(first_z + z) * num_y + static_cast<std::size_t>(first_y);
      for (std::uint64_t word = (*near.bits)[static_cast<std::size_t>(z)]; word != 0;) {
        const int y = std::countr_zero(word) >> 3;
        const Squares here = squares_to(static_cast<unsigned>(word >> (8 * y)) & 0xFFU, near.blocks.x(), table);
        word &= ~(std::uint64_t{0xFF} << (8 * y));
        const std::size_t at = first + static_cast<std::size_t>(y);
        lanes::store(row_used_[at] != 0 ? least_of(lanes::load<Squares>(rows_[at].data()), here) : here,
                     rows_[at].data());
        row_used_[at] = 1;
      }
    }
  }
  // Along y, then along z.
  Squares distances[kSide][kSide];
  for (auto& layer : distances) std::fill_n(layer, kSide, Squares{} + kFar);
  for (int z = 0; z < num_z; ++z) {
    Squares layer[kSide];
    std::fill_n(layer, kSide, Squares{} + kFar);
    bool any = false;
    for (int y = 0; y < num_y; ++y) {
      const std::size_t at = static_cast<std::size_t>(z) * num_y + static_cast<std::size_t>(y);
      if (row_used_[at] == 0) continue;
      any = true;
      const Squares row = lanes::load<Squares>(rows_[at].data());
      for (int to = 0; to < kSide; ++to) layer[to] = least_of(layer[to], row + square_of[low.y() * kSide + y - to]);
    }
    if (!any) continue;
    for (int to = 0; to < kSide; ++to) {
      const Squares square = square_of[low.z() * kSide + z - to];
      for (int y = 0; y < kSide; ++y) distances[to][y] = least_of(distances[to][y], layer[y] + square);
    }
  }
  std::memcpy(tile.squared.data(), distances, sizeof distances);
}

std::size_t DistanceTiles::slot_of(const Cell& block) const {
  const auto part = [](int c) { return static_cast<std::uint64_t>(c) & 0x1FFFFFU; };
  const std::uint64_t key = part(block.x()) | part(block.y()) << 21U | part(block.z()) << 42U;
  std::size_t slot = (key * 0x9E3779B97F4A7C15ULL >> 32U) & (slots_.size() - 1);
  while (slots_[slot] != 0 && tiles_[slots_[slot] - 1]->at != block) slot = (slot + 1) & (slots_.size() - 1);
  return slot;
}

void DistanceTiles::find_slots_anew(std::size_t count) {
  slots_.assign(count, 0);
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    if (tiles_[i]->used) slots_[slot_of(tiles_[i]->at)] = static_cast<std::uint32_t>(i + 1);
  }
}

DistanceTiles::Tile& DistanceTiles::tile_for(const Cell& block) {
  if (2 * (num_tiles() + 1) > slots_.size()) find_slots_anew(std::max<std::size_t>(1024, 2 * slots_.size()));
  std::uint32_t& place = slots_[slot_of(block)];
  if (place == 0) {
    if (free_.empty()) {
      tiles_.push_back(std::make_unique<Tile>());
      free_.push_back(static_cast<std::uint32_t>(tiles_.size()));
    }
    place = free_.back();
    free_.pop_back();
    Tile& fresh = *tiles_[place - 1];
    fresh.at = block;
    fresh.used = true;
    fresh.ready = false;
  }
  return *tiles_[place - 1];
}

}  // namespace swiftlet
