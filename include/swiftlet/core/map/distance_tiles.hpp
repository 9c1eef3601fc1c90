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
  /// A block in which occupied cells came or went.
  struct Change {
    Cell block;
    const RayCells::Bits* touched;   ///< cells that came or went, and perhaps others; null when that is forgotten
    const RayCells::Bits* occupied;  ///< of these cells, those that are occupied now
  };
  /// Appends the changes of the blocks from low to high after that revision, and perhaps others.
  virtual void append_changes(const Cell& low, const Cell& high, std::uint64_t since,
                              std::vector<Change>& changes) const = 0;
};

/// Distance from the center of a cell to that of the nearest occupied cell: exact (Euclidean), up to a greatest
/// distance. It is worked out for a block of 8 x 8 x 8 cells when one of them is asked for, by three passes along the
/// axes [Felzenszwalb 2012]. A cell that came since then can only lower distances, which is done in place. One that
/// went matters only to cells of which it was the nearest; the part of the block with these is worked out again. So
/// what nobody asks for costs nothing, and the answer does not depend on when it is asked for.
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
    std::array<std::int16_t, 8> octant_most;  // what may matter lies nearer than that to a cube of 4 x 4 x 4 cells
    bool used = false, ready = false;
    std::uint64_t checked = 0;  // revision
    int reach = 0;              // occupied cells within so many cells of the tile may matter
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
  /// Rows of a tile: pairs of them by y, layers by z, both from first to last.
  struct Part {
    int first_pair = 0, last_pair = kSide / 2 - 1, first_layer = 0, last_layer = kSide - 1;
  };

  bool follow(Tile& tile, const OccupiedBlocks& map);
  void compute(Tile& tile, const OccupiedBlocks& map, const Part& part);
  void measure(Tile& tile, int bound_sq, const Part& part);
  void finish(Tile& tile) const;

  int reach_;
  std::vector<Offset> offsets_;       // the nearest first
  std::vector<std::uint32_t> slots_;  // tile, counted from 1: open addressing
  std::vector<std::unique_ptr<Tile>> tiles_;
  std::vector<std::uint32_t> free_;
  Tile* last_ = nullptr;  // asked for
  std::uint64_t num_computed_ = 0;
  std::vector<OccupiedBlocks::Change> changes_;
  std::vector<Near> near_;
  std::vector<std::array<std::int16_t, kSide>> rows_;  // squares along x, by z and y
  std::vector<std::uint64_t> rows_used_;               // by bits: words for each z
};

}  // namespace swiftlet
