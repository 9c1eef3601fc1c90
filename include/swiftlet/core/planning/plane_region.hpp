// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "swiftlet/core/frames.hpp"

/// Regions of a horizontal plane with borders of straight edges. Coordinates are rounded to micrometers, and all else
/// is exact, so regions with nearly collinear edges are no special case. Any frame, the same for all arguments.
namespace swiftlet {

using Vector2 = Eigen::Vector2d;
using Ring = std::vector<Vector2>;  ///< a closed line; its last corner is joined with its first

/// Any number of polygons with holes: borders counter-clockwise, holes clockwise, no two of which cross.
/// Any frame, the same for all arguments.
struct PlaneRegion {
  std::vector<Ring> rings_m;
  bool empty() const { return rings_m.empty(); }
};

/// What a closed line goes around, whatever its direction; it may cross itself.
/// Any frame, the same for all arguments.
PlaneRegion inside_of(const Ring& ring_m);

/// Any frame, the same for all arguments.
PlaneRegion union_of(std::span<const PlaneRegion> regions);
PlaneRegion intersection_of(const PlaneRegion& a, const PlaneRegion& b);
PlaneRegion difference_of(const PlaneRegion& a, const PlaneRegion& b);

/// All that lies within a distance of a path, and at most 0.5 % of that distance more.
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

/// The cells of a mask that are not zero; neighbors with a common edge are joined.
PlaneRegion region_of(const CellMask& mask);
/// Marks the cells whose centers lie in the region.
void mark_inside(const PlaneRegion& region, CellMask& mask);

/// Its polygons, each with its holes.
std::vector<PlaneRegion> parts_of(const PlaneRegion& region);
double area_m2(const PlaneRegion& region);
/// Any frame, the same for all arguments.
bool contains(const PlaneRegion& region, const Vector2& p_m);
/// To the nearest border, whether inside or outside. Any frame, the same for all arguments.
double distance_to_border_m(const PlaneRegion& region, const Vector2& p_m);

/// The point of a region that is farthest from its borders.
/// Any frame, the same for all arguments.
struct Pole {
  Vector2 p_m = Vector2::Zero();
  double distance_m = 0.0;  ///< to the nearest border
};

/// By quartering squares that may hold it, the most promising first, as polylabel does.
/// @param precision_m  how much farther from the borders another point may be at most
Pole pole_of_inaccessibility(const PlaneRegion& region, double precision_m);

}  // namespace swiftlet
