// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/map/distance_tiles.hpp"
#include "core/map/log_odds_blocks.hpp"

namespace swiftlet {

/// Records changes between occupied and not occupied in the cells of LogOddsBlocks, so that distance fields need to
/// update only there. For each place of the table of blocks: the revision of the last change, and the cells that
/// changed in the last scan.
class OccupiedChanges {
 public:
  /// @param num_places  size of the table, LogOddsBlocks::num_places()
  explicit OccupiedChanges(std::size_t num_places);

  /// Begins a scan: discards the changed cells of the previous one and keeps the revisions.
  /// @param revision  revision of the map before the scan
  void begin_scan(const LogOddsBlocks& blocks, std::uint64_t revision);
  /// Records changed cells of a block in its layer z. To be called after the change.
  /// @param i      index of the block
  /// @param cells  changed cells of the layer, one bit each
  void note(const LogOddsBlocks& blocks, int i, int z, std::uint64_t cells, std::uint64_t revision);
  /// Records the removal of block i, which ends the occupancy of all its cells. To be called before the removal.
  void note_removed(const LogOddsBlocks& blocks, int i, std::uint64_t revision);
  /// True if the block in this place of the table has an occupied cell.
  bool any_in(std::size_t place) const { return (any_occupied_[place >> 6] >> (place & 63) & 1U) != 0; }
  /// Appends the changes in the blocks from low to high after revision `since`, as in OccupiedBlocks::append_changes().
  /// Blocks that share a place in the table share a record. Thus a block may be reported because another one, far away,
  /// has changed; the caller then checks it in vain.
  void append(const LogOddsBlocks& blocks, const Cell& low, const Cell& high, std::uint64_t since,
              std::vector<OccupiedBlocks::Change>& changes) const;

 private:
  using Bits = CellBlock::Bits;
  /// A block that changed in the last scan: the changed cells, and the occupied cells of the layers that have any.
  struct Touched {
    Cell at;  // block coordinates
    Bits cells{}, occupied{};
  };
  struct Record {
    std::uint32_t revision = 0;  // revision of the last change
    std::uint32_t touched = 0;   // index in touched_ plus 1; 0: not changed in the last scan
  };
  /// [blocks] Number of changed blocks in a scan for which memory is reserved. More blocks allocate during the flight.
  static constexpr std::size_t kTouchedBlocks = 4096;

  void note_revision(const LogOddsBlocks& blocks, int i, std::uint64_t revision);

  std::vector<Record> records_;              // indexed by place
  std::vector<std::uint64_t> any_occupied_;  // one bit per place: bit (place % 64) of word (place / 64)
  std::vector<Touched> touched_;
  std::uint64_t touched_after_ = 0;  // revision before the last scan
};

}  // namespace swiftlet
