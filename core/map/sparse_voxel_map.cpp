// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/sparse_voxel_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/map/cell_walk.hpp"

namespace swiftlet {
namespace {

constexpr int kMostPlaceBits = 7;  // limits the table to 8 MB

/// Bits per axis of the table, for the blocks within the radius of a vehicle between two blocks, and those partly
/// beyond it.
int place_bits(double keep_radius_m, double block_m) {
  const double across = 2.0 * keep_radius_m / block_m + 4.0;
  int bits = 0;
  while (bits < kMostPlaceBits && (1 << bits) < across) ++bits;
  return bits;
}
// Marks a free slot of the table of ray ends; no key of a cell has all bits set.
constexpr std::uint64_t kEmptySlot = std::numeric_limits<std::uint64_t>::max();

std::uint64_t key_of(const Cell& cell) {
  constexpr std::uint64_t kMask = (1ULL << 21U) - 1U;  // +-1 million cells per axis
  const auto part = [](int c) { return static_cast<std::uint64_t>(c + (1 << 20)) & kMask; };
  return part(cell.x()) | part(cell.y()) << 21U | part(cell.z()) << 42U;
}

}  // namespace

SparseVoxelMap::SparseVoxelMap(const SparseVoxelMapConfig& config)
    : config_(config), cells_per_m_(1.0 / config.edge_m), threshold_(static_cast<float>(config.occupied_log_odds)) {
  bits_ = place_bits(config.keep_radius_m, kSide * config.edge_m);
  mask_ = (1 << bits_) - 1;
  places_.assign(std::size_t{1} << 3 * bits_, 0U);
}

double SparseVoxelMap::most_bytes(const SparseVoxelMapConfig& config, double radius_m) {
  const double block_m = kSide * config.edge_m;
  const auto places = static_cast<double>(std::size_t{1} << 3 * place_bits(config.keep_radius_m, block_m));
  // A block stays while its center is within the radius; in one step the vehicle may move by a block.
  const double radius_blocks = std::min(radius_m, config.keep_radius_m) / block_m + 1.0;
  const double blocks = std::min(places, 4.0 / 3.0 * std::numbers::pi * radius_blocks * radius_blocks * radius_blocks);
  return places * sizeof(std::uint32_t) + blocks * sizeof(Block);
}

SparseVoxelMap::Block& SparseVoxelMap::block_for(const Cell& block) {
  std::uint32_t& place = places_[place_of(block)];
  if (place != 0 && blocks_[place - 1].at == block) return blocks_[place - 1];
  // A block in the same slot lies beyond the kept radius.
  if (place != 0) removed_.note(revision_, blocks_[place - 1].at);
  if (place == 0 && !free_.empty()) {
    place = free_.back();
    free_.pop_back();
  } else if (place == 0) {
    blocks_.emplace_back();
    place = static_cast<std::uint32_t>(blocks_.size());
  }
  Block& fresh = blocks_[place - 1];
  fresh.at = block;
  fresh.used = true;
  fresh.changed = 0;
  fresh.known.fill(0);
  fresh.voxels.fill({});
  return fresh;
}

std::uint32_t SparseVoxelMap::sweep_at(TimeNs t) const {
  const auto first = std::lower_bound(times_.begin(), times_.end(), t);
  return static_cast<std::uint32_t>(first - times_.begin()) + 1;
}

void SparseVoxelMap::set_time(TimeNs now) {
  if (config_.memory_s > 0.0) remembered_ = sweep_at(now - from_seconds(config_.memory_s));
}

bool SparseVoxelMap::first_in_sweep(const Cell& cell) {
  const std::uint64_t key = key_of(cell);
  const std::size_t mask = ends_.size() - 1;
  std::size_t slot = (key * 0x9E3779B97F4A7C15ULL >> 16U) & mask;
  while (ends_[slot] != kEmptySlot) {
    if (ends_[slot] == key) return false;
    slot = (slot + 1) & mask;
  }
  ends_[slot] = key;
  return true;
}

void SparseVoxelMap::insert(std::span<const Ray> rays, TimeNs now) {
  ++sweep_;
  ++revision_;
  times_.push_back(times_.empty() ? now : std::max(now, times_.back()));
  passing_.clear();
  ends_.assign(std::max(std::bit_ceil(2 * rays.size() + 1), ends_.size()), kEmptySlot);
  const auto keep_sq = static_cast<float>(config_.keep_radius_m * config_.keep_radius_m);
  // Hits come first, so that no ray clears what another ray has just hit.
  for (const Ray& ray : rays) {
    const Cell cell = cell_of(ray.end_local_m.cast<double>());
    if (!ray.hit || (ray.end_local_m - ray.origin_local_m).squaredNorm() > keep_sq) {
      if (first_in_sweep(cell)) passing_.push_back(&ray);
      continue;
    }
    Block& block = block_for(block_of(cell));
    const int i = index_in_block(cell);
    Voxel& voxel = block.voxels[i];
    if (voxel.sweep == sweep_) continue;
    const bool was_occupied = voxel.log_odds >= threshold_;
    if (!block.is_known(i)) block.changed = revision_;
    block.known[static_cast<std::size_t>(i) >> 6U] |= std::uint64_t{1} << (i & 63);
    voxel.log_odds =
        std::min(voxel.log_odds + static_cast<float>(config_.hit_log_odds), static_cast<float>(config_.max_log_odds));
    if (was_occupied != (voxel.log_odds >= threshold_)) block.changed = revision_;
    voxel.sweep = sweep_;
    passing_.push_back(&ray);
  }
  if (config_.miss_log_odds <= 0.0) return;
  for (const Ray* ray : passing_) pass(*ray);
}

// Lowers voxels from the origin to the end or to the clearing range; only stored voxels can lose.
void SparseVoxelMap::pass(const Ray& ray) {
  const Vector3 origin = ray.origin_local_m.cast<double>() * cells_per_m_;
  const Vector3 displacement = (ray.end_local_m - ray.origin_local_m).cast<double>();
  const double length_m = displacement.norm();
  if (!(length_m > 0.0)) return;
  const Vector3 direction = displacement / length_m;
  // Returns scatter about a surface by up to half a voxel: that part is not cleared.
  const double end =
      (std::min(length_m, config_.clear_range_m) - (ray.hit ? 0.5 * config_.edge_m : 0.0)) * cells_per_m_;
  CellWalk walk(origin, direction);
  auto& [cell, step, next, per_cell] = walk;
  const auto loss = static_cast<float>(config_.miss_log_odds), least = static_cast<float>(config_.min_log_odds);
  for (double traveled = 0.0; traveled < end;) {
    auto* const block = const_cast<Block*>(block_at(block_of(cell)));
    if (block == nullptr) {  // skips to where the ray leaves the block
      int last[3];           // steps to its last voxel
      double leaves[3];
      for (int axis = 0; axis < 3; ++axis) {
        last[axis] = step[axis] > 0 ? kSide - 1 - (cell[axis] & 7) : cell[axis] & 7;
        leaves[axis] = last[axis] == 0 ? next[axis] : next[axis] + last[axis] * per_cell[axis];
      }
      const int out = leaves[0] < leaves[1] ? (leaves[0] < leaves[2] ? 0 : 2) : (leaves[1] < leaves[2] ? 1 : 2);
      traveled = leaves[out];
      for (int axis = 0; axis < 3; ++axis) {
        if (axis != out && !(next[axis] < traveled)) continue;
        const int steps =
            axis == out
                ? last[axis] + 1
                : std::min(last[axis], 1 + static_cast<int>((traveled - next[axis]) * std::abs(direction[axis])));
        next[axis] += steps * per_cell[axis];
        cell[axis] += steps * step[axis];
      }
      continue;
    }
    int axis = 0, from = 0;
    do {
      const int i = index_in_block(cell);
      Voxel& voxel = block->voxels[i];
      if (block->is_known(i) && voxel.sweep != sweep_ && voxel.passed != sweep_) {
        voxel.passed = sweep_;
        const bool was_occupied = voxel.log_odds >= threshold_;
        voxel.log_odds = std::max(voxel.log_odds - loss, least);
        if (was_occupied && voxel.log_odds < threshold_) block->changed = revision_;
      }
      axis = walk.next_axis();
      traveled = next[axis];
      next[axis] += per_cell[axis];
      from = cell[axis];
      cell[axis] += step[axis];
    } while (traveled < end && from >> 3 == cell[axis] >> 3);
  }
}

void SparseVoxelMap::keep_around(const Vector3& center_local_m) {
  const double block_m = kSide * config_.edge_m;
  bool removes = false;
  for (Block& block : blocks_) {
    if (!block.used) continue;
    const Vector3 middle_local_m = (block.at.cast<double>().array() + 0.5) * block_m;
    if ((middle_local_m - center_local_m).norm() <= config_.keep_radius_m) continue;
    block.used = false;
    free_.push_back(std::exchange(places_[place_of(block.at)], 0U));
    if (!removes) ++revision_;
    removes = true;
    removed_.note(revision_, block.at);
  }
}

template <class Fn>
void SparseVoxelMap::for_occupied(const Vector3& min_local_m, const Vector3& max_local_m, Fn&& fn) const {
  const Cell low = block_of(cell_of(min_local_m)), high = block_of(cell_of(max_local_m));
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const Block* block = block_at({x, y, z});
        if (block == nullptr) continue;
        for (int layer = 0; layer < kSide; ++layer) {
          for (std::uint64_t known = block->known[layer]; known != 0; known &= known - 1) {
            const int i = layer << 6 | std::countr_zero(known);
            if (!occupied(block->voxels[i])) continue;
            fn(block->voxels[i], center_of({x * kSide + (i & 7), y * kSide + ((i >> 3) & 7), z * kSide + layer}));
          }
        }
      }
    }
  }
}

void SparseVoxelMap::occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                                     std::vector<Vector3>& centers_local_m) const {
  centers_local_m.clear();
  const double reach_m = radius_m + config_.edge_m, half_m = 0.5 * config_.edge_m;
  const std::uint32_t first = sweep_at(since);
  for_occupied(center_local_m.array() - reach_m, center_local_m.array() + reach_m,
               [&](const Voxel& voxel, const Vector3& voxel_local_m) {
                 if (voxel.sweep < first) return;
                 const Vector3 gap = ((voxel_local_m - center_local_m).array().abs() - half_m).cwiseMax(0.0);
                 if (gap.squaredNorm() <= radius_m * radius_m) centers_local_m.push_back(voxel_local_m);
               });
}

void SparseVoxelMap::occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                                 std::vector<Vector3>& centers_local_m) const {
  centers_local_m.clear();
  const double half_m = 0.5 * config_.edge_m;
  for_occupied(min_local_m, max_local_m, [&](const Voxel&, const Vector3& voxel_local_m) {
    const bool above = (voxel_local_m.array() + half_m >= min_local_m.array()).all();
    if (above && (voxel_local_m.array() - half_m <= max_local_m.array()).all())
      centers_local_m.push_back(voxel_local_m);
  });
}

double SparseVoxelMap::distance_m(const Vector3& p_local_m, double max_m) const {
  double least_sq = max_m * max_m;
  const double half_m = 0.5 * config_.edge_m;
  for_occupied(p_local_m.array() - max_m, p_local_m.array() + max_m, [&](const Voxel&, const Vector3& voxel_local_m) {
    const Vector3 gap = ((voxel_local_m - p_local_m).array().abs() - half_m).cwiseMax(0.0);
    least_sq = std::min(least_sq, gap.squaredNorm());
  });
  return std::sqrt(least_sq);
}

std::optional<SegmentHit> SparseVoxelMap::first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const {
  Cell cell;
  const double hit_distance_m = distance_to_first_m(from_local_m, to_local_m, cells_per_m_, cell, [&](const Cell& at) {
    return state_of(at) == CellState::kOccupied;
  });
  if (hit_distance_m < 0.0) return std::nullopt;
  return SegmentHit{hit_distance_m, center_of(cell)};
}

bool SparseVoxelMap::changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const {
  boxes.clear();
  if (config_.memory_s > 0.0) return false;
  if (!removed_.covers(revision)) return false;
  const auto add = [&](const Cell& block) { boxes.push_back({config_.edge_m, block * kSide, Cell::Constant(kSide)}); };
  for (const Block& block : blocks_) {
    if (block.used && block.changed > revision) add(block.at);
  }
  removed_.for_each_since(revision, add);
  return true;
}

void SparseVoxelMap::append_voxels(MapVoxels& copy) const {
  copy.edge_m = config_.edge_m;
  copy.states = {"free", "occupied"};
  copy.occupied_from = 1;
  for (const Block& block : blocks_) {
    if (!block.used) continue;
    for (int i = 0; i < kVoxels; ++i) {
      if (!block.is_known(i)) continue;
      const Cell at = kSide * block.at + Cell(i & 7, (i >> 3) & 7, i >> 6);
      copy.add(center_of(at), occupied(block.voxels[i]) ? 1 : 0, block.voxels[i].log_odds);
    }
  }
}

CellState SparseVoxelMap::state(const Vector3& p_local_m) const { return state_of(cell_of(p_local_m)); }

CellState SparseVoxelMap::state_of(const Cell& cell) const {
  const Block* block = block_at(block_of(cell));
  const int i = index_in_block(cell);
  if (block == nullptr || !block->is_known(i)) return CellState::kUnknown;
  return occupied(block->voxels[i]) ? CellState::kOccupied : CellState::kFree;
}

void SparseVoxelMapConfig::visit(ConfigVisitor& v) {
  v.field("edge_m", edge_m, "[m] edge of a voxel", Range::between(0.01, 100.0));
  v.field("hit_log_odds", hit_log_odds, "[-] gain per sweep of a voxel in which a ray ended", Range::positive());
  v.field("miss_log_odds", miss_log_odds,
          "[-] loss per sweep of a voxel that rays passed; 0: never cleared, the conservative setting of Kamler 2025",
          Range::non_negative());
  v.field("occupied_log_odds", occupied_log_odds, "[-] log-odds from which a voxel counts as an obstacle");
  v.field("min_log_odds", min_log_odds, "[-] lower limit of a voxel's log-odds");
  v.field("max_log_odds", max_log_odds, "[-] upper limit of a voxel's log-odds");
  v.field("memory_s", memory_s, "[s] time since its last hit after which a voxel is dropped; 0: never",
          Range::non_negative());
  v.field("clear_range_m", clear_range_m, "[m] length up to which rays clear", Range{0.0, 1000.0, true});
  v.field("keep_radius_m", keep_radius_m, "[m] voxels farther from the vehicle are dropped", Range{0.0, 1e5, true});
  v.check(keep_radius_m <= 480.0 * edge_m, "keep_radius_m", "at most 480 times edge_m");
  v.check(max_log_odds > min_log_odds, "max_log_odds", "more than min_log_odds");
  v.check(occupied_log_odds <= max_log_odds, "occupied_log_odds", "at most max_log_odds");
}

}  // namespace swiftlet
