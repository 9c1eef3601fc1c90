// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/map/block_log.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/time.hpp"

namespace swiftlet {

/// How a sparse map remembers and forgets. `miss_log_odds` = 0 and `memory_s` = 0: it never forgets, the conservative
/// setting of Kamler 2025, sec. 3.4, with which leaves stay in the map as ghosts.
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

/// What was seen around a vehicle, as occupied voxels in blocks (the role of Bonxai in [Kamler 2025, sec. 3.2.4]). Only
/// voxels that were hit at some time are stored, and only within keep_radius_m of the vehicle. A block is found without
/// searching, in a table of places that repeats itself beyond twice that radius.
class SparseVoxelMap : public OccupancyView {
 public:
  explicit SparseVoxelMap(const SparseVoxelMapConfig& config);

  /// One beam of a sweep, in the local frame.
  struct Ray {
    Eigen::Vector3f origin_local_m;
    Eigen::Vector3f end_local_m;
    bool hit = true;  ///< false: nothing was met up to the end
  };

  /// One sweep: of all rays that end in one voxel the first counts (the voxel-grid filter of Kamler 2025, sec. 3.2.3).
  /// Voxels hit in this sweep gain, those that a ray passed through lose.
  void insert(std::span<const Ray> rays, TimeNs now);

  /// Forgets what lies farther than keep_radius_m from here.
  void keep_around(const Vector3& center_local_m);

  /// For what is asked from now on: voxels not hit for memory_s are forgotten.
  void set_time(TimeNs now);

  double edge_m() const override { return config_.edge_m; }
  /// Free: it was hit at some time and lost it again.
  CellState state(const Vector3& p_local_m) const override;
  void occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                       std::vector<Vector3>& centers_local_m) const override;
  void occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                   std::vector<Vector3>& centers_local_m) const override;
  double distance_m(const Vector3& p_local_m, double max_m) const override;
  std::optional<SegmentHit> first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const override;
  std::uint64_t revision() const override { return revision_; }
  /// By blocks. Not known of a map that forgets by time, and of what lies too many forgotten blocks back.
  bool changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const override;
  /// Values are log-odds.
  void append_voxels(MapVoxels& copy) const override;

  /// What a map takes that has seen something in every block within a radius.
  static double most_bytes(const SparseVoxelMapConfig& config, double radius_m);

  std::size_t num_blocks() const { return blocks_.size() - free_.size(); }

 private:
  static constexpr int kSide = 8;  // voxels along the edge of a block
  static constexpr int kVoxels = kSide * kSide * kSide;
  struct Voxel {
    float log_odds = 0.0F;
    std::uint32_t sweep = 0;   // in which it was hit last
    std::uint32_t passed = 0;  // in which it was passed through last
  };
  struct Block {
    Cell at = Cell::Zero();
    bool used = false;
    std::uint64_t changed = 0;               // the revision in which a voxel's state changed last
    std::array<std::uint64_t, kSide> known;  // voxels that were hit at some time: a word a layer
    std::array<Voxel, kVoxels> voxels;
    bool knows(int i) const { return (known[static_cast<std::size_t>(i) >> 6U] >> (i & 63) & 1U) != 0; }
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
  /// The first sweep at or after a time.
  std::uint32_t sweep_at(TimeNs t) const;
  CellState state_of(const Cell& cell) const;
  Vector3 center_of(const Cell& cell) const { return (cell.cast<double>().array() + 0.5) * config_.edge_m; }
  /// fn(voxel, its center) for every occupied one of the blocks that reach into the box.
  template <class Fn>
  void for_occupied(const Vector3& min_local_m, const Vector3& max_local_m, Fn&& fn) const;
  bool first_in_sweep(const Cell& cell);
  void pass(const Ray& ray);

  SparseVoxelMapConfig config_;
  double cells_per_m_;
  float threshold_;                    // of log-odds: occupied
  int bits_ = 0, mask_ = 0;            // of a block's coordinates in the table
  std::vector<std::uint32_t> places_;  // block, counted from 1; 0: none
  std::vector<Block> blocks_;
  std::vector<std::uint32_t> free_;  // blocks to use again
  std::vector<const Ray*> passing_;  // of this sweep: those that take away
  std::vector<std::uint64_t> ends_;  // voxels in which rays without a hit ended: open addressing
  std::uint32_t sweep_ = 0;
  std::vector<TimeNs> times_;     // of the sweeps, from 1 on, ascending
  std::uint32_t remembered_ = 0;  // the first sweep that is
  std::uint64_t revision_ = 0;
  BlockLog forgotten_;
};

}  // namespace swiftlet
