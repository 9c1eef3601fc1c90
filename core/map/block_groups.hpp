// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "swiftlet/core/map/submap_cells.hpp"

namespace swiftlet {

/// Composition state of 4 x 4 x 4 blocks of a map.
struct BlockGroup {
  static constexpr int kSide = SubmapCells::kGroup;
  struct Slot {
    std::uint64_t changed = 0, composed = 0;  ///< revisions: last change by the growing piece, last composition
    std::int32_t block = -1;                  ///< index of the composed block; -1: never known
    bool any_occupied = false;
  };

  Cell at = Cell::Zero();
  std::uint64_t moved = 0;            ///< revision at which a piece was added, removed or moved last
  std::vector<std::uint32_t> pieces;  ///< sorted from old to new
  std::array<Slot, kSide * kSide * kSide> slots;

  static Cell of(const Cell& block) { return {block.x() >> 2, block.y() >> 2, block.z() >> 2}; }
  Slot& slot_of(const Cell& block) {
    return slots[static_cast<std::size_t>((block.x() & 3) | (block.y() & 3) << 2 | (block.z() & 3) << 4)];
  }
  Cell block_of(int slot) const { return kSide * at + Cell(slot & 3, slot >> 2 & 3, slot >> 4); }
  int num_slots() const { return static_cast<int>(slots.size()); }
};

/// Groups of blocks, found by their position.
class BlockGroups {
 public:
  /// Null where no group was made.
  BlockGroup* find(const Cell& group) const;
  std::uint32_t find_or_make(const Cell& group);
  BlockGroup& operator[](std::uint32_t i) const { return *groups_[i]; }
  auto begin() const { return groups_.begin(); }
  auto end() const { return groups_.end(); }
  std::size_t bytes() const;

 private:
  std::size_t table_slot(const Cell& group) const;

  std::vector<std::unique_ptr<BlockGroup>> groups_;
  std::vector<std::uint32_t> table_ = std::vector<std::uint32_t>(1024, 0);  // index + 1; open addressing
  mutable BlockGroup* last_ = nullptr;                                      // group of the last query
};

}  // namespace swiftlet
