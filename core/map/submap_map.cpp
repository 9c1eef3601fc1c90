// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/submap_map.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

#include "core/map/cell_walk.hpp"
#include "core/map/composed_blocks.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

class MapOfPieces final : public ComposedBlocks {
 public:
  explicit MapOfPieces(const SubmapMapConfig& config)
      : ComposedBlocks(config.edge_m, config.distance_max_m, config.outvoted_by) {}

  void occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                       std::vector<Vector3>& centers_local_m) const override;
  bool changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const override;
  void append_voxels(MapVoxels& copy) const override;
  void append_blocks(std::vector<CellBlock>& blocks) const override;
  void append_occupied(std::vector<Vector3>& centers_local_m) const override;

  double share_known_by_newer(int piece, int every) const override;
  std::shared_ptr<const SubmapCells> needed_of(int piece) const override;
  std::size_t bytes() const override;

 private:
  /// Calls fn(block, its cells) for every block with known cells.
  template <class Fn>
  void for_known_blocks(Fn&& fn) const;
};

void MapOfPieces::occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                                  std::vector<Vector3>& centers_local_m) const {
  centers_local_m.clear();
  std::vector<Vector3> fresh_m;  // in the frame of the growing piece
  const Vector3 offset_m = (kSide * edge_m_) * growing_offset_blocks_.cast<double>();
  if (growing_ != nullptr && since != kEver) {
    growing_->occupied_within(center_local_m - offset_m, radius_m, since, fresh_m);
  }
  std::vector<Cell> fresh;
  for (const Vector3& p_m : fresh_m) fresh.push_back(cell_of(p_m + offset_m));
  const auto comes_before = [](const Cell& a, const Cell& b) {
    return std::tie(a.z(), a.y(), a.x()) < std::tie(b.z(), b.y(), b.x());
  };
  std::sort(fresh.begin(), fresh.end(), comes_before);
  const auto add_block = [&](const Cell& block, const Bits& all) {
    Bits recent{}, occupied, free;
    for (const std::uint32_t i : groups_.find(BlockGroup::of(block))->pieces) {
      if (since == kEver || piece(i).seen < since || !look(piece(i), block, occupied, free)) continue;
      for (std::size_t z = 0; z < recent.size(); ++z) recent[z] |= occupied[z];
    }
    for_cells(all, [&](int in_block) {
      const Cell cell = cell_in(block, in_block);
      const bool counts =
          since == kEver || has(recent, in_block) || std::binary_search(fresh.begin(), fresh.end(), cell, comes_before);
      if (counts && overlaps_ball(center_of(cell), center_local_m, radius_m))
        centers_local_m.push_back(center_of(cell));
    });
  };
  const double reach_m = radius_m + edge_m_;
  for_occupied_blocks(center_local_m.array() - reach_m, center_local_m.array() + reach_m, add_block);
}

bool MapOfPieces::changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const {
  boxes.clear();
  for (const auto& group : groups_) {
    if (group->moved > revision) {
      boxes.push_back({edge_m_, SubmapCells::kGroup_cells * group->at, Cell::Constant(SubmapCells::kGroup_cells)});
      continue;
    }
    for (int i = 0; i < group->num_slots(); ++i) {
      if (group->slots[static_cast<std::size_t>(i)].changed <= revision) continue;
      boxes.push_back({edge_m_, kSide * group->block_of(i), Cell::Constant(kSide)});
    }
  }
  return true;
}

template <class Fn>
void MapOfPieces::for_known_blocks(Fn&& fn) const {
  for (const auto& group : groups_) {
    for (int i = 0; i < group->num_slots(); ++i) {
      const Cell block = group->block_of(i);
      const Composed* made = composed(*group, block);
      if (made != nullptr) fn(block, *made);
    }
  }
}

void MapOfPieces::append_voxels(MapVoxels& copy) const {
  copy.edge_m = edge_m_;
  copy.states = {"free", "occupied"};
  copy.occupied_from = 1;
  for_known_blocks([&](const Cell& block, const Composed& made) {
    for (int in_block = 0; in_block < kSide * kSide * kSide; ++in_block) {
      const Vector3 center_local_m = center_of(cell_in(block, in_block));
      if (has(made.occupied, in_block)) copy.add(center_local_m, 1, 1.0F);
      if (has(made.free, in_block)) copy.add(center_local_m, 0, 0.0F);
    }
  });
}

void MapOfPieces::append_blocks(std::vector<CellBlock>& blocks) const {
  for_known_blocks([&](const Cell& block, const Composed& made) {
    blocks.push_back({block, made.occupied, made.free});
  });
}

void MapOfPieces::append_occupied(std::vector<Vector3>& centers_local_m) const {
  for (const auto& group : groups_) {
    const Vector3 low_local_m = SubmapCells::kGroup_cells * edge_m_ * group->at.cast<double>();
    const Vector3 inside_m = Vector3::Constant(0.5 * edge_m_);
    const Vector3 size_m = Vector3::Constant(SubmapCells::kGroup_cells * edge_m_);
    for_occupied(low_local_m + inside_m, low_local_m + size_m - inside_m,
                 [&](const Vector3& cell_local_m) { centers_local_m.push_back(cell_local_m); });
  }
}

double MapOfPieces::share_known_by_newer(int i, int every) const {
  const auto self = static_cast<std::uint32_t>(i);
  ENSURE(every > 0, every);
  std::size_t num = 0, num_known = 0, next = 0;
  Bits occupied, free;
  for (const std::uint32_t g : piece(self).groups) {
    const BlockGroup& group = groups_[g];
    const auto self_at = std::find(group.pieces.begin(), group.pieces.end(), self);
    for (int slot = 0; slot < group.num_slots(); ++slot) {
      const Cell block = group.block_of(slot);
      if (next++ % static_cast<std::size_t>(every) != 0 || !look(piece(self), block, occupied, free)) continue;
      Bits known{}, own;
      for (std::size_t z = 0; z < own.size(); ++z) own[z] = occupied[z] | free[z];
      for (auto newer = self_at + 1; newer != group.pieces.end(); ++newer) {
        if (!look(piece(*newer), block, occupied, free)) continue;
        for (std::size_t z = 0; z < known.size(); ++z) known[z] |= occupied[z] | free[z];
      }
      for (std::size_t z = 0; z < own.size(); ++z) {
        num += static_cast<std::size_t>(std::popcount(own[z]));
        num_known += static_cast<std::size_t>(std::popcount(own[z] & known[z]));
      }
    }
  }
  return num == 0 ? (cells(i).empty() ? 1.0 : 0.0) : static_cast<double>(num_known) / static_cast<double>(num);
}

std::shared_ptr<const SubmapCells> MapOfPieces::needed_of(int i) const {
  const auto self = static_cast<std::uint32_t>(i);
  const Piece& own = piece(self);
  const SubmapCells& cells = own.placed.cells();
  std::vector<CellBlock> kept(cells.num_blocks());
  for (int b = 0; b < static_cast<int>(kept.size()); ++b) kept[static_cast<std::size_t>(b)].at = cells.at(b);
  const auto keep = [&](const Cell& cell) {
    const int b = cells.find(block_of(cell));
    if (b < 0) return;
    const int in_block = index_in_block(cell);
    const auto z = static_cast<std::size_t>(in_block >> 6);
    const std::uint64_t bit = std::uint64_t{1} << (in_block & 63);
    CellBlock& block = kept[static_cast<std::size_t>(b)];
    block.free[z] |= cells.free_of(b)[z] & bit;
    if (const Bits* its = cells.occupied_of(b); its != nullptr) block.occupied[z] |= (*its)[z] & bit;
  };
  Composed without;
  Bits occupied, free;
  std::vector<Cell> deciding;
  for (const std::uint32_t g : own.groups) {
    for (int slot = 0; slot < groups_[g].num_slots(); ++slot) {
      const Cell block = groups_[g].block_of(slot);
      if (!look(own, block, occupied, free)) continue;
      const Composed* made = composed(groups_[g], block);
      const Composed all = made != nullptr ? *made : Composed{};
      compose(groups_[g], block, self, without);
      Bits differs;
      for (std::size_t z = 0; z < differs.size(); ++z) {
        differs[z] = (all.occupied[z] ^ without.occupied[z]) | (all.free[z] ^ without.free[z]);
      }
      deciding.clear();
      for_cells(differs, [&](int in_block) { own.placed.append_deciding(cell_in(block, in_block), deciding); });
      for (const Cell& cell : deciding) keep(cell);
    }
  }
  return std::make_shared<const SubmapCells>(cells.edge_m(), kept);
}

std::size_t MapOfPieces::bytes() const {
  return sizeof *this + bytes_of_blocks() + distances_.num_tiles() * DistanceTiles::kTileBytes;
}

}  // namespace

std::unique_ptr<SubmapMap> make_submap_map(const SubmapMapConfig& config) {
  return std::make_unique<MapOfPieces>(config);
}

}  // namespace swiftlet
