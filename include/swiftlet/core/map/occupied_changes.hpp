// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "swiftlet/core/map/distance_tiles.hpp"
#include "swiftlet/core/map/log_odds_blocks.hpp"

namespace swiftlet {

/// Changes of the occupied cells of blocks, by their places in the table: the revision of the last change, and the
/// cells that changed in the last scan.
class OccupiedChanges {
 public:
  explicit OccupiedChanges(std::size_t num_places);

  /// Forgets the changed cells of the last scan.
  /// @param revision  revision of the map before the scan
  void begin_scan(const LogOddsBlocks& blocks, std::uint64_t revision);
  /// Records changed cells of a layer, after the change.
  void note(const LogOddsBlocks& blocks, int i, int z, std::uint64_t cells, std::uint64_t revision);
  /// Records that a block will be removed, with its occupied cells.
  void note_removed(const LogOddsBlocks& blocks, int i, std::uint64_t revision);
  /// True when a block in this place has an occupied cell.
  bool any_in(std::size_t place) const { return (any_occupied_[place >> 6] >> (place & 63) & 1U) != 0; }
  /// As OccupiedBlocks::append_changes(). Blocks in the same place share a record; a change far away only causes an
  /// unnecessary check.
  void append(const LogOddsBlocks& blocks, const Cell& low, const Cell& high, std::uint64_t since,
              std::vector<OccupiedBlocks::Change>& changes) const;

 private:
  using Bits = RayCells::Bits;
  /// Cells of a block whose occupancy changed in the last scan, and those of them that are occupied now.
  struct Touched {
    Cell at;
    Bits cells{}, occupied{};
  };
  struct Record {
    std::uint32_t revision = 0, touched = 0;  // index + 1; 0: none
  };
  static constexpr std::size_t kTouchedBlocks = 4096;  // touched blocks per scan for which memory is reserved

  void note_revision(const LogOddsBlocks& blocks, int i, std::uint64_t revision);

  std::vector<Record> records_;              // indexed by place
  std::vector<std::uint64_t> any_occupied_;  // a bit for each place
  std::vector<Touched> touched_;
  std::uint64_t touched_after_ = 0;  // revision before the last scan
};

}  // namespace swiftlet
