// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// Conservative test whether a position is within a distance of any of a set of points. Space is divided into cells
/// whose edge is the distance, or the voxel edge of the box if that is larger. True for all positions within the
/// distance, false beyond 3.5 edges of a cell. Positions must lie in the box. Any frame, the same for all arguments.
class Vicinity {
 public:
  /// Removes all points. @param box  region of all positions; its voxels limit the cell size from below
  void begin(const VoxelGrid& box, double distance_m);
  void add(const Eigen::Vector3f& p_m);
  bool contains(const Eigen::Vector3f& p_m) const;

 private:
  Cell cell_of(const Eigen::Vector3f& p_m) const;
  std::ptrdiff_t row(int y, int z) const { return (static_cast<std::ptrdiff_t>(z) * size_.y() + y) * words_per_row_; }

  Vector3 origin_m_ = Vector3::Zero();
  double edge_m_ = 1.0;
  Cell size_ = Cell::Zero();  // with a border of one cell
  int words_per_row_ = 0;
  std::vector<std::uint64_t> bits_;
};

}  // namespace swiftlet
