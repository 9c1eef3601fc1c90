// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// First slot probed for a block in a table with open addressing; the table's size is a power of two.
inline std::size_t first_slot(const Cell& block, std::size_t slots) {
  const auto part = [](int c) { return static_cast<std::uint64_t>(c) & 0x1FFFFFU; };
  const std::uint64_t key = part(block.x()) | part(block.y()) << 21U | part(block.z()) << 42U;
  return (key * 0x9E3779B97F4A7C15ULL >> 32U) & (slots - 1);
}

}  // namespace swiftlet
