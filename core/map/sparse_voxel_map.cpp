// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/sparse_voxel_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace swiftlet {
namespace {

constexpr std::uint64_t kNobody = std::numeric_limits<std::uint64_t>::max();

std::uint64_t key_of(const Cell& cell) {
  constexpr std::uint64_t kMask = (1ULL << 21U) - 1U;  // +-1 million cells by axis
  const auto part = [](int c) { return static_cast<std::uint64_t>(c + (1 << 20)) & kMask; };
  return part(cell.x()) | part(cell.y()) << 21U | part(cell.z()) << 42U;
}

// Blocks are 8 voxels wide.
Cell block_of(const Cell& cell) { return {cell.x() >> 3, cell.y() >> 3, cell.z() >> 3}; }

int index_in_block(const Cell& cell) { return (cell.x() & 7) | (cell.y() & 7) << 3 | (cell.z() & 7) << 6; }

}  // namespace

const SparseVoxelMap::Block* SparseVoxelMap::block_at(const Cell& block) const {
  const auto found = index_.find(key_of(block));
  return found == index_.end() ? nullptr : &blocks_[found->second];
}

SparseVoxelMap::Block* SparseVoxelMap::known_block(const Cell& block) {
  const auto found = index_.find(key_of(block));
  return found == index_.end() ? nullptr : &blocks_[found->second];
}

SparseVoxelMap::Block& SparseVoxelMap::block_for(const Cell& block) {
  const auto [entry, is_new] = index_.try_emplace(key_of(block), 0U);
  if (!is_new) return blocks_[entry->second];
  if (free_.empty()) {
    entry->second = static_cast<std::uint32_t>(blocks_.size());
    blocks_.emplace_back();
  } else {
    entry->second = free_.back();
    free_.pop_back();
  }
  Block& fresh = blocks_[entry->second];
  fresh.at = block;
  fresh.known.reset();
  fresh.voxels.fill({});
  return fresh;
}

bool SparseVoxelMap::occupied(const Voxel& voxel, TimeNs now) const {
  return voxel.log_odds >= static_cast<float>(config_.occupied_log_odds) &&
         (config_.memory_s <= 0.0 || now - voxel.hit <= from_seconds(config_.memory_s));
}

bool SparseVoxelMap::first_in_sweep(const Cell& cell) {
  const std::uint64_t key = key_of(cell);
  const std::size_t mask = ends_.size() - 1;
  std::size_t slot = CellHash{}(key)&mask;
  while (ends_[slot] != kNobody) {
    if (ends_[slot] == key) return false;
    slot = (slot + 1) & mask;
  }
  ends_[slot] = key;
  return true;
}

void SparseVoxelMap::insert(std::span<const Ray> rays, TimeNs now) {
  ++sweep_;
  // First all hits, so that no ray takes away what another one has just seen.
  for (const Ray& ray : rays) {
    if (!ray.hit) continue;
    const Cell cell = cell_of(ray.end_m.cast<double>());
    Block& block = block_for(block_of(cell));
    const int i = index_in_block(cell);
    Voxel& voxel = block.voxels[i];
    if (block.known[i] && voxel.sweep == sweep_) continue;
    block.known.set(i);
    voxel.log_odds =
        std::min(voxel.log_odds + static_cast<float>(config_.hit_log_odds), static_cast<float>(config_.max_log_odds));
    voxel.sweep = sweep_;
    voxel.hit = now;
  }
  if (config_.miss_log_odds <= 0.0) return;
  std::size_t slots = 1024;
  while (slots < 2 * rays.size()) slots *= 2;
  ends_.assign(std::max(slots, ends_.size()), kNobody);
  for (const Ray& ray : rays) {
    if (first_in_sweep(cell_of(ray.end_m.cast<double>()))) pass(ray);
  }
}

// Amanatides and Woo, from the origin to the end or to the clearing range; only voxels that are stored can lose.
void SparseVoxelMap::pass(const Ray& ray) {
  const Vector3 origin = ray.origin_m.cast<double>() / config_.edge_m;
  const Vector3 way = (ray.end_m - ray.origin_m).cast<double>();
  const double length_m = way.norm();
  if (!(length_m > 0.0)) return;
  const Vector3 direction = way / length_m;
  // The last half voxel before a surface is its own roughness.
  const double end =
      (std::min(length_m, config_.clear_range_m) - (ray.hit ? 0.5 * config_.edge_m : 0.0)) / config_.edge_m;
  Cell cell = origin.array().floor().cast<int>();
  Vector3 next, per_cell;
  Cell step;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = direction[axis];
    step[axis] = d > 0.0 ? 1 : -1;
    per_cell[axis] = d == 0.0 ? std::numeric_limits<double>::infinity() : std::abs(1.0 / d);
    const double to_wall = d > 0.0 ? cell[axis] + 1.0 - origin[axis] : origin[axis] - cell[axis];
    next[axis] = d == 0.0 ? per_cell[axis] : to_wall * per_cell[axis];
  }
  Cell block_cell = block_of(cell);
  Block* block = known_block(block_cell);
  for (double travelled = 0.0; travelled < end;) {
    if (block != nullptr) {
      const int i = index_in_block(cell);
      Voxel& voxel = block->voxels[i];
      if (block->known[i] && voxel.sweep != sweep_ && voxel.passed != sweep_) {
        voxel.passed = sweep_;
        voxel.log_odds = std::max(voxel.log_odds - static_cast<float>(config_.miss_log_odds),
                                  static_cast<float>(config_.min_log_odds));
      }
    }
    int axis = 0;
    travelled = next.minCoeff(&axis);
    next[axis] += per_cell[axis];
    cell[axis] += step[axis];
    const Cell now_in = block_of(cell);
    if (now_in != block_cell) {
      block_cell = now_in;
      block = known_block(block_cell);
    }
  }
}

void SparseVoxelMap::keep_around(const Vector3& center_m) {
  const double block_m = kSide * config_.edge_m;
  for (std::uint32_t i = 0; i < blocks_.size(); ++i) {
    Block& block = blocks_[i];
    const Vector3 middle_m = (block.at.cast<double>().array() + 0.5) * block_m;
    if ((middle_m - center_m).norm() <= config_.keep_radius_m) continue;
    const auto entry = index_.find(key_of(block.at));
    if (entry == index_.end() || entry->second != i) continue;  // already given back
    index_.erase(entry);
    free_.push_back(i);
  }
}

void SparseVoxelMap::collect(const Vector3& center_m, double radius_m, TimeNs now, TimeNs since,
                             std::vector<Vector3>& centers_m) const {
  centers_m.clear();
  const double reach_m = radius_m + config_.edge_m;
  const Cell low = block_of(cell_of(center_m.array() - reach_m));
  const Cell high = block_of(cell_of(center_m.array() + reach_m));
  const double half_m = 0.5 * config_.edge_m;
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const Block* block = block_at({x, y, z});
        if (block == nullptr || block->known.none()) continue;
        for (int i = 0; i < kVoxels; ++i) {
          if (!block->known[i]) continue;
          const Voxel& voxel = block->voxels[i];
          if (voxel.hit < since || !occupied(voxel, now)) continue;
          const Cell cell(x * kSide + (i & 7), y * kSide + ((i >> 3) & 7), z * kSide + (i >> 6));
          const Vector3 voxel_m = (cell.cast<double>().array() + 0.5) * config_.edge_m;
          const Vector3 gap = ((voxel_m - center_m).array().abs() - half_m).cwiseMax(0.0);
          if (gap.squaredNorm() <= radius_m * radius_m) centers_m.push_back(voxel_m);
        }
      }
    }
  }
}

bool SparseVoxelMap::is_occupied(const Vector3& p_m, TimeNs now) const {
  const Cell cell = cell_of(p_m);
  const Block* block = block_at(block_of(cell));
  const int i = index_in_block(cell);
  return block != nullptr && block->known[i] && occupied(block->voxels[i], now);
}

void SparseVoxelMapConfig::visit(ConfigVisitor& v) {
  v.field("edge_m", edge_m, "[m] edge of a voxel", Range::positive());
  v.field("hit_log_odds", hit_log_odds, "[-] gain of a voxel in which a ray ended, once a sweep", Range::positive());
  v.field(
      "miss_log_odds", miss_log_odds,
      "[-] loss of a voxel that rays passed through, once a sweep; 0: never cleared, the conservative setting of 004",
      Range::non_negative());
  v.field("occupied_log_odds", occupied_log_odds, "[-] from here on a voxel counts as an obstacle");
  v.field("min_log_odds", min_log_odds, "[-] no voxel falls below");
  v.field("max_log_odds", max_log_odds, "[-] no voxel rises above");
  v.field("memory_s", memory_s, "[s] a voxel that was not hit for this long is forgotten; 0: never",
          Range::non_negative());
  v.field("clear_range_m", clear_range_m, "[m] rays clear up to here", Range::positive());
  v.field("keep_radius_m", keep_radius_m, "[m] what is farther from the vehicle is forgotten", Range::positive());
  v.check(max_log_odds > min_log_odds, "max_log_odds", "more than min_log_odds");
  v.check(occupied_log_odds <= max_log_odds, "occupied_log_odds", "at most max_log_odds");
}

}  // namespace swiftlet
