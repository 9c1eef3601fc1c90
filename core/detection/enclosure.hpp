// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/map/voxel_map.hpp"

namespace swiftlet {

/// Search limit of rule B of VoFOD: distance of voxel centers from the start (sphere), or number of steps along the
/// axes (octahedron).
struct SearchShape {
  bool octahedron = false;
  double radius_m = 3.0;  ///< radius of the sphere
  int radius_steps = 0;   ///< radius of the octahedron in voxels
  Vector3 sensor_m = Vector3::Zero();
  /// Sine of the elevation from the sensor above which voxels count as free; 2: none.
  double top_z = 2.0;
};

/// Rule B [Vrba 2025, sec. III-B, algorithm 1]: tests whether confident free voxels separate a set of voxels from all
/// voxels that are at least tentative. The search floods the 6-neighborhood through voxels that are not free. It ends
/// at a tentative voxel, at its search limit or at the border of the map. The result does not depend on the search
/// order; depth first reaches the border soonest.
class EnclosureSearch {
 public:
  /// True if no start leads out.
  bool enclosed(const VoxelMap& map, std::span<const Cell> starts, const SearchShape& shape);

 private:
  bool leads_out(const VoxelMap& map, const Cell& start, const SearchShape& shape);
  bool is_known_enclosed(const VoxelMap& map, const Cell& start, const SearchShape& shape) const;

  // Number of the last flood fill that visited each voxel, in a box around the start.
  std::vector<std::uint32_t> seen_;
  std::uint32_t flood_ = 0;
  std::vector<Cell> stack_;
  std::vector<std::ptrdiff_t> explored_;  // flooded voxels
  // Enclosed regions found so far. A start in such a region is enclosed too if the search from it could not reach its
  // limit within the region.
  struct Part {
    std::size_t first, last;  // range in explored_, sorted
    Cell min, max;
  };
  std::vector<Part> parts_;
};

}  // namespace swiftlet
