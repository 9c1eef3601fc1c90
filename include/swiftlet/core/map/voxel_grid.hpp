// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>

#include "swiftlet/core/frames.hpp"

namespace swiftlet {

using Cell = Eigen::Vector3i;

/// A box of cubic voxels. Any frame, the same for all arguments. Cells are counted on that frame's lattice, whatever
/// the box: cell (i, j, k) spans [i, i + 1) * edge and so on. So two grids of one edge agree on their cells. Indices
/// run along x first, then y, then z.
struct VoxelGrid {
  double edge_m = 0.25;
  Cell min_cell = Cell::Zero();
  Cell size = Cell::Zero();  ///< cells by axis

  std::ptrdiff_t num_cells() const { return static_cast<std::ptrdiff_t>(size.x()) * size.y() * size.z(); }
  bool contains(const Cell& cell) const {
    return ((cell - min_cell).array() >= 0).all() && ((cell - min_cell).array() < size.array()).all();
  }
  /// False for what is not finite.
  bool contains(const Vector3& p_m) const {
    const Eigen::Array3d at = p_m.array() / edge_m;
    return (at >= min_cell.array().cast<double>()).all() && (at < (min_cell + size).array().cast<double>()).all();
  }
  /// Of a point that is inside.
  Cell cell_of(const Vector3& p_m) const { return (p_m.array() / edge_m).floor().cast<int>(); }
  Vector3 center_m(const Cell& cell) const { return (cell.cast<double>().array() + 0.5) * edge_m; }
  std::ptrdiff_t index(const Cell& cell) const {
    const Cell at = cell - min_cell;
    return (static_cast<std::ptrdiff_t>(at.z()) * size.y() + at.y()) * size.x() + at.x();
  }
  /// Of the cell of any point, -1 where it is not inside (or not finite).
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

  /// The least grid that holds the box.
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
