// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

/// What may lie within a distance of one of some points: a bit for each cell of a grid of that edge. Says yes of
/// everything that does, and of some that is up to four times as far. Any frame, the same for all arguments.
class Vicinity {
 public:
  /// Forgets all points. The box: where points can be; its voxels are the least cells that are worth it.
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
