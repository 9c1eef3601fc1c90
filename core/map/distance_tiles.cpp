// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/distance_tiles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

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

/// Squares of the distances of eight cells to the nearest of a row whose first cell lies so far from them.
std::array<std::int16_t, RayCells::kSide> squares_along_x(unsigned row, int offset) {
  std::array<std::int16_t, RayCells::kSide> squares{};
  for (int x = 0; x < RayCells::kSide; ++x) {
    // The nearest one at or after x, and the nearest one before it.
    const int at = x - offset;
    const unsigned after = at <= 0 ? row : at > 7 ? 0U : row >> at << at, before = row & ~after;
    int gap = 1 << 7;
    if (after != 0) gap = std::min(gap, std::countr_zero(after) - at);
    if (before != 0) gap = std::min(gap, at + 1 - static_cast<int>(std::bit_width(before)));
    squares[static_cast<std::size_t>(x)] = static_cast<std::int16_t>(gap * gap);
  }
  return squares;
}

/// The same from a table, for rows of the tile's own blocks and of those beside it.
struct RowTable {
  RowTable() {
    for (unsigned row = 1; row < 256; ++row) {
      for (int offset = -1; offset <= 1; ++offset) of[offset + 1][row] = squares_along_x(row, 8 * offset);
    }
  }
  std::array<std::array<std::int16_t, 8>, 256> of[3];
};

}  // namespace

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
  const int blocks = (tile.reach + kSide - 1) / kSide, reach_sq = tile.reach * tile.reach;
  for (int z = -blocks; z <= blocks; ++z) {
    for (int y = -blocks; y <= blocks; ++y) {
      for (int x = -blocks; x <= blocks; ++x) {
        if (squared_norm(least_gap(x), least_gap(y), least_gap(z)) > reach_sq) continue;
        if (map.occupied_changed(tile.at + Cell(x, y, z)) > tile.computed) return false;
      }
    }
  }
  return true;
}

void DistanceTiles::compute(Tile& tile, const OccupiedBlocks& map) {
  static const RowTable table;
  ++num_computed_;
  const int blocks = (reach_ + kSide - 1) / kSide, reach_sq = reach_ * reach_;
  near_.clear();
  int bound_sq = reach_sq;  // no cell of the tile is farther from an occupied one
  for (int z = -blocks; z <= blocks; ++z) {
    for (int y = -blocks; y <= blocks; ++y) {
      for (int x = -blocks; x <= blocks; ++x) {
        const int least_sq = squared_norm(least_gap(x), least_gap(y), least_gap(z));
        if (least_sq > bound_sq) continue;
        const RayCells::Bits* bits = map.occupied_of(tile.at + Cell(x, y, z));
        if (bits == nullptr) continue;
        const int most_sq = squared_norm(most_gap(x), most_gap(y), most_gap(z));
        bound_sq = std::min(bound_sq, most_sq);
        near_.push_back({bits, Cell(x, y, z), least_sq});
      }
    }
  }
  std::erase_if(near_, [&](const Near& near) { return near.least_sq > bound_sq; });
  tile.squared.fill(kFar);
  tile.reach = reach_;
  if (near_.empty()) return;

  Cell low = Cell::Constant(blocks), high = Cell::Constant(-blocks);
  for (const Near& near : near_) low = low.cwiseMin(near.offset), high = high.cwiseMax(near.offset);
  const int num_y = kSide * (high.y() - low.y() + 1), num_z = kSide * (high.z() - low.z() + 1);
  // Along x: the nearest occupied cell of every row.
  rows_.resize(static_cast<std::size_t>(num_y) * num_z);
  row_used_.assign(rows_.size(), 0);
  for (const Near& near : near_) {
    for (int z = 0; z < kSide; ++z) {
      std::uint64_t word = (*near.bits)[static_cast<std::size_t>(z)];
      for (; word != 0;) {
        const int y = std::countr_zero(word) >> 3;
        const unsigned row = static_cast<unsigned>(word >> (8 * y)) & 0xFFU;
        word &= ~(std::uint64_t{0xFF} << (8 * y));
        const std::size_t at = static_cast<std::size_t>((near.offset.z() - low.z()) * kSide + z) * num_y +
                               static_cast<std::size_t>((near.offset.y() - low.y()) * kSide + y);
        const int offset = near.offset.x();
        const auto squares = std::abs(offset) <= 1 ? table.of[offset + 1][row] : squares_along_x(row, kSide * offset);
        const Squares here = lanes::load<Squares>(squares.data());
        lanes::store(row_used_[at] != 0 ? least_of(lanes::load<Squares>(rows_[at].data()), here) : here,
                     rows_[at].data());
        row_used_[at] = 1;
      }
    }
  }
  // Along y, then along z.
  const Squares far = Squares{} + kFar;
  Squares distances[kSide][kSide];
  for (auto& layer : distances) std::fill_n(layer, kSide, far);
  for (int z = 0; z < num_z; ++z) {
    Squares layer[kSide];
    std::fill_n(layer, kSide, far);
    bool any = false;
    for (int y = 0; y < num_y; ++y) {
      const std::size_t at = static_cast<std::size_t>(z) * num_y + static_cast<std::size_t>(y);
      if (row_used_[at] == 0) continue;
      any = true;
      const Squares row = lanes::load<Squares>(rows_[at].data());
      for (int to = 0; to < kSide; ++to) {
        const int gap = low.y() * kSide + y - to;
        layer[to] = least_of(layer[to], row + static_cast<std::int16_t>(gap * gap));
      }
    }
    if (!any) continue;
    for (int to = 0; to < kSide; ++to) {
      const int gap = low.z() * kSide + z - to;
      const auto square = static_cast<std::int16_t>(gap * gap);
      for (int y = 0; y < kSide; ++y) distances[to][y] = least_of(distances[to][y], layer[y] + square);
    }
  }
  std::memcpy(tile.squared.data(), distances, sizeof distances);
  std::int16_t most = 0;
  for (std::int16_t& square : tile.squared) {
    if (square > reach_sq) square = kFar;
    most = std::max(most, square);
  }
  if (most < kFar) tile.reach = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(most))));
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
