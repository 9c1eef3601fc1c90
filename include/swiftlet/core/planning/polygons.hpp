// SPDX-License-Identifier: BSD-3-Clause
// Regions of a plane. Any frame, the same for all arguments.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// Corners in order; the last one is joined to the first.
using Outline = std::vector<Eigen::Vector2d>;

/// One connected piece: its border and the holes in it.
struct Polygon {
  Outline border;              ///< counterclockwise
  std::vector<Outline> holes;  ///< clockwise
};

/// Pieces that do not overlap.
using Region = std::vector<Polygon>;

double area_m2(const Region& region);
/// Points of the border count as inside.
bool contains(const Polygon& polygon, const Eigen::Vector2d& p_m);
bool contains(const Region& region, const Eigen::Vector2d& p_m);
/// To the border or a hole of the polygon, negative outside of it.
double depth_m(const Polygon& polygon, const Eigen::Vector2d& p_m);
/// 0 inside; infinite when the region is empty.
double distance_m(const Region& region, const Eigen::Vector2d& p_m);

// Corners are rounded to a micrometer, and what is made of them is exact then [Vatti 1992, by Clipper].
Region intersection_of(const Region& a, const Region& b);
Region difference_of(const Region& a, const Region& b);
Region union_of(std::span<const Region> regions);

/// Places within the radius of a polyline; round ends have 64 corners, outside of the circle.
Region buffer_of(std::span<const Eigen::Vector2d> path_m, double radius_m);

/// A field of square cells, true or false, as a region. Cells that only touch at a corner are not joined.
/// @param cells  along x first
Region region_of_cells(const Eigen::Vector2d& corner_m, double edge_m, int cols, int rows,
                       const std::vector<bool>& cells);

/// What is seen from a place at its own height up to a range, in a horizontal slice of the map [Pritzl 2024, algorithm
/// 2]: rays to all sides up to the first occupied cell.
Region visible_from(const OccupancyView& view, const Vector3& p_local_m, double range_m, int num_rays);

/// The point that lies deepest inside a polygon, to the precision, and how deep (polylabel).
struct Pole {
  Eigen::Vector2d p_m = Eigen::Vector2d::Zero();
  double depth_m = 0.0;
};
Pole pole_of_inaccessibility(const Polygon& polygon, double precision_m);

}  // namespace swiftlet
