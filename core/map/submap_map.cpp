// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/submap_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

#include "core/map/cell_hash.hpp"
#include "core/map/cell_walk.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

constexpr double kSnap = 0.25;            // grid of the poses, as a share of a cell
constexpr double kRounding = 1e-6;        // margin for rounding, in cells
constexpr double kWholeCell = 1U << 24U;  // fixed-point units per cell

bool any_in(const RayCells::Bits& bits) {
  return std::any_of(bits.begin(), bits.end(), [](std::uint64_t word) { return word != 0; });
}

bool is_lattice_m(double p_m, double step_m, int& steps) {
  const double count = std::round(p_m / step_m);
  steps = static_cast<int>(count);
  return std::abs(p_m - count * step_m) < kRounding * step_m;
}

/// Votes of pieces on the cells of a block, from the newest piece on. A cell is decided when a piece reports it
/// occupied, or when outvoted_by pieces in a row report it free. Older pieces no longer matter for it.
class Votes {
 public:
  explicit Votes(int outvoted_by) : outvoted_by_(outvoted_by) { open_.fill(~std::uint64_t{0}); }

  void take(const RayCells::Bits& occupied, const RayCells::Bits& free) {
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
  const RayCells::Bits& open() const { return open_; }
  void result(RayCells::Bits& occupied, RayCells::Bits& free) const {
    occupied = occupied_;
    for (std::size_t z = 0; z < free.size(); ++z) free[z] = known_[z] & ~occupied_[z];
  }

 private:
  int outvoted_by_;
  RayCells::Bits open_{}, known_{}, occupied_{}, ones_{}, twos_{};
};

const RayCells::Bits kAllCells = [] {
  RayCells::Bits all;
  all.fill(~std::uint64_t{0});
  return all;
}();

}  // namespace

SubmapMap::SubmapMap(const SubmapMapConfig& config)
    : config_(config),
      cells_per_m_(1.0 / config.edge_m),
      group_slots_(1024, 0),
      distances_(static_cast<int>(std::ceil(config.distance_max_m / config.edge_m))) {
  ENSURE(config.outvoted_by >= 0 && config.outvoted_by <= 3, config.outvoted_by);
}

// Pieces

int SubmapMap::add(std::shared_ptr<const SubmapCells> cells, const Pose& T_local_cells, int age, TimeNs seen) {
  ENSURE(cells != nullptr);
  std::uint32_t i = static_cast<std::uint32_t>(pieces_.size());
  if (free_pieces_.empty()) {
    pieces_.emplace_back();
  } else {
    i = free_pieces_.back();
    free_pieces_.pop_back();
  }
  Piece& piece = pieces_[i];
  piece.cells = std::move(cells);
  piece.age = age;
  piece.number = ++num_added_;
  piece.seen = seen;
  ++num_pieces_;
  ++revision_;
  piece.middle_cells_m = piece.cells->middle_m();
  piece.reach_m = piece.cells->reach_m();
  place(i, snapped(piece, T_local_cells));
  return static_cast<int>(i);
}

bool SubmapMap::move(int i, const Pose& T_local_cells) {
  Piece& piece = pieces_[static_cast<std::size_t>(i)];
  ENSURE(piece.cells != nullptr, i);
  const Pose T = snapped(piece, T_local_cells);
  if (T.matrix() == piece.T_local_cells.matrix()) return false;
  ++revision_;
  ++num_moved_;
  displace(static_cast<std::uint32_t>(i));
  place(static_cast<std::uint32_t>(i), T);
  return true;
}

void SubmapMap::remove(int i) {
  ENSURE(pieces_[static_cast<std::size_t>(i)].cells != nullptr, i);
  ++revision_;
  displace(static_cast<std::uint32_t>(i));
  pieces_[static_cast<std::size_t>(i)] = {};
  free_pieces_.push_back(static_cast<std::uint32_t>(i));
  --num_pieces_;
}

/// Depends on the pose alone, not on earlier poses.
Pose SubmapMap::snapped(const Piece& piece, const Pose& T_local_cells) const {
  const double step_m = kSnap * config_.edge_m, step = 0.5 * step_m / std::max(piece.reach_m, step_m);
  Eigen::Quaterniond q(T_local_cells.linear());
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  // A rotation is about twice the change of the quaternion.
  for (int i = 0; i < 4; ++i) q.coeffs()[i] = step * std::round(q.coeffs()[i] / step);
  Vector3 middle_local_m = T_local_cells * piece.middle_cells_m;
  for (int axis = 0; axis < 3; ++axis) middle_local_m[axis] = step_m * std::round(middle_local_m[axis] / step_m);
  Pose T = Pose::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = middle_local_m - T.linear() * piece.middle_cells_m;
  return T;
}

void SubmapMap::place(std::uint32_t i, const Pose& T_local_cells) {
  Piece& piece = pieces_[i];
  const SubmapCells& cells = *piece.cells;
  piece.T_local_cells = T_local_cells;
  const Matrix3 R_back = T_local_cells.linear().transpose();
  piece.M = R_back * (config_.edge_m / cells.edge_m());
  piece.M_back = T_local_cells.linear() * (cells.edge_m() / config_.edge_m);
  piece.o_cells = -(R_back * T_local_cells.translation()) / cells.edge_m();
  piece.aligned = cells.edge_m() == config_.edge_m && T_local_cells.linear() == Matrix3::Identity();
  for (int axis = 0; axis < 3; ++axis) {
    int blocks = 0;
    const bool fits = is_lattice_m(T_local_cells.translation()[axis], kSide * config_.edge_m, blocks);
    piece.aligned = piece.aligned && fits;
    piece.offset_blocks[axis] = blocks;
  }
  // Every group of the map that a group of the piece overlaps.
  constexpr double kCells = kSide * kGroup;
  const Vector3 half = (0.5 * kCells) * (piece.M_back.cwiseAbs() * Vector3::Ones()).array() + kRounding;
  for (const Cell& group : cells.groups()) {
    const Vector3 middle =
        piece.M_back * (kCells * (group.cast<double>().array() + 0.5) - piece.o_cells.array()).matrix();
    const Cell low = ((middle - half) / kCells).array().floor().cast<int>();
    const Cell high = ((middle + half) / kCells).array().floor().cast<int>();
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) piece.groups.push_back(find_or_make_group({x, y, z}));
      }
    }
  }
  std::sort(piece.groups.begin(), piece.groups.end());
  piece.groups.erase(std::unique(piece.groups.begin(), piece.groups.end()), piece.groups.end());
  for (const std::uint32_t g : piece.groups) {
    Group& group = *groups_[g];
    group.moved = revision_;
    group.pieces.insert(std::upper_bound(group.pieces.begin(), group.pieces.end(), i,
                                         [this](std::uint32_t a, std::uint32_t b) { return is_older(a, b); }),
                        i);
  }
}

bool SubmapMap::is_older(std::uint32_t a, std::uint32_t b) const {
  return std::pair(pieces_[a].age, pieces_[a].number) < std::pair(pieces_[b].age, pieces_[b].number);
}

void SubmapMap::displace(std::uint32_t i) {
  for (const std::uint32_t g : pieces_[i].groups) {
    groups_[g]->moved = revision_;
    std::erase(groups_[g]->pieces, i);
  }
  pieces_[i].groups.clear();
}

void SubmapMap::replace(int i, std::shared_ptr<const SubmapCells> cells) {
  Piece& piece = pieces_[static_cast<std::size_t>(i)];
  ENSURE(piece.cells != nullptr && cells != nullptr, i);
  ++revision_;
  displace(static_cast<std::uint32_t>(i));
  piece.cells = std::move(cells);
  place(static_cast<std::uint32_t>(i), Pose(piece.T_local_cells));
}

void SubmapMap::set_growing(const OccupancyMap* growing, const Cell& offset_blocks) {
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

void SubmapMap::note_grown(std::uint64_t since) {
  ENSURE(growing_->changed_since(since, grown_), since);
  for (const VoxelGrid& box : grown_) {
    const Cell block = block_of(box.min_cell) + growing_offset_blocks_;
    groups_[find_or_make_group(group_of(block))]->slots[slot_in_group(block)].changed = revision_;
  }
}

// Groups

std::size_t SubmapMap::group_slot(const Cell& group) const {
  std::size_t slot = first_slot(group, group_slots_.size());
  while (group_slots_[slot] != 0 && groups_[group_slots_[slot] - 1]->at != group) {
    slot = (slot + 1) & (group_slots_.size() - 1);
  }
  return slot;
}

SubmapMap::Group* SubmapMap::find_group(const Cell& group) const {
  if (last_group_ != nullptr && last_group_->at == group) return last_group_;
  const std::uint32_t place = group_slots_[group_slot(group)];
  if (place == 0) return nullptr;
  return last_group_ = groups_[place - 1].get();
}

std::uint32_t SubmapMap::find_or_make_group(const Cell& group) {
  std::size_t slot = group_slot(group);
  if (group_slots_[slot] != 0) return group_slots_[slot] - 1;
  if (2 * (groups_.size() + 1) > group_slots_.size()) {
    group_slots_.assign(2 * group_slots_.size(), 0);
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      group_slots_[group_slot(groups_[i]->at)] = static_cast<std::uint32_t>(i + 1);
    }
    slot = group_slot(group);
  }
  groups_.push_back(std::make_unique<Group>());
  groups_.back()->at = group;
  group_slots_[slot] = static_cast<std::uint32_t>(groups_.size());
  return group_slots_[slot] - 1;
}

// Composition of blocks

bool SubmapMap::look(const Piece& piece, const Cell& block, Bits& occupied, Bits& free) const {
  return look(piece, block, kAllCells, occupied, free);
}

bool SubmapMap::look(const Piece& piece, const Cell& block, const Bits& wanted, Bits& occupied, Bits& free) const {
  if (!piece.aligned) return look_turned(piece, block, wanted, occupied, free);
  const int i = piece.cells->find(block - piece.offset_blocks);
  if (i < 0) return false;
  const Bits* its_occupied = piece.cells->occupied_of(i);
  occupied = its_occupied != nullptr ? *its_occupied : Bits{};
  free = piece.cells->free_of(i);
  return true;
}

bool SubmapMap::look_turned(const Piece& piece, const Cell& block, const Bits& wanted, Bits& occupied,
                            Bits& free) const {
  const SubmapCells& cells = *piece.cells;
  // Blocks of the piece around this block.
  const Vector3 first = (kSide * block).cast<double>();
  const Vector3 middle = piece.M * (first.array() + 0.5 * kSide).matrix() + piece.o_cells;
  const Vector3 half = (0.5 * kSide) * (piece.M.cwiseAbs() * Vector3::Ones()).array() + kRounding;
  const Cell low = ((middle - half) / kSide).array().floor().cast<int>();
  const Cell size = ((middle + half) / kSide).array().floor().cast<int>().matrix() - low + Cell::Ones();
  near_.clear();
  bool any = false, any_occupied = false;
  for (int z = 0; z < size.z(); ++z) {
    for (int y = 0; y < size.y(); ++y) {
      for (int x = 0; x < size.x(); ++x) {
        near_.push_back(cells.find(low + Cell(x, y, z)));
        any = any || near_.back() >= 0;
        any_occupied = any_occupied || (near_.back() >= 0 && cells.occupied_of(near_.back()) != nullptr);
      }
    }
  }
  if (!any) return false;
  occupied.fill(0);
  free.fill(0);
  // States of the piece at the centers of the block's cells.
  const Vector3 from = piece.M * (first.array() + 0.5).matrix() + piece.o_cells - (kSide * low).cast<double>();
  const auto whole = [](double x) { return static_cast<std::int64_t>(std::floor(x * kWholeCell)); };
  const std::int64_t dx = whole(piece.M(0, 0)), dy = whole(piece.M(1, 0)), dz = whole(piece.M(2, 0));
  for (int z = 0; z < kSide; ++z) {
    std::uint64_t layer_occupied = 0, layer_free = 0;
    const std::uint64_t layer_wanted = wanted[static_cast<std::size_t>(z)];
    for (int y = 0; y < kSide; ++y) {
      if ((layer_wanted >> (kSide * y) & 0xFFU) == 0) continue;
      const Vector3 row = from + y * piece.M.col(1) + z * piece.M.col(2);
      std::int64_t px = whole(row.x()), py = whole(row.y()), pz = whole(row.z());
      for (int x = 0; x < kSide; ++x, px += dx, py += dy, pz += dz) {
        const int cx = static_cast<int>(px >> 24), cy = static_cast<int>(py >> 24), cz = static_cast<int>(pz >> 24);
        const int i = near_[static_cast<std::size_t>(((cz >> 3) * size.y() + (cy >> 3)) * size.x() + (cx >> 3))];
        if (i < 0) continue;
        const int word = cz & 7, bit = (cy & 7) << 3 | (cx & 7), to = y << 3 | x;
        layer_free |= (cells.free_of(i)[static_cast<std::size_t>(word)] >> bit & 1U) << to;
        if (const Bits* its = cells.occupied_of(i); its != nullptr) {
          layer_occupied |= ((*its)[static_cast<std::size_t>(word)] >> bit & 1U) << to;
        }
      }
    }
    occupied[static_cast<std::size_t>(z)] = layer_occupied;
    free[static_cast<std::size_t>(z)] = layer_free;
  }
  if (!any_occupied) return true;
  // Occupied cells of the piece whose centers lie in the block: thin structure may lie between the centers sampled
  // above.
  std::size_t next = 0;
  for (int z = 0; z < size.z(); ++z) {
    for (int y = 0; y < size.y(); ++y) {
      for (int x = 0; x < size.x(); ++x, ++next) {
        const Bits* its = near_[next] >= 0 ? cells.occupied_of(near_[next]) : nullptr;
        if (its == nullptr) continue;
        const Vector3 corner = (kSide * (low + Cell(x, y, z))).cast<double>() - piece.o_cells;
        for (int layer = 0; layer < kSide; ++layer) {
          for (std::uint64_t left = (*its)[static_cast<std::size_t>(layer)]; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            const Vector3 center = corner + Vector3((bit & 7) + 0.5, (bit >> 3) + 0.5, layer + 0.5);
            const Cell to = (piece.M_back * center - first).array().floor().cast<int>();
            if ((to.array() < 0).any() || (to.array() >= kSide).any()) continue;
            occupied[static_cast<std::size_t>(to.z())] |= std::uint64_t{1} << (to.y() << 3 | to.x());
          }
        }
      }
    }
  }
  for (std::size_t z = 0; z < free.size(); ++z) free[z] &= ~occupied[z];
  return true;
}

bool SubmapMap::look_growing(const Cell& block, Bits& occupied, Bits& free) const {
  CellBlock states;
  if (growing_ == nullptr || !growing_->look_at(block - growing_offset_blocks_, states)) return false;
  occupied = states.occupied;
  free = states.free;
  return true;
}

void SubmapMap::compose(const Group& group, const Cell& block, std::uint32_t but, Composed& made) const {
  Votes votes(config_.outvoted_by);
  Bits occupied, free;
  if (look_growing(block, occupied, free)) votes.take(occupied, free);
  for (auto i = group.pieces.rbegin(); i != group.pieces.rend() && any_in(votes.open()); ++i) {
    if (*i != but && look(pieces_[*i], block, votes.open(), occupied, free)) votes.take(occupied, free);
  }
  votes.result(made.occupied, made.free);
}

const SubmapMap::Composed* SubmapMap::composed(const Cell& block) const {
  Group* group = find_group(group_of(block));
  return group != nullptr ? composed(*group, block) : nullptr;
}

const SubmapMap::Composed* SubmapMap::composed(Group& group, const Cell& block) const {
  Slot& slot = group.slots[slot_in_group(block)];
  const auto at = [this](std::int32_t i) {
    const auto place = static_cast<std::size_t>(i);
    return &chunks_[place / kChunk][place % kChunk];
  };
  if (slot.composed < std::max(slot.changed, group.moved)) {
    slot.composed = revision_;
    Composed made;
    ++num_composed_;
    compose(group, block, kAll, made);
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

// Queries

CellState SubmapMap::state(const Vector3& p_local_m) const { return state_of(cell_of(p_local_m)); }

CellState SubmapMap::state_of(const Cell& cell) const {
  const Composed* block = composed(block_of(cell));
  if (block == nullptr) return CellState::kUnknown;
  const int in_block = index_in_block(cell);
  const auto has = [&](const Bits& bits) {
    return (bits[static_cast<std::size_t>(in_block >> 6)] >> (in_block & 63) & 1U) != 0;
  };
  if (has(block->occupied)) return CellState::kOccupied;
  return has(block->free) ? CellState::kFree : CellState::kUnknown;
}

const RayCells::Bits* SubmapMap::occupied_of(const Cell& block) const {
  Group* group = find_group(group_of(block));
  if (group == nullptr) return nullptr;
  const Composed* made = composed(*group, block);
  return made != nullptr && group->slots[slot_in_group(block)].any_occupied ? &made->occupied : nullptr;
}

// Changes name whole blocks: the changed cells are unknown until the block is composed again.
void SubmapMap::append_changes(const Cell& low, const Cell& high, std::uint64_t since,
                               std::vector<Change>& changes) const {
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const Cell block(x, y, z);
        const Group* group = find_group(group_of(block));
        if (group == nullptr) continue;
        if (std::max(group->moved, group->slots[slot_in_group(block)].changed) <= since) continue;
        changes.push_back({block, nullptr, nullptr});
      }
    }
  }
}

template <class Fn>
void SubmapMap::for_occupied_blocks(const Vector3& min_local_m, const Vector3& max_local_m, Fn&& fn) const {
  const Cell low = block_of(cell_of(min_local_m)), high = block_of(cell_of(max_local_m));
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        if (const Bits* occupied = occupied_of({x, y, z}); occupied != nullptr) fn(Cell(x, y, z), *occupied);
      }
    }
  }
}

template <class Fn>
void SubmapMap::for_occupied(const Vector3& min_local_m, const Vector3& max_local_m, Fn&& fn) const {
  for_occupied_blocks(min_local_m, max_local_m, [&](const Cell& block, const Bits& occupied) {
    for (int layer = 0; layer < kSide; ++layer) {
      for (std::uint64_t left = occupied[static_cast<std::size_t>(layer)]; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        fn(center_of(kSide * block + Cell(bit & 7, bit >> 3, layer)));
      }
    }
  });
}

void SubmapMap::occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                                std::vector<Vector3>& centers_local_m) const {
  centers_local_m.clear();
  const double reach_m = radius_m + config_.edge_m, half_m = 0.5 * config_.edge_m;
  const Vector3 low_local_m = center_local_m.array() - reach_m, high_local_m = center_local_m.array() + reach_m;
  const auto is_near = [&](const Vector3& cell_local_m) {
    const Vector3 gap = ((cell_local_m - center_local_m).array().abs() - half_m).cwiseMax(0.0);
    return gap.squaredNorm() <= radius_m * radius_m;
  };
  if (since == kEver) {
    for_occupied(low_local_m, high_local_m, [&](const Vector3& cell_local_m) {
      if (is_near(cell_local_m)) centers_local_m.push_back(cell_local_m);
    });
    return;
  }
  std::vector<Vector3> fresh_m;  // in the frame of the growing piece
  const Vector3 offset_m = (kSide * config_.edge_m) * growing_offset_blocks_.cast<double>();
  if (growing_ != nullptr) growing_->occupied_within(center_local_m - offset_m, radius_m, since, fresh_m);
  std::vector<Cell> fresh;
  for (const Vector3& p_m : fresh_m) fresh.push_back(cell_of(p_m + offset_m));
  const auto comes_before = [](const Cell& a, const Cell& b) {
    return std::tie(a.z(), a.y(), a.x()) < std::tie(b.z(), b.y(), b.x());
  };
  std::sort(fresh.begin(), fresh.end(), comes_before);
  for_occupied_blocks(low_local_m, high_local_m, [&](const Cell& block, const Bits& all) {
    Bits recent{}, occupied, free;
    for (const std::uint32_t i : find_group(group_of(block))->pieces) {
      if (pieces_[i].seen < since || !look(pieces_[i], block, occupied, free)) continue;
      for (std::size_t z = 0; z < recent.size(); ++z) recent[z] |= occupied[z];
    }
    for (int layer = 0; layer < kSide; ++layer) {
      for (std::uint64_t left = all[static_cast<std::size_t>(layer)]; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        const Cell cell = kSide * block + Cell(bit & 7, bit >> 3, layer);
        const bool counts = (recent[static_cast<std::size_t>(layer)] >> bit & 1U) != 0 ||
                            std::binary_search(fresh.begin(), fresh.end(), cell, comes_before);
        if (counts && is_near(center_of(cell))) centers_local_m.push_back(center_of(cell));
      }
    }
  });
}

void SubmapMap::occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                            std::vector<Vector3>& centers_local_m) const {
  centers_local_m.clear();
  const double half_m = 0.5 * config_.edge_m;
  for_occupied(min_local_m, max_local_m, [&](const Vector3& cell_local_m) {
    const bool above = (cell_local_m.array() + half_m >= min_local_m.array()).all();
    if (above && (cell_local_m.array() - half_m <= max_local_m.array()).all()) centers_local_m.push_back(cell_local_m);
  });
}

double SubmapMap::distance_m(const Vector3& p_local_m, double max_m) const {
  double least_sq = max_m * max_m;
  const double half_m = 0.5 * config_.edge_m;
  for_occupied(p_local_m.array() - max_m, p_local_m.array() + max_m, [&](const Vector3& cell_local_m) {
    const Vector3 gap = ((cell_local_m - p_local_m).array().abs() - half_m).cwiseMax(0.0);
    least_sq = std::min(least_sq, gap.squaredNorm());
  });
  return std::sqrt(least_sq);
}

double SubmapMap::clearance_m(const Vector3& p_local_m, double max_m) const {
  const std::int16_t squared = distances_.squared(cell_of(p_local_m), *this, revision_);
  if (squared != DistanceTiles::kFar) return std::min(max_m, std::sqrt(static_cast<double>(squared)) * config_.edge_m);
  return max_m <= config_.distance_max_m ? max_m : OccupancyView::clearance_m(p_local_m, max_m);
}

std::optional<SegmentHit> SubmapMap::first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const {
  Cell cell;
  const double hit_distance_m = distance_to_first_m(from_local_m, to_local_m, cells_per_m_, cell, [&](const Cell& at) {
    return state_of(at) == CellState::kOccupied;
  });
  if (hit_distance_m < 0.0) return std::nullopt;
  return SegmentHit{hit_distance_m, center_of(cell)};
}

bool SubmapMap::changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const {
  boxes.clear();
  for (const auto& group : groups_) {
    const Cell first = kSide * kGroup * group->at;
    if (group->moved > revision) {
      boxes.push_back({config_.edge_m, first, Cell::Constant(kSide * kGroup)});
      continue;
    }
    for (int i = 0; i < static_cast<int>(group->slots.size()); ++i) {
      if (group->slots[static_cast<std::size_t>(i)].changed <= revision) continue;
      boxes.push_back({config_.edge_m, first + kSide * Cell(i & 3, i >> 2 & 3, i >> 4), Cell::Constant(kSide)});
    }
  }
  return true;
}

void SubmapMap::append_voxels(MapVoxels& copy) const {
  copy.edge_m = config_.edge_m;
  copy.states = {"free", "occupied"};
  copy.occupied_from = 1;
  for (const auto& group : groups_) {
    for (int i = 0; i < static_cast<int>(group->slots.size()); ++i) {
      const Cell block = kGroup * group->at + Cell(i & 3, i >> 2 & 3, i >> 4);
      const Composed* made = composed(*group, block);
      if (made == nullptr) continue;
      for (int in_block = 0; in_block < kSide * kSide * kSide; ++in_block) {
        const Cell cell = kSide * block + Cell(in_block & 7, in_block >> 3 & 7, in_block >> 6);
        const auto has = [&](const Bits& bits) {
          return (bits[static_cast<std::size_t>(in_block >> 6)] >> (in_block & 63) & 1U) != 0;
        };
        if (has(made->occupied)) copy.add(center_of(cell), 1, 1.0F);
        if (has(made->free)) copy.add(center_of(cell), 0, 0.0F);
      }
    }
  }
}

void SubmapMap::append_blocks(std::vector<CellBlock>& blocks) const {
  for (const auto& group : groups_) {
    for (int i = 0; i < static_cast<int>(group->slots.size()); ++i) {
      const Cell block = kGroup * group->at + Cell(i & 3, i >> 2 & 3, i >> 4);
      const Composed* made = composed(*group, block);
      if (made != nullptr) blocks.push_back({block, made->occupied, made->free});
    }
  }
}

void SubmapMap::append_occupied(std::vector<Vector3>& centers_local_m) const {
  for (const auto& group : groups_) {
    const Vector3 low_local_m = kSide * kGroup * config_.edge_m * group->at.cast<double>();
    const Vector3 inside_m = Vector3::Constant(0.5 * config_.edge_m);
    const Vector3 size_m = Vector3::Constant(kSide * kGroup * config_.edge_m);
    for_occupied(low_local_m + inside_m, low_local_m + size_m - inside_m,
                 [&](const Vector3& cell_local_m) { centers_local_m.push_back(cell_local_m); });
  }
}

double SubmapMap::share_known_by_newer(int i, int every) const {
  const auto self = static_cast<std::uint32_t>(i);
  const Piece& piece = pieces_[self];
  ENSURE(piece.cells != nullptr && every > 0, i, every);
  const SubmapCells& cells = *piece.cells;
  std::size_t num = 0, num_known = 0, next = 0;
  Bits occupied, free;
  for (const std::uint32_t g : piece.groups) {
    const Group& group = *groups_[g];
    const auto self_at = std::find(group.pieces.begin(), group.pieces.end(), self);
    for (int slot = 0; slot < static_cast<int>(group.slots.size()); ++slot) {
      const Cell block = kGroup * group.at + Cell(slot & 3, slot >> 2 & 3, slot >> 4);
      if (next++ % static_cast<std::size_t>(every) != 0 || !look(piece, block, occupied, free)) continue;
      Bits known{}, own;
      for (std::size_t z = 0; z < own.size(); ++z) own[z] = occupied[z] | free[z];
      for (auto newer = self_at + 1; newer != group.pieces.end(); ++newer) {
        if (!look(pieces_[*newer], block, occupied, free)) continue;
        for (std::size_t z = 0; z < known.size(); ++z) known[z] |= occupied[z] | free[z];
      }
      for (std::size_t z = 0; z < own.size(); ++z) {
        num += static_cast<std::size_t>(std::popcount(own[z]));
        num_known += static_cast<std::size_t>(std::popcount(own[z] & known[z]));
      }
    }
  }
  return num == 0 ? (cells.empty() ? 1.0 : 0.0) : static_cast<double>(num_known) / static_cast<double>(num);
}

std::shared_ptr<const SubmapCells> SubmapMap::needed_of(int i) const {
  const auto self = static_cast<std::uint32_t>(i);
  const Piece& piece = pieces_[self];
  ENSURE(piece.cells != nullptr, i);
  const SubmapCells& cells = *piece.cells;
  std::vector<CellBlock> kept(cells.num_blocks());
  for (int b = 0; b < static_cast<int>(kept.size()); ++b) kept[static_cast<std::size_t>(b)].at = cells.at(b);
  const auto keep = [&](const Cell& cell) {
    const int b = cells.find(block_of(cell));
    if (b < 0) return;
    const int in_block = index_in_block(cell);
    const auto z = static_cast<std::size_t>(in_block >> 6);
    const std::uint64_t bit = std::uint64_t{1} << (in_block & 63);
    kept[static_cast<std::size_t>(b)].free[z] |= cells.free_of(b)[z] & bit;
    if (const Bits* its = cells.occupied_of(b); its != nullptr) {
      kept[static_cast<std::size_t>(b)].occupied[z] |= (*its)[z] & bit;
    }
  };
  // Keeps the piece's cell at the center of the map's cell, and those whose centers lie in it.
  const Vector3 half = 0.5 * (piece.M.cwiseAbs() * Vector3::Ones()).array() + kRounding;
  const auto keep_for = [&](const Cell& cell) {
    const Vector3 middle = piece.M * (cell.cast<double>().array() + 0.5).matrix() + piece.o_cells;
    keep(middle.array().floor().cast<int>());
    const Cell low = (middle - half).array().floor().cast<int>(), high = (middle + half).array().floor().cast<int>();
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          const Vector3 center(x + 0.5, y + 0.5, z + 0.5);
          const Cell to = (piece.M_back * (center - piece.o_cells)).array().floor().cast<int>();
          if (to == cell) keep({x, y, z});
        }
      }
    }
  };
  Composed all, without;
  Bits occupied, free;
  for (const std::uint32_t g : piece.groups) {
    const Group& group = *groups_[g];
    for (int slot = 0; slot < static_cast<int>(group.slots.size()); ++slot) {
      const Cell block = kGroup * group.at + Cell(slot & 3, slot >> 2 & 3, slot >> 4);
      if (!look(piece, block, occupied, free)) continue;
      const Composed* made = composed(*groups_[g], block);
      all = made != nullptr ? *made : Composed{};
      compose(group, block, self, without);
      for (int z = 0; z < kSide; ++z) {
        const auto word = static_cast<std::size_t>(z);
        std::uint64_t left = (all.occupied[word] ^ without.occupied[word]) | (all.free[word] ^ without.free[word]);
        for (; left != 0; left &= left - 1) {
          const int bit = std::countr_zero(left);
          keep_for(kSide * block + Cell(bit & 7, bit >> 3, z));
        }
      }
    }
  }
  return std::make_shared<const SubmapCells>(cells.edge_m(), kept);
}

std::size_t SubmapMap::bytes() const {
  std::size_t bytes = sizeof *this + pieces_.capacity() * sizeof(Piece) + groups_.size() * sizeof(Group) +
                      group_slots_.capacity() * sizeof(std::uint32_t) + chunks_.size() * kChunk * sizeof(Composed);
  for (const Piece& piece : pieces_) bytes += piece.groups.capacity() * sizeof(std::uint32_t);
  for (const auto& group : groups_) bytes += group->pieces.capacity() * sizeof(std::uint32_t);
  constexpr std::size_t kTile = 1100;
  return bytes + distances_.num_tiles() * kTile;
}

}  // namespace swiftlet
