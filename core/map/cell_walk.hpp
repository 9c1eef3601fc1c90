// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>

#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

// Blocks are 8 cells wide.
inline Cell block_of(const Cell& cell) { return {cell.x() >> 3, cell.y() >> 3, cell.z() >> 3}; }
inline int index_in_block(const Cell& cell) { return (cell.x() & 7) | (cell.y() & 7) << 3 | (cell.z() & 7) << 6; }

/// From cell to cell along a line [Amanatides and Woo, 1987]; lengths in cells. Any frame, the same for all arguments.
struct CellWalk {
  Cell cell;
  int step[3];
  double next[3], per_cell[3];  // distance to the next cell wall, and between walls

  CellWalk(const Vector3& origin, const Vector3& direction) : cell(origin.array().floor().cast<int>()) {
    for (int axis = 0; axis < 3; ++axis) {
      const double d = direction[axis];
      step[axis] = d > 0.0 ? 1 : -1;
      per_cell[axis] = d == 0.0 ? std::numeric_limits<double>::infinity() : std::abs(1.0 / d);
      const double to_wall = d > 0.0 ? cell[axis] + 1.0 - origin[axis] : origin[axis] - cell[axis];
      next[axis] = d == 0.0 ? per_cell[axis] : to_wall * per_cell[axis];
    }
  }
  int next_axis() const { return next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2); }
};

/// Distance [m] from the start of a segment to the first cell on it that satisfies the predicate; negative if there is
/// none. Any frame, the same for all arguments.
template <class Predicate>
double distance_to_first_m(const Vector3& from_m, const Vector3& to_m, double cells_per_m, Cell& cell,
                           Predicate&& is_it) {
  const double length_m = (to_m - from_m).norm();
  const Vector3 direction = length_m > 0.0 ? Vector3((to_m - from_m) / length_m) : Vector3(Vector3::UnitX());
  CellWalk walk(from_m * cells_per_m, direction);
  for (double traveled = 0.0; traveled <= length_m * cells_per_m;) {
    cell = walk.cell;
    if (is_it(walk.cell)) return traveled / cells_per_m;
    const int axis = walk.next_axis();
    traveled = walk.next[axis];
    walk.next[axis] += walk.per_cell[axis];
    walk.cell[axis] += walk.step[axis];
  }
  return -1.0;
}

}  // namespace swiftlet
