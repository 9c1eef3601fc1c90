// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

/// Regions of a horizontal plane with polygonal borders. Coordinates are rounded to micrometers and operations are
/// exact, so nearly collinear edges need no special treatment. Any frame, the same for all arguments.
namespace swiftlet {

using Vector2 = Eigen::Vector2d;
using Ring = std::vector<Vector2>;  ///< closed line; the last corner is connected to the first

/// Any number of polygons with holes: borders counter-clockwise, holes clockwise, without crossings.
/// Any frame, the same for all arguments.
struct PlaneRegion {
  std::vector<Ring> rings_m;
  bool empty() const { return rings_m.empty(); }
};

/// Interior of a closed line of any direction, which may intersect itself.
/// Any frame, the same for all arguments.
PlaneRegion inside_of(const Ring& ring_m);

/// Any frame, the same for all arguments.
PlaneRegion union_of(std::span<const PlaneRegion> regions);
PlaneRegion intersection_of(const PlaneRegion& a, const PlaneRegion& b);
PlaneRegion difference_of(const PlaneRegion& a, const PlaneRegion& b);

/// Points within a distance of a path, with a tolerance of 0.5 % of that distance outward.
/// Any frame, the same for all arguments.
PlaneRegion around_path(std::span<const Vector2> path_m, double distance_m);

/// Cells of a grid in a plane, row by row.
struct CellMask {
  Vector2 origin_m = Vector2::Zero();  ///< corner of the first cell; any frame, the same for all arguments
  double edge_m = 0.1;
  int columns = 0;  ///< along x
  int rows = 0;     ///< along y
  std::vector<char> cells;

  char& at(int column, int row) { return cells[static_cast<std::size_t>(row) * columns + column]; }
  char at(int column, int row) const { return cells[static_cast<std::size_t>(row) * columns + column]; }
  /// Any frame, the same for all arguments.
  Vector2 center_m(int column, int row) const { return origin_m + edge_m * Vector2(column + 0.5, row + 0.5); }
};

/// Union of the nonzero cells of a mask; cells with a common edge are merged.
PlaneRegion region_of(const CellMask& mask);
/// Marks the cells whose centers lie in the region.
void mark_inside(const PlaneRegion& region, CellMask& mask);

/// Connected polygons of the region, each with its holes.
std::vector<PlaneRegion> parts_of(const PlaneRegion& region);
double area_m2(const PlaneRegion& region);
/// Any frame, the same for all arguments.
bool contains(const PlaneRegion& region, const Vector2& p_m);
/// Distance to the nearest border, from inside or outside. Any frame, the same for all arguments.
double distance_to_border_m(const PlaneRegion& region, const Vector2& p_m);

/// Point of a region with the largest distance from its borders.
/// Any frame, the same for all arguments.
struct Pole {
  Vector2 p_m = Vector2::Zero();
  double distance_m = 0.0;  ///< distance to the nearest border
};

/// Computes the pole by best-first subdivision of squares, as polylabel.
/// @param precision_m  maximum deviation from the optimal distance
Pole pole_of_inaccessibility(const PlaneRegion& region, double precision_m);

}  // namespace swiftlet
