// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "swiftlet/core/map/ray_cells.hpp"

namespace swiftlet {

/// What distances are worked out from: the occupied cells of blocks.
class OccupiedBlocks {
 public:
  virtual ~OccupiedBlocks() = default;
  /// Null when none is occupied.
  virtual const RayCells::Bits* occupied_of(const Cell& block) const = 0;
  /// The revision in which an occupied cell of the block came or went last, or a later one.
  virtual std::uint64_t occupied_changed(const Cell& block) const = 0;
};

/// Distance from the center of a cell to that of the nearest occupied cell: exact (Euclidean), up to a greatest
/// distance. It is worked out for a block of 8 x 8 x 8 cells when one of them is asked for, by three passes along the
/// axes [Felzenszwalb 2012]. It is worked out again only when an occupied cell came or went that may be near enough to
/// matter. So what nobody asks for costs nothing, and the answer does not depend on when it is asked for.
class DistanceTiles {
 public:
  static constexpr int kMostReach = 64;  ///< cells

  /// @param reach  greatest distance in cells; beyond, cells count as that far
  explicit DistanceTiles(int reach);

  static constexpr std::int16_t kFar = 20000;  ///< farther than the reach
  /// Square of the distance in cells, or kFar.
  /// @param revision  of the map, as of now
  std::int16_t squared(const Cell& cell, const OccupiedBlocks& map, std::uint64_t revision);
  /// Forgets the tiles for which this says so.
  template <class Predicate>
  void forget_if(Predicate&& far_away) {
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
      if (!tiles_[i]->used || !far_away(tiles_[i]->at)) continue;
      tiles_[i]->used = false;
      free_.push_back(static_cast<std::uint32_t>(i + 1));
    }
    last_ = nullptr;
    find_slots_anew(slots_.size());
  }
  std::size_t num_tiles() const { return tiles_.size() - free_.size(); }
  std::uint64_t num_computed() const { return num_computed_; }

 private:
  static constexpr int kSide = RayCells::kSide;
  struct Tile {
    std::array<std::int16_t, kSide * kSide * kSide> squared;
    Cell at = Cell::Zero();
    bool used = false, ready = false;
    std::uint64_t computed = 0, checked = 0;  // revisions
    int reach = 0;                            // occupied cells within so many cells of the tile may matter
  };
  /// A block near a tile: its place from there in blocks, and between any of their cells at least and at most.
  struct Offset {
    Cell blocks;
    int least_sq, most_sq;
  };
  struct Near {
    const RayCells::Bits* bits;
    Cell blocks;  // from the tile
  };

  Tile& tile_for(const Cell& block);
  void find_slots_anew(std::size_t count);
  std::size_t slot_of(const Cell& block) const;
  bool holds(const Tile& tile, const OccupiedBlocks& map) const;
  void compute(Tile& tile, const OccupiedBlocks& map);
  void measure(Tile& tile);

  int reach_;
  std::vector<Offset> offsets_;       // the nearest first
  std::vector<std::uint32_t> slots_;  // tile, counted from 1: open addressing
  std::vector<std::unique_ptr<Tile>> tiles_;
  std::vector<std::uint32_t> free_;
  Tile* last_ = nullptr;  // asked for
  std::uint64_t num_computed_ = 0;
  std::vector<Near> near_;
  std::vector<std::array<std::int16_t, kSide>> rows_;  // squares along x, by z and y
  std::vector<std::uint8_t> row_used_;
};

}  // namespace swiftlet
