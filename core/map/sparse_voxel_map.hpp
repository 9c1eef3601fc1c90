// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/map/voxel_grid.hpp"
#include "swiftlet/core/config.hpp"
#include "swiftlet/core/time.hpp"

namespace swiftlet {

/// How a sparse map remembers and forgets. `miss_log_odds` = 0 and `memory_s` = 0: it never forgets, the conservative
/// setting of 004, sec. 3.4, with which leaves stay in the map as ghosts.
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

/// What was seen around a vehicle, as occupied voxels in hashed blocks (the role of Bonxai in 004, sec. 3.2.4). Only
/// voxels that were hit at some time are stored. Everything comes out in the order of coordinates, so that results do
/// not depend on the hash.
class SparseVoxelMap {
 public:
  explicit SparseVoxelMap(const SparseVoxelMapConfig& config) : config_(config) {}

  /// One beam of a sweep, in the world.
  struct Ray {
    Eigen::Vector3f origin_m;
    Eigen::Vector3f end_m;
    bool hit = true;  ///< false: nothing was met up to the end
  };

  /// One sweep: of all rays that end in one voxel the first counts (the voxel-grid filter of 004, sec. 3.2.3). Voxels
  /// hit in this sweep gain, those that a ray passed through lose.
  void insert(std::span<const Ray> rays, TimeNs now);

  /// Forgets what lies farther than keep_radius_m from here.
  void keep_around(const Vector3& center_m);

  /// Centres of the occupied voxels whose nearest point lies within the radius; those not hit since `since` left out.
  void collect(const Vector3& center_m, double radius_m, TimeNs now, TimeNs since,
               std::vector<Vector3>& centers_m) const;
  bool is_occupied(const Vector3& p_m, TimeNs now) const;
  std::size_t num_blocks() const { return index_.size(); }
  double edge_m() const { return config_.edge_m; }

 private:
  static constexpr int kSide = 8;  // voxels along the edge of a block
  static constexpr int kVoxels = kSide * kSide * kSide;
  struct Voxel {
    float log_odds = 0.0F;
    std::uint32_t sweep = 0;   // in which it was hit last
    std::uint32_t passed = 0;  // in which it was passed through last
    TimeNs hit = 0;
  };
  struct Block {
    Cell at = Cell::Zero();
    std::bitset<kVoxels> known;  // voxels that were hit at some time
    std::array<Voxel, kVoxels> voxels;
  };
  struct CellHash {
    std::size_t operator()(std::uint64_t key) const { return (key * 0x9E3779B97F4A7C15ULL) >> 16; }
  };

  Cell cell_of(const Vector3& p_m) const { return (p_m.array() / config_.edge_m).floor().cast<int>(); }
  const Block* block_at(const Cell& block) const;
  Block* known_block(const Cell& block);
  Block& block_for(const Cell& block);
  bool occupied(const Voxel& voxel, TimeNs now) const;
  bool first_in_sweep(const Cell& cell);
  void pass(const Ray& ray);

  SparseVoxelMapConfig config_;
  std::vector<Block> blocks_;
  std::vector<std::uint32_t> free_;  // blocks to use again
  std::unordered_map<std::uint64_t, std::uint32_t, CellHash> index_;
  std::vector<std::uint64_t> ends_;  // voxels in which rays of this sweep ended: open addressing
  std::uint32_t sweep_ = 0;
};

}  // namespace swiftlet
