// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/time.hpp"
#include "swiftlet/core/map/block_log.hpp"
#include "swiftlet/core/map/distance_tiles.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"
#include "swiftlet/core/map/ray_cells.hpp"
#include "swiftlet/core/map/submap_cells.hpp"

namespace swiftlet {

/// Sensor model of OctoMap [Hornung 2013]; the defaults are its library's.
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
  /// Estimated memory: the whole ball observed, a tenth of it near surfaces, distances requested in a quarter.
  double bytes() const;
  /// Capacity of the block table along an axis.
  double places_across() const;
};

/// Occupancy map around a vehicle, identical cell by cell to OctoMap's library after the same scans. Log-odds are in
/// single precision, rays are traversed as in the library, and each cell is updated once per scan. For cells that were
/// never hit, the number of misses determines the log-odds; it is counted in bit planes, 64 cells at a time. Only cells
/// that were hit store a value. So a block of 512 cells of free space takes 320 bytes.
class OccupancyMap : public OccupancyView, private OccupiedBlocks {
 public:
  explicit OccupancyMap(const OccupancyMapConfig& config);

  /// One beam of a scan, in the local frame.
  struct Ray {
    Eigen::Vector3f origin_local_m;
    Eigen::Vector3f end_local_m;
    bool hit = true;  ///< false: free up to the end
  };

  /// Inserts one scan. A cell in which any ray ends is hit once; every other cell on a ray is missed once. A ray longer
  /// than range_max_m hits nothing and clears cells up to that range, as in the library. The library has one origin per
  /// scan; here each ray has its own.
  void insert(std::span<const Ray> rays, TimeNs now);
  /// Drops blocks farther than keep_radius_m from this position.
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

  /// Copies the states of a block; false: all its cells are unknown.
  bool look_at(const Cell& block, CellBlock& states) const;
  /// All blocks. Cells count as occupied above this probability, and as free below p_occupied; those between are
  /// omitted.
  std::vector<CellBlock> blocks_above(double p) const;

  /// Log-odds of the cell with these coordinates; 0 when it is unknown.
  float log_odds(const Cell& cell) const;
  bool known(const Cell& cell) const;
  std::size_t num_blocks() const { return blocks_.size() - free_blocks_.size(); }

 private:
  static constexpr int kSide = RayCells::kSide;
  static constexpr int kCells = kSide * kSide * kSide;
  static constexpr int kMostMisses = 7;  // largest number of misses that is counted in bits
  using Bits = RayCells::Bits;
  /// Bit sets of cells: a word for each z, a byte for each y.
  struct alignas(64) Block {
    Bits misses_1{}, misses_2{}, misses_4{};  // miss count of cells that were never hit, as binary number; 0: unknown
    Bits valued{};                            // cells with log-odds in the page
    Bits occupied{};
  };
  struct Page {
    std::array<float, kCells> log_odds;
    std::array<std::uint32_t, kCells> scan;  // scan of the last hit
  };
  /// Properties of a block that are used without access to it.
  struct About {
    Cell at = Cell::Zero();
    std::uint32_t page = 0;  // index + 1; 0: none
    bool used = false;
    std::uint64_t changed = 0;  // revision of the last change of a state
  };
  /// Cells of a block whose occupancy changed in the last scan, and those of them that are occupied now.
  struct Touched {
    Cell at;
    Bits cells{}, occupied{};
  };
  /// Change record of a slot of the table: revision of the last change of its occupied cells, and index of the changes
  /// in the last scan.
  struct OccupiedChange {
    std::uint32_t revision = 0, touched = 0;  // index + 1; 0: none
  };
  static constexpr std::size_t kChunk = 1024;  // number of blocks or pages per allocation

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
  /// Calls fn(block, index of the cell in it, center) for every occupied cell of the blocks that overlap the box.
  template <class Fn>
  void for_occupied(const Vector3& min_local_m, const Vector3& max_local_m, Fn&& fn) const;

  OccupancyMapConfig config_;
  double cells_per_m_;
  float hit_, miss_, occupied_, min_, max_;            // log-odds
  std::array<float, kMostMisses + 1> after_misses_{};  // log-odds of a cell that was never hit, by number of misses
  int most_misses_ = 0;  // miss count at which the log-odds are clamped or a value is needed
  RayCells rays_;
  int bits_ = 0, mask_ = 0;                       // bits and mask of a block coordinate in the table
  std::vector<std::int32_t> places_;              // block index; -1: none
  std::vector<OccupiedChange> occupied_changes_;  // indexed by slot of the table
  std::vector<std::uint64_t> occupied_places_;    // a bit for each slot whose block has an occupied cell
  std::vector<Touched> touched_;                  // changes of the last scan
  std::uint64_t touched_after_ = 0;               // revision before the last scan
  std::vector<std::unique_ptr<Block[]>> chunks_;
  std::vector<About> blocks_;
  std::vector<int> free_blocks_;
  std::vector<std::unique_ptr<Page>> pages_;
  std::vector<std::uint32_t> free_pages_;
  std::uint32_t scan_ = 0;
  std::uint64_t revision_ = 0;
  std::vector<TimeNs> scan_times_;  // times of the last scans, in a ring buffer
  BlockLog removed_;
  Vector3 kept_around_local_m_;
  mutable DistanceTiles distances_;
};

}  // namespace swiftlet
