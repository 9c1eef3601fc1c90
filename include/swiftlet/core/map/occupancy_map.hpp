// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/map/block_log.hpp"
#include "swiftlet/core/map/distance_tiles.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/map/ray_cells.hpp"
#include "swiftlet/core/map/submap_cells.hpp"
#include "swiftlet/core/time.hpp"

namespace swiftlet {

/// The model of OctoMap [Hornung 2013]; the defaults are its library's.
struct OccupancyMapConfig {
  double edge_m = 0.1;
  double p_hit = 0.7;
  double p_miss = 0.4;
  double p_occupied = 0.5;
  double p_min = 0.1192;
  double p_max = 0.971;
  double range_max_m = 20.0;
  double keep_radius_m = 30.0;
  double distance_max_m = 1.5;

  void visit(ConfigVisitor& v);
  /// What the map may need, about: all of its ball seen, a tenth of it near surfaces, distances asked for in a quarter.
  double bytes() const;
  /// Blocks that may be kept side by side.
  double places_across() const;
};

/// What is around a vehicle, cell for cell as OctoMap's library would have it after the same scans. Log-odds are in
/// single precision, the way from cell to cell is the library's, and each cell counts once a scan. Cells that were
/// never hit are counted by bits, 64 at a time: how often they were missed says all about them. Only cells that were
/// hit at some time have a number of their own. So a block of 512 cells of free space takes 320 bytes.
class OccupancyMap : public OccupancyView, private OccupiedBlocks {
 public:
  explicit OccupancyMap(const OccupancyMapConfig& config);

  /// One beam of a scan, in the local frame.
  struct Ray {
    Eigen::Vector3f origin_local_m;
    Eigen::Vector3f end_local_m;
    bool hit = true;  ///< false: nothing was met up to the end
  };

  /// One scan. A cell in which any ray ends is hit once; every other cell that a ray passes is missed once. A ray that
  /// is longer than range_max_m hits nothing and passes cells up to there, as the library has it. The library knows one
  /// origin a scan; here each ray has its own.
  void insert(std::span<const Ray> rays, TimeNs now);
  /// Forgets what lies farther than keep_radius_m from here.
  void keep_around(const Vector3& center_local_m);

  double edge_m() const override { return config_.edge_m; }
  CellState state(const Vector3& p_local_m) const override;
  void occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                       std::vector<Vector3>& centers_local_m) const override;
  void occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                   std::vector<Vector3>& centers_local_m) const override;
  double distance_m(const Vector3& p_local_m, double max_m) const override;
  double clearance_m(const Vector3& p_local_m, double max_m) const override;
  std::optional<SegmentHit> first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const override;
  std::uint64_t revision() const override { return revision_; }
  bool changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const override;
  void append_voxels(MapVoxels& copy) const override;

  /// What is known of a block, as `state` tells it; false: nothing.
  bool look_at(const Cell& block, CellBlock& states) const;
  /// All blocks. Cells count as occupied that are so with more than this probability, and as free below p_occupied.
  /// Those between are left out.
  std::vector<CellBlock> blocks_surer_than(double p) const;

  /// Of the cell with these coordinates; 0 when nothing is known of it.
  float log_odds(const Cell& cell) const;
  bool known(const Cell& cell) const;
  std::size_t num_blocks() const { return blocks_.size() - free_blocks_.size(); }

 private:
  static constexpr int kSide = RayCells::kSide;
  static constexpr int kCells = kSide * kSide * kSide;
  static constexpr int kMostMisses = 7;  // that are counted by bits
  using Bits = RayCells::Bits;
  /// Cells by bits: a word for each z, a byte for each y.
  struct alignas(64) Block {
    Bits misses_1{}, misses_2{}, misses_4{};  // of cells that were never hit, as binary numbers; 0: unknown
    Bits valued{};                            // cells whose log-odds stand in the page
    Bits occupied{};
  };
  struct Page {
    std::array<float, kCells> log_odds;
    std::array<std::uint32_t, kCells> scan;  // in which it was hit last
  };
  /// What one looks at without looking into a block.
  struct About {
    Cell at = Cell::Zero();
    std::uint32_t page = 0;  // counted from 1; 0: none
    bool used = false;
    std::uint64_t changed = 0;  // the revision in which a state changed last
  };
  /// Occupied cells of a block that came or went in the last scan, and which of them are occupied now.
  struct Touched {
    Cell at;
    Bits cells{}, occupied{};
  };
  /// What is remembered of a place in the table: when occupied cells came or went last, and what did so in the last
  /// scan.
  struct OccupiedChange {
    std::uint32_t revision = 0, touched = 0;  // counted from 1; 0: none
  };
  static constexpr std::size_t kChunk = 1024;  // blocks or pages that are allocated at once

  Cell cell_of(const Vector3& p_local_m) const { return (p_local_m.array() * cells_per_m_).floor().cast<int>(); }
  Vector3 center_of(const Cell& cell) const { return (cell.cast<double>().array() + 0.5) * config_.edge_m; }
  std::size_t place_of(const Cell& block) const;
  int find(const Cell& block) const;
  int find_or_make(const Cell& block);
  void forget(int block);
  Block& block(int i) { return chunks_[static_cast<std::size_t>(i) / kChunk][static_cast<std::size_t>(i) % kChunk]; }
  const Block& block(int i) const {
    return chunks_[static_cast<std::size_t>(i) / kChunk][static_cast<std::size_t>(i) % kChunk];
  }
  Page& page(std::uint32_t i) { return *pages_[i - 1]; }
  const Page& page(std::uint32_t i) const { return *pages_[i - 1]; }
  void note_occupied(int i);
  void note_touched(int i, int z, std::uint64_t cells);
  void give_page(int i);
  void miss(int i, const Bits& passed);
  void miss_valued(int i, int z, std::uint64_t cells);
  void give_values(int i, int z, std::uint64_t cells);
  void hit(const Cell& cell);
  int misses_of(const Block& block, int z, int bit) const;
  CellState state_of(const Cell& cell) const;
  const Bits* occupied_of(const Cell& block) const override;
  void append_changes(const Cell& low, const Cell& high, std::uint64_t since,
                      std::vector<Change>& changes) const override;
  /// fn(block, index of the cell in it, center) for every occupied cell of the blocks that reach into the box.
  template <class Fn>
  void for_occupied(const Vector3& min_local_m, const Vector3& max_local_m, Fn&& fn) const;

  OccupancyMapConfig config_;
  double cells_per_m_;
  float hit_, miss_, occupied_, min_, max_;            // log-odds
  std::array<float, kMostMisses + 1> after_misses_{};  // log-odds of a cell that was never hit
  int most_misses_ = 0;                                // more change nothing, or need a number
  RayCells rays_;
  int bits_ = 0, mask_ = 0;                       // of a block's coordinates in the table
  std::vector<std::int32_t> places_;              // block; -1: none
  std::vector<OccupiedChange> occupied_changes_;  // of a place
  std::vector<std::uint64_t> occupied_places_;    // a bit for each place whose block has an occupied cell
  std::vector<Touched> touched_;                  // in the last scan,
  std::uint64_t touched_after_ = 0;               // after this revision
  std::vector<std::unique_ptr<Block[]>> chunks_;
  std::vector<About> blocks_;
  std::vector<int> free_blocks_;
  std::vector<std::unique_ptr<Page>> pages_;
  std::vector<std::uint32_t> free_pages_;
  std::uint32_t scan_ = 0;
  std::uint64_t revision_ = 0;
  std::vector<TimeNs> scan_times_;  // of the last scans, in a ring
  BlockLog forgotten_;
  Vector3 kept_around_local_m_;
  mutable DistanceTiles distances_;
};

}  // namespace swiftlet
