// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/map/distance_tiles.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// Queries of a map by its occupied cells, which are bits in blocks of 8 x 8 x 8 cells. Instantiated in
/// block_occupancy.cpp.
/// @tparam Map  interface of the map, an OccupancyView
template <class Map>
class BlockOccupancy : public Map, public OccupiedBlocks {
 public:
  double edge_m() const override { return edge_m_; }
  void occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                   std::vector<Vector3>& centers_local_m) const override;
  double distance_m(const Vector3& p_local_m, double max_m) const override;
  double clearance_m(const Vector3& p_local_m, double max_m) const override;
  std::optional<SegmentHit> first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const override;
  std::uint64_t revision() const override { return revision_; }

 protected:
  using Bits = CellBlock::Bits;
  static constexpr int kSide = CellBlock::kSide;

  /// @param distance_max_m  largest distance that is cached
  BlockOccupancy(double edge_m, double distance_max_m);
  Cell cell_of(const Vector3& p_local_m) const { return (p_local_m.array() * cells_per_m_).floor().cast<int>(); }
  Vector3 center_of(const Cell& cell) const { return (cell.cast<double>().array() + 0.5) * edge_m_; }
  static Cell cell_in(const Cell& block, int in_block) {
    return kSide * block + Cell(in_block & 7, in_block >> 3 & 7, in_block >> 6);
  }
  static bool has(const Bits& bits, int in_block) {
    return (bits[static_cast<std::size_t>(in_block >> 6)] >> (in_block & 63) & 1U) != 0;
  }
  /// True when the nearest point of a cell lies in the ball.
  bool overlaps_ball(const Vector3& cell_local_m, const Vector3& center_local_m, double radius_m) const {
    const Vector3 gap = ((cell_local_m - center_local_m).array().abs() - 0.5 * edge_m_).cwiseMax(0.0);
    return gap.squaredNorm() <= radius_m * radius_m;
  }
  /// Calls fn(index of the cell in its block) for every cell.
  template <class Fn>
  static void for_cells(const Bits& bits, Fn&& fn) {
    for (int z = 0; z < kSide; ++z) {
      for (std::uint64_t left = bits[static_cast<std::size_t>(z)]; left != 0; left &= left - 1) {
        fn(z << 6 | std::countr_zero(left));
      }
    }
  }
  /// Calls fn(block, its occupied cells) for every block with occupied cells that overlaps the box.
  template <class Fn>
  void for_occupied_blocks(const Vector3& min_local_m, const Vector3& max_local_m, Fn&& fn) const {
    const Cell first = cell_of(min_local_m), last = cell_of(max_local_m);
    for (int z = first.z() >> 3; z <= last.z() >> 3; ++z) {
      for (int y = first.y() >> 3; y <= last.y() >> 3; ++y) {
        for (int x = first.x() >> 3; x <= last.x() >> 3; ++x) {
          if (const Bits* occupied = occupied_of({x, y, z}); occupied != nullptr) fn(Cell(x, y, z), *occupied);
        }
      }
    }
  }
  /// Calls fn(center) for every occupied cell of these blocks.
  template <class Fn>
  void for_occupied(const Vector3& min_local_m, const Vector3& max_local_m, Fn&& fn) const {
    for_occupied_blocks(min_local_m, max_local_m, [&](const Cell& block, const Bits& occupied) {
      for_cells(occupied, [&](int in_block) { fn(center_of(cell_in(block, in_block))); });
    });
  }

  double edge_m_, cells_per_m_, distance_max_m_;
  std::uint64_t revision_ = 0;
  mutable DistanceTiles distances_;
};

}  // namespace swiftlet
