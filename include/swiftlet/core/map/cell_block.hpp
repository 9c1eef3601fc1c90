// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// States of a block of 8 x 8 x 8 cells. Cells in neither set are unknown; no cell is in both.
struct CellBlock {
  static constexpr int kSide = 8;                 ///< [cells] edge of a block
  using Bits = std::array<std::uint64_t, kSide>;  ///< cells of a block: word z, byte y, bit x

  /// Approximate number of blocks in a ball.
  static double num_in_ball(double radius_cells) {
    return 4.19 * radius_cells * radius_cells * radius_cells / (kSide * kSide * kSide);
  }

  Cell at = Cell::Zero();  ///< block b spans cells 8 b to 8 b + 7
  Bits occupied{}, free{};
};

}  // namespace swiftlet
