// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/free_space.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {

std::size_t CellGrid::num_cells() const {
  return static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) * static_cast<std::size_t>(size.z());
}

Eigen::Vector3i CellGrid::cell_of(int index) const {
  return {index % size.x(), index / size.x() % size.y(), index / size.x() / size.y()};
}

Eigen::Vector3i CellGrid::cell_at(const Vector3& p_world_m) const {
  const Eigen::Vector3i cell = ((p_world_m - origin_world_m) / cell_m).array().floor().cast<int>();
  return cell.cwiseMax(0).cwiseMin(size - Eigen::Vector3i::Ones());
}

Vector3 CellGrid::center_of(int index) const {
  return origin_world_m + cell_m * (cell_of(index).cast<double>() + Vector3::Constant(0.5));
}

bool is_free_segment(const FreeSpaceView& space, const Vector3& a, const Vector3& b) {
  const int steps = std::max(1, static_cast<int>(std::ceil((b - a).norm() / (0.5 * space.grid().cell_m))));
  for (int i = 0; i <= steps; ++i) {
    if (!space.is_free(a + (b - a) * (static_cast<double>(i) / steps))) return false;
  }
  return true;
}

}  // namespace swiftlet
