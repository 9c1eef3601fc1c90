// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/map/cell_block.hpp"

namespace swiftlet {

/// Cells of a voxel grid that the rays of one sweep traverse, each cell once, and cells in which rays end. The
/// traversal gives the same cells as the OctoMap library [Hornung 2013; Amanatides and Woo, 1987], on four rays in
/// parallel in SIMD lanes. Traversed cells are marked in a bitmap of a window around the origins, in blocks of 8 x 8 x
/// 8 cells (64 bytes). Any frame, the same for all arguments.
class RayCells {
 public:
  static constexpr int kSide = CellBlock::kSide;
  using Bits = CellBlock::Bits;
  /// Approximate memory of the window for rays of this reach and cells of this edge.
  static constexpr double bytes(double reach_m, double edge_m);

  explicit RayCells(double edge_m) : edge_m_(edge_m), cells_per_m_(1.0 / edge_m) {}

  /// Begins a sweep. Sets the window for rays that start in the box and are no longer than the reach.
  void begin(const Eigen::AlignedBox3d& origins_m, double reach_m);
  /// Adds one ray: marks the cells from its origin to its end, except for the end cell. A ray is ignored when it is not
  /// finite, or leaves the window or the range of the OctoMap library, 2^16 cells per axis.
  /// @param ends  whether the ray ends with a return, so that its end cell is listed in ends()
  void add(const Eigen::Vector3f& origin_m, const Eigen::Vector3f& end_m, bool ends);

  /// Ends the sweep. Calls visit(block, bits) for every block with free cells: traversed by a ray, and without the end
  /// of any. Block b spans cells 8 b to 8 b + 7.
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
  /// End cells of rays with a return, in the order of the rays, with duplicates. Valid after take_passed() until the
  /// next sweep.
  std::span<const Cell> ends() const { return ends_; }

 private:
  /// [-] Number of rays traversed in parallel: doubles in a SIMD register of 32 bytes.
  static constexpr int kLanes = 4;
  /// [cells] Margin on each side of the window, so that rounding moves no ray end out of it.
  static constexpr int kMargin = 4;
  /// Rays in progress, one per lane, by axis. The index of a cell in the bitmap interleaves fields of the three
  /// coordinates (see spread()). `place[axis]` holds the field of one coordinate with all other bits set, so that the
  /// carry of an addition passes through the fields of the other axes. The index is the bitwise AND of the three
  /// places.
  struct alignas(32) Lanes {
    // Distances along the ray: to the next cell wall, between two walls, and to the end.
    double next[3][kLanes], per_cell[3][kLanes], length[kLanes];
    // Current cell, increment to the next cell along the axis, and index of the end cell.
    std::int64_t place[3][kLanes], step[3][kLanes], end[kLanes];
  };

  /// Field of a coordinate in the index of a cell: bits within the block lowest, then the coordinate of the block.
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
  int bits_ = 0;  // number of bits of a block coordinate in the window
  Cell first_block_ = Cell::Zero();
  std::array<std::int64_t, 3> fields_{};  // masks of the index bits of each axis
  std::vector<Bits> blocks_;              // all 0 between sweeps
  Lanes lanes_;
  unsigned busy_ = 0;                                    // lanes with a ray, one bit each
  std::int64_t passed_ = -1;                             // index of a traversed cell, in which idle lanes stay
  Cell low_ = Cell::Zero(), high_ = Cell::Constant(-1);  // bounds of the traversed cells
  std::vector<std::int64_t> end_indices_;
  std::vector<Cell> ends_;
};

constexpr double RayCells::bytes(double reach_m, double edge_m) {
  double blocks = 1.0;
  while (blocks * kSide < 2.0 * reach_m / edge_m + 2.0 * kMargin + 2.0 * kSide) blocks *= 2.0;
  return blocks * blocks * blocks * sizeof(Bits);
}

}  // namespace swiftlet
