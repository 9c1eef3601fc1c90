// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// Cells that the rays of one sweep pass, each cell once, and cells in which rays end. The traversal is bit-identical
/// to OctoMap's library [Hornung 2013; Amanatides and Woo, 1987]. Four rays are traversed at a time, in SIMD lanes.
/// Cells are bits of a window around the origins, in blocks of 8 x 8 x 8 cells with 64 bytes each. Any frame, the same
/// for all arguments.
class RayCells {
 public:
  static constexpr int kSide = 8;                 ///< edge of a block in cells
  using Bits = std::array<std::uint64_t, kSide>;  ///< cells of a block: a word for each z, a byte for each y
  static constexpr double bytes(double reach_m, double edge_m);  ///< approximate size of the window

  explicit RayCells(double edge_m) : edge_m_(edge_m), cells_per_m_(1.0 / edge_m) {}

  /// Begins a sweep with rays that start in the box and are no longer than the reach.
  void begin(const Eigen::AlignedBox3d& origins_m, double reach_m);
  /// Adds one ray: marks the cells from its origin up to its end, without the cell of the end. A ray is ignored when it
  /// is not finite, or leaves the window or the library's range of 2^16 cells.
  /// @param ends  true: the cell of the end is one in which a ray ends
  void add(const Eigen::Vector3f& origin_m, const Eigen::Vector3f& end_m, bool ends);

  /// Ends the sweep. Calls visit(block, bits) for every block with cells that were passed and in which no ray ended;
  /// block b spans cells 8 b to 8 b + 7.
  template <class Visit>
  void take_passed(Visit&& visit) {
    finish();
    for (int z = low_.z() >> 3; z <= high_.z() >> 3; ++z) {
      for (int y = low_.y() >> 3; y <= high_.y() >> 3; ++y) {
        Bits* const row = blocks_.data() + ((static_cast<std::size_t>(z) << bits_ | y) << bits_);
        for (int x = low_.x() >> 3; x <= high_.x() >> 3; ++x) {
          Bits& block = row[x];
          std::uint64_t any = 0;
          for (const std::uint64_t word : block) any |= word;
          if (any == 0) continue;
          visit(Cell(first_block_ + Cell(x, y, z)), static_cast<const Bits&>(block));
          block.fill(0);
        }
      }
    }
  }
  /// Cells in which rays ended, in the order of the rays, with duplicates. Valid until the next sweep.
  std::span<const Cell> ends() const { return ends_; }

 private:
  /// [-] Rays that are traversed at a time.
  static constexpr int kLanes = 4;
  static constexpr int kMargin = 4;  // margin for rounding of ray ends
  /// Rays in progress, one per lane. A coordinate is spread over the bits of an index into the window, with all other
  /// bits set, so that additions carry over the bits between. The index is the bitwise and of the three coordinates.
  struct alignas(32) Lanes {
    double next[3][kLanes], per_cell[3][kLanes], length[kLanes];
    std::int64_t place[3][kLanes], step[3][kLanes], end[kLanes];
  };

  std::int64_t spread(int axis, int cell) const {
    return static_cast<std::int64_t>(cell & 7) << (3 * axis) | static_cast<std::int64_t>(cell >> 3)
                                                                   << (9 + axis * bits_);
  }
  void mark(std::int64_t index) {
    reinterpret_cast<std::uint64_t*>(blocks_.data())[index >> 6] |= std::uint64_t{1} << (index & 63);
  }
  void idle(int lane);
  unsigned follow();
  void finish();

  double edge_m_, cells_per_m_;
  int bits_ = 0;  // bits of a block coordinate in the window
  Cell first_block_ = Cell::Zero();
  std::array<std::int64_t, 3> fields_{};  // index bits of each axis
  std::vector<Bits> blocks_;              // all 0 between sweeps
  Lanes lanes_;
  unsigned busy_ = 0;                                    // lanes with a ray
  std::int64_t passed_ = -1;                             // a marked cell, target of idle lanes
  Cell low_ = Cell::Zero(), high_ = Cell::Constant(-1);  // bounds of the cells that rays can pass
  std::vector<std::int64_t> end_indices_;
  std::vector<Cell> ends_;
};

constexpr double RayCells::bytes(double reach_m, double edge_m) {
  double blocks = 1.0;
  while (blocks * kSide < 2.0 * reach_m / edge_m + 2.0 * kMargin + 2.0 * kSide) blocks *= 2.0;
  return blocks * blocks * blocks * sizeof(Bits);
}

}  // namespace swiftlet
