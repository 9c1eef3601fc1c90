// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/time.hpp"
#include "swiftlet/core/map/block_log.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// Memory of a sparse map. `miss_log_odds` = 0 and `memory_s` = 0 keep all voxels forever: the conservative setting of
/// Kamler 2025, sec. 3.4, in which moving leaves remain as false obstacles.
struct SparseVoxelMapConfig {
  double edge_m = 0.2;
  double hit_log_odds = 0.85;
  double miss_log_odds = 0.4;
  double occupied_log_odds = 0.8;
  double min_log_odds = -2.0;
  double max_log_odds = 3.5;
  double memory_s = 0.0;
  double clear_range_m = 8.0;
  double keep_radius_m = 25.0;

  void visit(ConfigVisitor& v);
};

/// Occupied voxels around a vehicle, in blocks (the role of Bonxai in [Kamler 2025, sec. 3.2.4]). Only voxels that were
/// hit are stored, and only within keep_radius_m of the vehicle. Blocks are addressed directly in a table that wraps
/// around beyond twice that radius.
class SparseVoxelMap : public OccupancyView {
 public:
  explicit SparseVoxelMap(const SparseVoxelMapConfig& config);

  /// One beam of a sweep, in the local frame.
  struct Ray {
    Eigen::Vector3f origin_local_m;
    Eigen::Vector3f end_local_m;
    bool hit = true;  ///< false: free up to the end
  };

  /// Inserts one sweep: of all rays that end in one voxel the first counts (the voxel-grid filter of Kamler 2025, sec.
  /// 3.2.3). The log-odds of hit voxels increase, those of voxels on a ray decrease.
  void insert(std::span<const Ray> rays, TimeNs now);

  /// Drops blocks farther than keep_radius_m from this position.
  void keep_around(const Vector3& center_local_m);

  /// Sets the time of later queries: voxels without a hit for memory_s no longer count as occupied.
  void set_time(TimeNs now);

  double edge_m() const override { return config_.edge_m; }
  /// kFree: the voxel was occupied, and is cleared by misses or older than memory_s.
  CellState state(const Vector3& p_local_m) const override;
  void occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                       std::vector<Vector3>& centers_local_m) const override;
  void occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                   std::vector<Vector3>& centers_local_m) const override;
  double distance_m(const Vector3& p_local_m, double max_m) const override;
  std::optional<SegmentHit> first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const override;
  std::uint64_t revision() const override { return revision_; }
  /// Boxes are blocks. False for a map with memory_s, and when the log of dropped blocks does not reach back far
  /// enough.
  bool changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const override;
  /// Values are log-odds.
  void append_voxels(MapVoxels& copy) const override;

  /// Memory of a map with an occupied voxel in every block within a radius.
  static double most_bytes(const SparseVoxelMapConfig& config, double radius_m);

  std::size_t num_blocks() const { return blocks_.size() - free_.size(); }

 private:
  static constexpr int kSide = 8;  // edge of a block in voxels
  static constexpr int kVoxels = kSide * kSide * kSide;
  struct Voxel {
    float log_odds = 0.0F;
    std::uint32_t sweep = 0;   // sweep of the last hit
    std::uint32_t passed = 0;  // sweep of the last pass
  };
  struct Block {
    Cell at = Cell::Zero();
    bool used = false;
    std::uint64_t changed = 0;               // revision of the last change of a voxel's state
    std::array<std::uint64_t, kSide> known;  // voxels that were ever hit: a word for each layer
    std::array<Voxel, kVoxels> voxels;
    bool is_known(int i) const { return (known[static_cast<std::size_t>(i) >> 6U] >> (i & 63) & 1U) != 0; }
  };

  Cell cell_of(const Vector3& p_local_m) const { return (p_local_m.array() * cells_per_m_).floor().cast<int>(); }
  std::size_t place_of(const Cell& block) const {
    return static_cast<std::size_t>((block.x() & mask_) | ((block.y() & mask_) | (block.z() & mask_) << bits_)
                                                              << bits_);
  }
  const Block* block_at(const Cell& block) const {
    const std::uint32_t place = places_[place_of(block)];
    if (place == 0) return nullptr;
    const Block& there = blocks_[place - 1];
    return there.at == block ? &there : nullptr;
  }
  Block& block_for(const Cell& block);
  bool occupied(const Voxel& voxel) const { return voxel.log_odds >= threshold_ && voxel.sweep >= remembered_; }
  /// First sweep at or after a time.
  std::uint32_t sweep_at(TimeNs t) const;
  CellState state_of(const Cell& cell) const;
  Vector3 center_of(const Cell& cell) const { return (cell.cast<double>().array() + 0.5) * config_.edge_m; }
  /// Calls fn(voxel, center) for every occupied voxel of the blocks that overlap the box.
  template <class Fn>
  void for_occupied(const Vector3& min_local_m, const Vector3& max_local_m, Fn&& fn) const;
  bool first_in_sweep(const Cell& cell);
  void pass(const Ray& ray);

  SparseVoxelMapConfig config_;
  double cells_per_m_;
  float threshold_;                    // log-odds from which a voxel is occupied
  int bits_ = 0, mask_ = 0;            // bits and mask of a block coordinate in the table
  std::vector<std::uint32_t> places_;  // block index + 1; 0: none
  std::vector<Block> blocks_;
  std::vector<std::uint32_t> free_;  // blocks for reuse
  std::vector<const Ray*> passing_;  // scratch: rays of this sweep that clear voxels
  std::vector<std::uint64_t> ends_;  // end voxels of rays without a hit; open addressing
  std::uint32_t sweep_ = 0;
  std::vector<TimeNs> times_;     // times of the sweeps, from 1 on, ascending
  std::uint32_t remembered_ = 0;  // first sweep within memory_s
  std::uint64_t revision_ = 0;
  BlockLog removed_;
};

}  // namespace swiftlet
