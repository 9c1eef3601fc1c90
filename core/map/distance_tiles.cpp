// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/distance_tiles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>

#include "core/map/lanes.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/map/occupancy_map.hpp"

namespace swiftlet {
namespace {

using Squares = std::int16_t __attribute__((vector_size(16)));  // one row of eight cells
using Pair = std::int16_t __attribute__((vector_size(32)));     // two rows, one after the other

template <class Vector>
[[gnu::always_inline]] inline Vector least_of(const Vector& a, const Vector& b) {
  return a < b ? a : b;
}
[[gnu::always_inline]] inline Pair twice(const Squares& row) {
  return __builtin_shufflevector(row, row, 0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7);
}
/// True when any lane of a comparison is set; lanes are all ones or all zeros.
template <class Vector>
[[gnu::always_inline]] inline bool any(const Vector& lanes) {
  std::uint64_t words[sizeof(Vector) / sizeof(std::uint64_t)], all = 0;
  std::memcpy(words, &lanes, sizeof lanes);
  for (const std::uint64_t word : words) all |= word;
  return all != 0;
}

/// Least and largest number of cells between two blocks along one axis.
int least_gap(int offset) { return offset == 0 ? 0 : CellBlock::kSide * (std::abs(offset) - 1) + 1; }
int most_gap(int offset) { return CellBlock::kSide * (std::abs(offset) + 1) - 1; }
/// Number of cells from a place to the nearest one in [first, last].
int gap_to(int place, int first, int last) { return std::max({0, first - place, place - last}); }

int squared_norm(int x, int y, int z) { return x * x + y * y + z * z; }

/// Squared distances of a row's eight cells to the nearest occupied cell in it.
std::array<std::int16_t, CellBlock::kSide> squares_within(unsigned row) {
  std::array<std::int16_t, CellBlock::kSide> squares{};
  for (int x = 0; x < CellBlock::kSide; ++x) {
    int gap = CellBlock::kSide;
    for (int other = 0; other < CellBlock::kSide; ++other) {
      if ((row >> other & 1U) != 0) gap = std::min(gap, std::abs(other - x));
    }
    squares[static_cast<std::size_t>(x)] = static_cast<std::int16_t>(gap * gap);
  }
  return squares;
}

/// squares_within() of every row.
struct RowTable {
  RowTable() {
    for (unsigned row = 0; row < of.size(); ++row) of[row] = squares_within(row);
  }
  std::array<std::array<std::int16_t, CellBlock::kSide>, 256> of;
};

/// [cells] Largest gap along an axis that occurs in a computation: the reach, and both blocks.
constexpr int kMaxGap = OccupancyMapConfig::kMaxDistance_cells + 2 * CellBlock::kSide;

/// Per gap in cells: its square eight times, then the square of the gap less one eight times, for the next row.
struct SquareTable {
  SquareTable() {
    for (int gap = -kMaxGap; gap <= kMaxGap; ++gap) {
      for (int lane = 0; lane < 16; ++lane) {
        const int to = gap - lane / 8;
        of[gap + kMaxGap][lane] = static_cast<std::int16_t>(to * to);
      }
    }
  }
  const Pair& operator[](int gap) const { return of[gap + kMaxGap]; }
  Pair of[2 * kMaxGap + 1];
};

/// Squared gaps per axis to the eight octants of a block, from a cell or from a block at an offset in blocks.
struct OctantTable {
  static constexpr int kHalf = CellBlock::kSide / 2, kMaxBlocks = kMaxGap / CellBlock::kSide;
  OctantTable() {
    for (int place = -kMaxGap; place <= kMaxGap; ++place) {
      fill(of_cell, place + kMaxGap, gap_to(place, 0, kHalf - 1), gap_to(place, kHalf, CellBlock::kSide - 1));
    }
    for (int offset = -kMaxBlocks; offset <= kMaxBlocks; ++offset) {
      const int first = offset * CellBlock::kSide, last = first + CellBlock::kSide - 1;
      fill(of_block, offset + kMaxBlocks, std::max({0, first - (kHalf - 1), -last}),
           std::max({0, first - (CellBlock::kSide - 1), kHalf - last}));
    }
  }
  template <std::size_t N>
  static void fill(Squares (&of)[3][N], int at, int to_lower, int to_upper) {
    for (int octant = 0; octant < 8; ++octant) {
      for (int axis = 0; axis < 3; ++axis) {
        const int gap = (octant >> axis & 1) != 0 ? to_upper : to_lower;
        of[axis][at][octant] = static_cast<std::int16_t>(gap * gap);
      }
    }
  }
  Squares from_cell(const Cell& place) const {
    return of_cell[0][place.x() + kMaxGap] + of_cell[1][place.y() + kMaxGap] + of_cell[2][place.z() + kMaxGap];
  }
  Squares from_block(const Cell& blocks) const {
    return of_block[0][blocks.x() + kMaxBlocks] + of_block[1][blocks.y() + kMaxBlocks] +
           of_block[2][blocks.z() + kMaxBlocks];
  }
  Squares of_cell[3][2 * kMaxGap + 1];
  Squares of_block[3][2 * kMaxBlocks + 1];
};

const RowTable kRows;
const SquareTable kSquares;
const OctantTable kOctants;

/// Squared distances of eight cells to the nearest occupied cell of a row at an offset in blocks along x.
[[gnu::always_inline]] inline Squares squares_to(unsigned row, int blocks) {
  if (blocks == 0) return lanes::load<Squares>(kRows.of[row].data());
  const int nearest =
      CellBlock::kSide * blocks + (blocks > 0 ? std::countr_zero(row) : static_cast<int>(std::bit_width(row)) - 1);
  const Squares gap = static_cast<std::int16_t>(nearest) - Squares{0, 1, 2, 3, 4, 5, 6, 7};
  return gap * gap;
}

/// Calls fn(squared distances from a place to the cells of a pair of rows, index of the pair, layer, stored values of
/// these cells) for the layers of a block within the bound.
template <class Fn>
[[gnu::always_inline]] inline void for_pairs(const Cell& place, int bound_sq, Fn&& fn, std::int16_t* squared) {
  const Squares gap = static_cast<std::int16_t>(place.x()) - Squares{0, 1, 2, 3, 4, 5, 6, 7};
  const Pair along_x = twice(gap * gap);
  for (int z = 0; z < CellBlock::kSide; ++z) {
    const int gap_z = place.z() - z;
    if (gap_z * gap_z > bound_sq) continue;
    const Pair along_xz = along_x + static_cast<std::int16_t>(gap_z * gap_z);
    for (int pair = 0; pair < CellBlock::kSide / 2; ++pair) {
      fn(Pair(along_xz + kSquares[place.y() - 2 * pair]), pair, z, squared + 16 * (4 * z + pair));
    }
  }
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
    if (!tile.ready || !follow(tile, map)) {
      tile.squared.fill(kFar);
      compute(tile, map, Part());
    }
    tile.ready = true;
    tile.checked = revision;
  }
  return tile.squared[static_cast<std::size_t>((cell.x() & 7) | (cell.y() & 7) << 3 | (cell.z() & 7) << 6)];
}

// Applies changes of the map: new cells lower distances; cells whose nearest cell is gone are recomputed. False when
// the map no longer has the changes.
bool DistanceTiles::follow(Tile& tile, const OccupiedBlocks& map) {
  const Cell blocks = Cell::Constant((tile.reach + kSide - 1) / kSide);
  changes_.clear();
  map.append_changes(tile.at - blocks, tile.at + blocks, tile.checked, changes_);
  const int reach_sq = reach_ * reach_;
  const Squares most = lanes::load<Squares>(tile.octant_most.data());
  bool changed = false;
  Part lost{kSide, -1, kSide, -1};
  for (const OccupiedBlocks::Change& change : changes_) {
    const Cell offset = change.block - tile.at;
    if (!any(kOctants.from_block(offset) <= most)) continue;
    if (change.touched == nullptr) return false;
    for (int z = 0; z < kSide; ++z) {
      for (std::uint64_t left = (*change.touched)[static_cast<std::size_t>(z)]; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        const Cell place = kSide * offset + Cell(bit & 7, bit >> 3, z);
        if (!any(kOctants.from_cell(place) <= most)) continue;
        changed = true;
        if (((*change.occupied)[static_cast<std::size_t>(z)] >> bit & 1U) != 0) {
          for_pairs(
              place, reach_sq,
              [&](const Pair& squares, int, int, std::int16_t* at) {
                const Pair within = squares <= static_cast<std::int16_t>(reach_sq) ? squares : Pair{} + kFar;
                lanes::store(least_of(lanes::load<Pair>(at), within), at);
              },
              tile.squared.data());
        } else {
          for_pairs(
              place, reach_sq,
              [&](const Pair& squares, int pair, int layer, std::int16_t* at) {
                const Pair before = lanes::load<Pair>(at);
                const Pair was_nearest = squares == before;
                if (!any(was_nearest)) return;
                lanes::store(Pair(was_nearest ? Pair{} + kFar : before), at);
                lost = {std::min(lost.first_pair, pair), std::max(lost.last_pair, pair),
                        std::min(lost.first_layer, layer), std::max(lost.last_layer, layer)};
              },
              tile.squared.data());
        }
      }
    }
  }
  if (lost.first_pair <= lost.last_pair) {
    compute(tile, map, lost);
  } else if (changed) {
    finish(tile);
  }
  return true;
}

// Measures near blocks first and stops when no farther block can lower a distance of the tile.
void DistanceTiles::compute(Tile& tile, const OccupiedBlocks& map, const Part& part) {
  ++num_computed_;
  auto offset = offsets_.begin();
  int bound_sq = reach_ * reach_;
  for (int seen = 0;; seen += kSide) {
    near_.clear();
    for (; offset != offsets_.end() && offset->least_sq <= std::min(seen * seen, bound_sq); ++offset) {
      const CellBlock::Bits* bits = map.occupied_of(tile.at + offset->blocks);
      if (bits == nullptr) continue;
      bound_sq = std::min(bound_sq, offset->most_sq);
      near_.push_back({bits, offset->blocks});
    }
    if (!near_.empty()) {
      measure(tile, bound_sq, part);
      Pair most{};
      for (std::size_t i = 0; i < tile.squared.size(); i += 16) {
        const Pair squares = lanes::load<Pair>(&tile.squared[i]);
        most = most > squares ? most : squares;
      }
      std::array<std::int16_t, 16> by_lane{};
      lanes::store(most, by_lane.data());
      bound_sq = std::min<int>(bound_sq, *std::max_element(by_lane.begin(), by_lane.end()));
    }
    if (offset == offsets_.end() || offset->least_sq > bound_sq) break;
  }
  finish(tile);
}

// Distances to the occupied cells of the blocks in near_, up to the bound.
void DistanceTiles::measure(Tile& tile, int bound_sq, const Part& part) {
  Cell low = near_.front().blocks, high = low;
  for (const Near& near : near_) low = low.cwiseMin(near.blocks), high = high.cwiseMax(near.blocks);
  const int num_y = kSide * (high.y() - low.y() + 1), num_z = kSide * (high.z() - low.z() + 1);
  const int words = (num_y + 63) / 64;
  // Along x: nearest occupied cell of each row.
  rows_.resize(static_cast<std::size_t>(num_y) * num_z);
  rows_used_.assign(static_cast<std::size_t>(words) * num_z, 0);
  for (const Near& near : near_) {
    const int first_y = (near.blocks.y() - low.y()) * kSide, first_z = (near.blocks.z() - low.z()) * kSide;
    for (int z = 0; z < kSide; ++z) {
      std::uint64_t word = (*near.bits)[static_cast<std::size_t>(z)];
      if (word == 0) continue;
      const int gap_z = gap_to(near.blocks.z() * kSide + z, part.first_layer, part.last_layer);
      const std::size_t first = static_cast<std::size_t>(first_z + z) * num_y;
      std::uint64_t* const used = &rows_used_[static_cast<std::size_t>(first_z + z) * words];
      while (word != 0) {
        const int y = std::countr_zero(word) >> 3, row = first_y + y;
        const auto bits = static_cast<unsigned>(word >> (8 * y)) & 0xFFU;
        word &= ~(std::uint64_t{0xFF} << (8 * y));
        const int gap_y = gap_to(near.blocks.y() * kSide + y, 2 * part.first_pair, 2 * part.last_pair + 1);
        if (gap_y * gap_y + gap_z * gap_z > bound_sq) continue;
        Squares here = squares_to(bits, near.blocks.x());
        std::int16_t* const squares = rows_[first + static_cast<std::size_t>(row)].data();
        const std::uint64_t bit = std::uint64_t{1} << (row & 63);
        if ((used[row >> 6] & bit) != 0) here = least_of(here, lanes::load<Squares>(squares));
        used[row >> 6] |= bit;
        lanes::store(here, squares);
      }
    }
  }
  // Along y, then along z.
  constexpr int kPairs = kSide / 2;
  for (int z = 0; z < num_z; ++z) {
    Pair layer[kPairs];
    std::fill_n(layer, kPairs, Pair{} + kFar);
    bool used = false;
    for (int i = 0; i < words; ++i) {
      for (std::uint64_t left = rows_used_[static_cast<std::size_t>(z) * words + i]; left != 0; left &= left - 1) {
        const int y = 64 * i + std::countr_zero(left);
        const Pair row = twice(lanes::load<Squares>(rows_[static_cast<std::size_t>(z) * num_y + y].data()));
        const int gap = low.y() * kSide + y;
        for (int p = part.first_pair; p <= part.last_pair; ++p) {
          layer[p] = least_of(layer[p], Pair(row + kSquares[gap - 2 * p]));
        }
        used = true;
      }
    }
    if (!used) continue;
    for (int to = part.first_layer; to <= part.last_layer; ++to) {
      const int gap = low.z() * kSide + z - to;
      if (gap * gap > bound_sq) continue;
      std::int16_t* const squares = &tile.squared[static_cast<std::size_t>(to) * kSide * kSide];
      for (int p = part.first_pair; p <= part.last_pair; ++p) {
        const Pair here = layer[p] + static_cast<std::int16_t>(gap * gap);
        lanes::store(least_of(lanes::load<Pair>(squares + 16 * p), here), squares + 16 * p);
      }
    }
  }
}

// Marks distances beyond the reach as far, and bounds the distance at which changes of the map matter.
void DistanceTiles::finish(Tile& tile) const {
  const auto reach_sq = static_cast<std::int16_t>(reach_ * reach_);
  Pair most[2][2] = {};  // largest squares of four rows, by the halves of y and z
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; y += 2) {
      std::int16_t* const at = &tile.squared[static_cast<std::size_t>(z * kSide + y) * kSide];
      const Pair squares = lanes::load<Pair>(at);
      const Pair far = squares > reach_sq;
      lanes::store(Pair(far ? Pair{} + kFar : squares), at);
      const Pair bounded = far ? Pair{} + reach_sq : squares;
      Pair& of = most[z / 4][y / 4];
      of = of > bounded ? of : bounded;
    }
  }
  std::int16_t greatest = 0;
  for (int octant = 0; octant < 8; ++octant) {
    const Pair& of = most[octant >> 2][octant >> 1 & 1];
    std::int16_t here = 0;
    for (int lane = 0; lane < 16; ++lane) {
      if ((lane >> 2 & 1) == (octant & 1)) here = std::max(here, of[lane]);
    }
    tile.octant_most[static_cast<std::size_t>(octant)] = here;
    greatest = std::max(greatest, here);
  }
  tile.reach = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(greatest))));
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
