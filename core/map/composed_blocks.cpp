// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/composed_blocks.hpp"

#include <algorithm>
#include <utility>

#include "core/map/cell_walk.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

bool any_in(const CellBlock::Bits& bits) {
  return std::any_of(bits.begin(), bits.end(), [](std::uint64_t word) { return word != 0; });
}

/// Votes of pieces on the cells of a block, from the newest piece on. A cell is decided when a piece reports it
/// occupied, or when outvoted_by pieces in a row report it free. Older pieces no longer matter for it.
class Votes {
 public:
  explicit Votes(int outvoted_by) : outvoted_by_(outvoted_by) { open_.fill(~std::uint64_t{0}); }

  void take(const CellBlock::Bits& occupied, const CellBlock::Bits& free) {
    for (std::size_t z = 0; z < occupied.size(); ++z) {
      known_[z] |= (occupied[z] | free[z]) & open_[z];
      occupied_[z] |= occupied[z] & open_[z];
      open_[z] &= ~occupied[z];
      if (outvoted_by_ == 0) continue;
      // Number of free votes in a row: two bits per cell.
      const std::uint64_t against = free[z] & open_[z];
      twos_[z] ^= ones_[z] & against;
      ones_[z] ^= against;
      open_[z] &=
          ~(((outvoted_by_ & 1) != 0 ? ones_[z] : ~ones_[z]) & ((outvoted_by_ & 2) != 0 ? twos_[z] : ~twos_[z]));
    }
  }
  /// Cells that are not decided yet.
  const CellBlock::Bits& open() const { return open_; }
  void result(CellBlock::Bits& occupied, CellBlock::Bits& free) const {
    occupied = occupied_;
    for (std::size_t z = 0; z < free.size(); ++z) free[z] = known_[z] & ~occupied_[z];
  }

 private:
  int outvoted_by_;
  CellBlock::Bits open_{}, known_{}, occupied_{}, ones_{}, twos_{};
};

const CellBlock::Bits kAllCells = [] {
  CellBlock::Bits all;
  all.fill(~std::uint64_t{0});
  return all;
}();

}  // namespace

ComposedBlocks::ComposedBlocks(double edge_m, double distance_max_m, int outvoted_by)
    : BlockOccupancy(edge_m, distance_max_m), outvoted_by_(outvoted_by) {
  ENSURE(outvoted_by >= 0 && outvoted_by <= 3, outvoted_by);
}

// Pieces

int ComposedBlocks::add(std::shared_ptr<const SubmapCells> cells, const Pose& T_local_cells, int age, TimeNs seen) {
  ENSURE(cells != nullptr);
  std::uint32_t i = static_cast<std::uint32_t>(pieces_.size());
  if (free_pieces_.empty()) {
    pieces_.emplace_back();
  } else {
    i = free_pieces_.back();
    free_pieces_.pop_back();
  }
  pieces_[i] = {PlacedCells(std::move(cells), edge_m_), age, ++num_added_, seen, {}};
  ++num_pieces_;
  ++revision_;
  place(i, pieces_[i].placed.rounded(T_local_cells));
  return static_cast<int>(i);
}

bool ComposedBlocks::move(int i, const Pose& T_local_cells) {
  const auto self = static_cast<std::uint32_t>(i);
  const Pose T = piece(self).placed.rounded(T_local_cells);
  if (T.matrix() == piece(self).placed.T_local_cells().matrix()) return false;
  ++revision_;
  ++num_moved_;
  displace(self);
  place(self, T);
  return true;
}

void ComposedBlocks::remove(int i) {
  const auto self = static_cast<std::uint32_t>(i);
  ENSURE(!piece(self).placed.empty(), i);
  ++revision_;
  displace(self);
  pieces_[self] = {};
  free_pieces_.push_back(self);
  --num_pieces_;
}

void ComposedBlocks::replace(int i, std::shared_ptr<const SubmapCells> cells) {
  const auto self = static_cast<std::uint32_t>(i);
  ENSURE(!piece(self).placed.empty() && cells != nullptr, i);
  ++revision_;
  displace(self);
  pieces_[self].placed.replace(std::move(cells));
  place(self, Pose(piece(self).placed.T_local_cells()));
}

const ComposedBlocks::Piece& ComposedBlocks::piece(std::uint32_t i) const {
  ENSURE(!pieces_[i].placed.empty(), i);
  return pieces_[i];
}

void ComposedBlocks::place(std::uint32_t i, const Pose& T_local_cells) {
  Piece& piece = pieces_[i];
  piece.placed.place(T_local_cells);
  for (const Cell& group : piece.placed.overlapped_groups()) piece.groups.push_back(groups_.find_or_make(group));
  std::sort(piece.groups.begin(), piece.groups.end());
  piece.groups.erase(std::unique(piece.groups.begin(), piece.groups.end()), piece.groups.end());
  for (const std::uint32_t g : piece.groups) {
    BlockGroup& group = groups_[g];
    group.moved = revision_;
    group.pieces.insert(std::upper_bound(group.pieces.begin(), group.pieces.end(), i,
                                         [this](std::uint32_t a, std::uint32_t b) { return is_older(a, b); }),
                        i);
  }
}

bool ComposedBlocks::is_older(std::uint32_t a, std::uint32_t b) const {
  return std::pair(pieces_[a].age, pieces_[a].number) < std::pair(pieces_[b].age, pieces_[b].number);
}

void ComposedBlocks::displace(std::uint32_t i) {
  for (const std::uint32_t g : pieces_[i].groups) {
    groups_[g].moved = revision_;
    std::erase(groups_[g].pieces, i);
  }
  pieces_[i].groups.clear();
}

void ComposedBlocks::set_growing(const OccupancyMap* growing, const Cell& offset_blocks) {
  ++revision_;
  if (growing != growing_ || offset_blocks != growing_offset_blocks_) {
    if (growing_ != nullptr) note_grown(0);
    growing_ = growing;
    growing_offset_blocks_ = offset_blocks;
    growing_revision_ = 0;
  }
  if (growing_ == nullptr) return;
  note_grown(growing_revision_);
  growing_revision_ = growing_->revision();
}

void ComposedBlocks::note_grown(std::uint64_t since) {
  ENSURE(growing_->changed_since(since, grown_), since);
  for (const VoxelGrid& box : grown_) {
    const Cell block = block_of(box.min_cell) + growing_offset_blocks_;
    groups_[groups_.find_or_make(BlockGroup::of(block))].slot_of(block).changed = revision_;
  }
}

// Composition of blocks

bool ComposedBlocks::look(const Piece& piece, const Cell& block, Bits& occupied, Bits& free) const {
  return piece.placed.look(block, kAllCells, overlap_, occupied, free);
}

bool ComposedBlocks::look_growing(const Cell& block, Bits& occupied, Bits& free) const {
  CellBlock states;
  if (growing_ == nullptr || !growing_->look_at(block - growing_offset_blocks_, states)) return false;
  occupied = states.occupied;
  free = states.free;
  return true;
}

void ComposedBlocks::compose(const BlockGroup& group, const Cell& block, std::uint32_t but, Composed& made) const {
  Votes votes(outvoted_by_);
  Bits occupied, free;
  if (look_growing(block, occupied, free)) votes.take(occupied, free);
  for (auto i = group.pieces.rbegin(); i != group.pieces.rend() && any_in(votes.open()); ++i) {
    if (*i == but) continue;
    if (pieces_[*i].placed.look(block, votes.open(), overlap_, occupied, free)) votes.take(occupied, free);
  }
  votes.result(made.occupied, made.free);
}

const ComposedBlocks::Composed* ComposedBlocks::composed(const Cell& block) const {
  BlockGroup* group = groups_.find(BlockGroup::of(block));
  return group != nullptr ? composed(*group, block) : nullptr;
}

const ComposedBlocks::Composed* ComposedBlocks::composed(BlockGroup& group, const Cell& block) const {
  BlockGroup::Slot& slot = group.slot_of(block);
  const auto at = [this](std::int32_t i) {
    const auto place = static_cast<std::size_t>(i);
    return &chunks_[place / kChunk][place % kChunk];
  };
  if (slot.composed < std::max(slot.changed, group.moved)) {
    slot.composed = revision_;
    Composed made;
    ++num_composed_;
    compose(group, block, kNoPiece, made);
    slot.any_occupied = any_in(made.occupied);
    const bool any = slot.any_occupied || any_in(made.free);
    if (any && slot.block < 0) {
      if (num_blocks_ % kChunk == 0) chunks_.push_back(std::make_unique<Composed[]>(kChunk));
      slot.block = static_cast<std::int32_t>(num_blocks_++);
    }
    if (slot.block >= 0) *at(slot.block) = made;
  }
  return slot.block >= 0 ? at(slot.block) : nullptr;
}

CellState ComposedBlocks::state(const Vector3& p_local_m) const {
  const Cell cell = cell_of(p_local_m);
  const Composed* block = composed(block_of(cell));
  if (block == nullptr) return CellState::kUnknown;
  if (has(block->occupied, index_in_block(cell))) return CellState::kOccupied;
  return has(block->free, index_in_block(cell)) ? CellState::kFree : CellState::kUnknown;
}

const CellBlock::Bits* ComposedBlocks::occupied_of(const Cell& block) const {
  BlockGroup* group = groups_.find(BlockGroup::of(block));
  if (group == nullptr) return nullptr;
  const Composed* made = composed(*group, block);
  return made != nullptr && group->slot_of(block).any_occupied ? &made->occupied : nullptr;
}

void ComposedBlocks::append_changes(const Cell& low, const Cell& high, std::uint64_t since,
                                    std::vector<Change>& changes) const {
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const Cell block(x, y, z);
        BlockGroup* group = groups_.find(BlockGroup::of(block));
        if (group == nullptr || std::max(group->moved, group->slot_of(block).changed) <= since) continue;
        changes.push_back({block, nullptr, nullptr});
      }
    }
  }
}

std::size_t ComposedBlocks::bytes_of_blocks() const {
  std::size_t bytes = pieces_.capacity() * sizeof(Piece) + groups_.bytes() + chunks_.size() * kChunk * sizeof(Composed);
  for (const Piece& piece : pieces_) bytes += piece.groups.capacity() * sizeof(std::uint32_t);
  return bytes;
}

}  // namespace swiftlet
