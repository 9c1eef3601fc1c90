// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "swiftlet/core/map/cell_block.hpp"

namespace swiftlet {

/// Input of the distance computation: the occupied cells of blocks.
class OccupiedBlocks {
 public:
  virtual ~OccupiedBlocks() = default;
  /// Null when no cell of the block is occupied.
  virtual const CellBlock::Bits* occupied_of(const Cell& block) const = 0;
  /// A block in which the set of occupied cells has changed.
  struct Change {
    Cell block;
    const CellBlock::Bits* touched;   ///< superset of the changed cells; null when they are not known
    const CellBlock::Bits* occupied;  ///< subset of `touched` that is occupied now
  };
  /// Appends at least the changes of the blocks from low to high after that revision.
  virtual void append_changes(const Cell& low, const Cell& high, std::uint64_t since,
                              std::vector<Change>& changes) const = 0;
};

/// Distance from the center of a cell to that of the nearest occupied cell: exact (Euclidean), up to a maximum.
/// Computed for a block of 8 x 8 x 8 cells on request, by three passes along the axes [Felzenszwalb 2012]. A newly
/// occupied cell can only lower distances, which is done in place. A cleared cell affects only cells of which it was
/// the nearest; the part of the block that contains these is recomputed. So unrequested distances cost nothing, and
/// results do not depend on the time of the request.
class DistanceTiles {
 public:
  static constexpr std::size_t kTileBytes = 1100;  ///< approximate memory of a block's distances

  /// @param reach  maximum distance in cells; larger distances are clamped to it
  explicit DistanceTiles(int reach);

  static constexpr std::int16_t kFar = 20000;  ///< squared distance of cells beyond the reach
  /// Squared distance in cells, or kFar.
  /// @param revision  current revision of the map
  std::int16_t squared(const Cell& cell, const OccupiedBlocks& map, std::uint64_t revision);
  /// Drops the tiles for which the predicate is true.
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
  static constexpr int kSide = CellBlock::kSide;
  struct Tile {
    std::array<std::int16_t, kSide * kSide * kSide> squared;
    Cell at = Cell::Zero();
    // Squared distance within which occupied cells can matter, for each cube of 4 x 4 x 4 cells.
    std::array<std::int16_t, 8> octant_most;
    bool used = false, ready = false;
    std::uint64_t checked = 0;  // revision of the last update
    int reach = 0;              // distance from the tile in cells within which occupied cells can matter
  };
  /// Relative position of a block near a tile, with the minimum and maximum distance between their cells.
  struct Offset {
    Cell blocks;
    int least_sq, most_sq;
  };
  struct Near {
    const CellBlock::Bits* bits;
    Cell blocks;  // relative to the tile
  };

  Tile& tile_for(const Cell& block);
  void find_slots_anew(std::size_t count);
  std::size_t slot_of(const Cell& block) const;
  /// Subset of a tile's rows: pairs of rows by y, layers by z, first to last inclusive.
  struct Part {
    int first_pair = 0, last_pair = kSide / 2 - 1, first_layer = 0, last_layer = kSide - 1;
  };

  bool follow(Tile& tile, const OccupiedBlocks& map);
  void compute(Tile& tile, const OccupiedBlocks& map, const Part& part);
  void measure(Tile& tile, int bound_sq, const Part& part);
  void finish(Tile& tile) const;

  int reach_;
  std::vector<Offset> offsets_;       // sorted by distance
  std::vector<std::uint32_t> slots_;  // tile index + 1; open addressing
  std::vector<std::unique_ptr<Tile>> tiles_;
  std::vector<std::uint32_t> free_;
  Tile* last_ = nullptr;  // tile of the last query
  std::uint64_t num_computed_ = 0;
  std::vector<OccupiedBlocks::Change> changes_;
  std::vector<Near> near_;
  std::vector<std::array<std::int16_t, kSide>> rows_;  // squared distances along x, by z and y
  std::vector<std::uint64_t> rows_used_;               // bit set of used rows: words for each z
};

}  // namespace swiftlet
