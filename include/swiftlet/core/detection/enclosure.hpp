// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/map/voxel_map.hpp"

namespace swiftlet {

/// How far rule B looks: until the centers are so far apart, or so many steps along the axes away.
struct SearchShape {
  bool octahedron = false;
  double radius_m = 3.0;  ///< sphere
  int radius_steps = 0;   ///< octahedron
};

/// Rule B [Vrba 2025, sec. III-B, algorithm 1]: is a set of voxels totally separated by confident free ones from
/// everything that is at least tentative? The search floods the 6-neighborhood through what is not free. It ends at
/// something tentative, at its own border or at the border of the map. The answer does not depend on the order of the
/// search, which goes depth first because that meets the border soonest.
class EnclosureSearch {
 public:
  /// True if no start leads out. `explored()` then holds what was flooded: all of it uncertain, the starts apart.
  bool enclosed(const VoxelMap& map, std::span<const Cell> starts, const SearchShape& shape);
  const std::vector<std::ptrdiff_t>& explored() const { return explored_; }

 private:
  bool leads_out(const VoxelMap& map, const Cell& start, const SearchShape& shape);
  bool is_known_enclosed(const VoxelMap& map, const Cell& start, const SearchShape& shape) const;

  // Where the flood of one start has been, in a box around it: the number of that flood.
  std::vector<std::uint32_t> seen_;
  std::uint32_t flood_ = 0;
  std::vector<Cell> stack_;
  std::vector<std::ptrdiff_t> explored_;
  // The parts flooded so far: a start in one whose farthest corners are within its own reach is enclosed as well.
  struct Part {
    std::size_t first, last;  // in explored_, sorted
    Cell min, max;
  };
  std::vector<Part> parts_;
};

}  // namespace swiftlet
