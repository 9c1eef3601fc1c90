// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/occupied_changes.hpp"

#include <algorithm>

namespace swiftlet {

OccupiedChanges::OccupiedChanges(std::size_t num_places)
    : records_(num_places), any_occupied_((num_places + 63) / 64, 0) {
  touched_.reserve(kTouchedBlocks);
}

void OccupiedChanges::begin_scan(const LogOddsBlocks& blocks, std::uint64_t revision) {
  for (const Touched& touched : touched_) records_[blocks.place_of(touched.at)].touched = 0;
  touched_.clear();
  touched_after_ = revision;
}

void OccupiedChanges::note(const LogOddsBlocks& blocks, int i, int z, std::uint64_t cells, std::uint64_t revision) {
  const Cell& at = blocks.about(i).at;
  std::uint32_t& touched = records_[blocks.place_of(at)].touched;
  if (touched == 0) {
    touched_.push_back({at});
    touched = static_cast<std::uint32_t>(touched_.size());
  }
  Touched& entry = touched_[touched - 1];
  entry.cells[z] |= cells;
  entry.occupied[z] = blocks.block(i).occupied[z];
  note_revision(blocks, i, revision);
}

void OccupiedChanges::note_removed(const LogOddsBlocks& blocks, int i, std::uint64_t revision) {
  note_revision(blocks, i, revision);
  records_[blocks.place_of(blocks.about(i).at)].touched = 0;
}

void OccupiedChanges::note_revision(const LogOddsBlocks& blocks, int i, std::uint64_t revision) {
  const std::size_t place = blocks.place_of(blocks.about(i).at);
  const Bits& occupied = blocks.block(i).occupied;
  const bool has_occupied = std::any_of(occupied.begin(), occupied.end(), [](std::uint64_t word) { return word != 0; });
  if (has_occupied || any_in(place)) records_[place].revision = static_cast<std::uint32_t>(revision);
  const std::uint64_t bit = std::uint64_t{1} << (place & 63);
  std::uint64_t& word = any_occupied_[place >> 6];
  word = has_occupied ? word | bit : word & ~bit;
}

void OccupiedChanges::append(const LogOddsBlocks& blocks, const Cell& low, const Cell& high, std::uint64_t since,
                             std::vector<OccupiedBlocks::Change>& changes) const {
  // Changed cells are recorded for the last scan only. After an older revision, all cells of a block may have changed.
  const bool is_last_scan = since >= touched_after_;
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      const Record* const row = records_.data() + blocks.place_of({0, y, z});
      for (int x = low.x(); x <= high.x(); ++x) {
        const Record& record = row[blocks.wrapped(x)];
        if (record.revision <= since) continue;
        const Cell block(x, y, z);
        const bool known = is_last_scan && record.touched != 0 && touched_[record.touched - 1].at == block;
        const Touched* touched = known ? &touched_[record.touched - 1] : nullptr;
        changes.push_back({block, known ? &touched->cells : nullptr, known ? &touched->occupied : nullptr});
      }
    }
  }
}

}  // namespace swiftlet
