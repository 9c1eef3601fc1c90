// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// Log of the blocks that a map dropped last, with their revisions.
class BlockLog {
 public:
  void note(std::uint64_t revision, const Cell& block) {
    if (entries_.empty()) entries_.resize(kMost);
    entries_[count_++ % kMost] = {revision, block};
  }
  /// True when the log contains all blocks dropped after this revision.
  bool covers(std::uint64_t revision) const { return count_ <= kMost || entries_[count_ % kMost].revision <= revision; }
  template <class Fn>
  void for_each_since(std::uint64_t revision, Fn&& fn) const {
    for (std::size_t i = 0; i < std::min(count_, kMost); ++i) {
      if (entries_[i].revision > revision) fn(entries_[i].block);
    }
  }

 private:
  /// [-] Stored entries. Smaller values make readers check the whole map more often.
  static constexpr std::size_t kMost = 1024;
  struct Entry {
    std::uint64_t revision = 0;
    Cell block = Cell::Zero();
  };
  std::vector<Entry> entries_;  // ring buffer
  std::size_t count_ = 0;       // total number of entries ever added
};

}  // namespace swiftlet
