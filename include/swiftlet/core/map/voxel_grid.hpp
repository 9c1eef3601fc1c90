// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

using Cell = Eigen::Vector3i;

/// [cells] Largest coordinate of a cell: sums of two fit into 32 bits.
inline constexpr double kFarthestCell = 1e9;

/// A box of cubic voxels. Any frame, the same for all arguments. Cell indices refer to that frame's lattice, not to the
/// box: cell (i, j, k) spans [i, i + 1) * edge and so on. So grids with equal edges share their cells. Linear indices
/// run along x first, then y, then z.
struct VoxelGrid {
  double edge_m = 0.25;
  Cell min_cell = Cell::Zero();
  Cell size = Cell::Zero();  ///< number of cells per axis

  std::ptrdiff_t num_cells() const { return static_cast<std::ptrdiff_t>(size.x()) * size.y() * size.z(); }
  bool contains(const Cell& cell) const {
    return ((cell - min_cell).array() >= 0).all() && ((cell - min_cell).array() < size.array()).all();
  }
  /// False for points that are not finite.
  bool contains(const Vector3& p_m) const {
    const Eigen::Array3d at = p_m.array() / edge_m;
    return (at >= min_cell.array().cast<double>()).all() && (at < (min_cell + size).array().cast<double>()).all();
  }
  /// Cell of a point inside the grid.
  Cell cell_of(const Vector3& p_m) const { return (p_m.array() / edge_m).floor().cast<int>(); }
  Vector3 center_m(const Cell& cell) const { return (cell.cast<double>().array() + 0.5) * edge_m; }
  std::ptrdiff_t index(const Cell& cell) const {
    const Cell at = cell - min_cell;
    return (static_cast<std::ptrdiff_t>(at.z()) * size.y() + at.y()) * size.x() + at.x();
  }
  /// Linear index of the cell of a point; -1 when it is outside or not finite.
  std::ptrdiff_t index_of(const Vector3& p_m) const {
    const Eigen::Array3d at = p_m.array() / edge_m;
    const Eigen::Array3d first = min_cell.array().cast<double>(), end = (min_cell + size).array().cast<double>();
    if (!((at >= first).all() && (at < end).all())) return -1;
    const Eigen::Array3i whole = at.cast<int>();
    return index((whole - (at < whole.cast<double>()).cast<int>()).matrix());
  }
  Cell cell(std::ptrdiff_t index) const {
    const std::ptrdiff_t row = index / size.x();
    return min_cell +
           Cell(static_cast<int>(index % size.x()), static_cast<int>(row % size.y()), static_cast<int>(row / size.y()));
  }

  /// Smallest grid that contains the box.
  static VoxelGrid covering(const Vector3& center_m, const Vector3& size_m, double edge_m) {
    VoxelGrid grid;
    grid.edge_m = edge_m;
    grid.min_cell = ((center_m - 0.5 * size_m).array() / edge_m).floor().cast<int>();
    const Cell end = ((center_m + 0.5 * size_m).array() / edge_m).ceil().cast<int>();
    grid.size = (end - grid.min_cell).cwiseMax(1);
    return grid;
  }
};

}  // namespace swiftlet
