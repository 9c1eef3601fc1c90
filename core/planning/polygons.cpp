// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/polygons.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <polyclipping/clipper.hpp>
#include <queue>

#include "swiftlet/core/elementary.hpp"
#include "swiftlet/core/ensure.hpp"

namespace swiftlet {
namespace {

using Eigen::Vector2d;

constexpr double kUnits_per_m = 1e6;  // of Clipper's whole numbers
constexpr int kCircle = 64;           // corners

ClipperLib::Path to_clipper(const Outline& outline) {
  ClipperLib::Path path;
  path.reserve(outline.size());
  for (const Vector2d& p_m : outline) {
    path.emplace_back(std::llround(p_m.x() * kUnits_per_m), std::llround(p_m.y() * kUnits_per_m));
  }
  return path;
}

Outline from_clipper(const ClipperLib::Path& path) {
  Outline outline;
  outline.reserve(path.size());
  for (const ClipperLib::IntPoint& p : path) {
    outline.emplace_back(static_cast<double>(p.X) / kUnits_per_m, static_cast<double>(p.Y) / kUnits_per_m);
  }
  return outline;
}

double signed_area_m2(const Outline& outline) {
  double twice = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

Outline turned(Outline outline, bool counterclockwise) {
  if ((signed_area_m2(outline) > 0.0) != counterclockwise) std::reverse(outline.begin(), outline.end());
  return outline;
}

void add(const Region& region, ClipperLib::PolyType type, ClipperLib::Clipper& clipper) {
  for (const Polygon& polygon : region) {
    clipper.AddPath(to_clipper(polygon.border), type, true);
    for (const Outline& hole : polygon.holes) clipper.AddPath(to_clipper(hole), type, true);
  }
}

void append_pieces(const ClipperLib::PolyNode& node, Region& region) {
  for (const ClipperLib::PolyNode* outer : node.Childs) {
    Polygon& polygon = region.emplace_back();
    polygon.border = turned(from_clipper(outer->Contour), true);
    for (const ClipperLib::PolyNode* hole : outer->Childs) {
      polygon.holes.push_back(turned(from_clipper(hole->Contour), false));
    }
    for (const ClipperLib::PolyNode* hole : outer->Childs) append_pieces(*hole, region);  // islands
  }
}

Region result_of(ClipperLib::ClipType type, ClipperLib::Clipper& clipper) {
  ClipperLib::PolyTree tree;
  const bool done = clipper.Execute(type, tree, ClipperLib::pftNonZero, ClipperLib::pftNonZero);
  ENSURE(done, static_cast<int>(type));
  Region region;
  append_pieces(tree, region);
  return region;
}

double squared_distance(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d way = b - a;
  const double length_sq = way.squaredNorm();
  const double at = length_sq > 0.0 ? std::clamp((p - a).dot(way) / length_sq, 0.0, 1.0) : 0.0;
  return (p - a - at * way).squaredNorm();
}

double distance_to(const Outline& outline, const Vector2d& p) {
  double least_sq = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < outline.size(); ++i) {
    least_sq = std::min(least_sq, squared_distance(p, outline[i], outline[(i + 1) % outline.size()]));
  }
  return std::sqrt(least_sq);
}

// By the number of edges that a ray to the right crosses.
bool encloses(const Outline& outline, const Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

double distance_to_border(const Polygon& polygon, const Vector2d& p) {
  double least = distance_to(polygon.border, p);
  for (const Outline& hole : polygon.holes) least = std::min(least, distance_to(hole, p));
  return least;
}

/// The convex hull of two circles' corners.
Polygon capsule(const Vector2d& a, const Vector2d& b, double radius) {
  Vector2d along = b - a;
  const double length = along.norm();
  along = length > 0.0 ? Vector2d(along / length) : Vector2d(Vector2d::UnitX());
  const Vector2d left(-along.y(), along.x());
  // Corners lie outside of the circle, whose every point is then covered.
  const double outer = radius / elementary::cos(std::numbers::pi / kCircle);
  Polygon polygon;
  for (int i = 0; i < kCircle; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + 0.5) / kCircle - 0.5 * std::numbers::pi;
    const Vector2d corner = outer * (elementary::cos(angle) * along + elementary::sin(angle) * left);
    polygon.border.push_back((i < kCircle / 2 ? b : a) + corner);
  }
  return polygon;
}

}  // namespace

double area_m2(const Region& region) {
  double sum = 0.0;
  for (const Polygon& polygon : region) {
    sum += std::abs(signed_area_m2(polygon.border));
    for (const Outline& hole : polygon.holes) sum -= std::abs(signed_area_m2(hole));
  }
  return sum;
}

double depth_m(const Polygon& polygon, const Vector2d& p_m) {
  const double distance = distance_to_border(polygon, p_m);
  const bool inside =
      encloses(polygon.border, p_m) && std::none_of(polygon.holes.begin(), polygon.holes.end(),
                                                    [&](const Outline& hole) { return encloses(hole, p_m); });
  return inside ? distance : -distance;
}

bool contains(const Polygon& polygon, const Vector2d& p_m) { return depth_m(polygon, p_m) >= 0.0; }

bool contains(const Region& region, const Vector2d& p_m) {
  return std::any_of(region.begin(), region.end(), [&](const Polygon& polygon) { return contains(polygon, p_m); });
}

double distance_m(const Region& region, const Vector2d& p_m) {
  double least = std::numeric_limits<double>::infinity();
  for (const Polygon& polygon : region) least = std::min(least, std::max(-depth_m(polygon, p_m), 0.0));
  return least;
}

Region intersection_of(const Region& a, const Region& b) {
  ClipperLib::Clipper clipper;
  add(a, ClipperLib::ptSubject, clipper);
  add(b, ClipperLib::ptClip, clipper);
  return result_of(ClipperLib::ctIntersection, clipper);
}

Region difference_of(const Region& a, const Region& b) {
  ClipperLib::Clipper clipper;
  add(a, ClipperLib::ptSubject, clipper);
  add(b, ClipperLib::ptClip, clipper);
  return result_of(ClipperLib::ctDifference, clipper);
}

Region union_of(std::span<const Region> regions) {
  ClipperLib::Clipper clipper;
  for (const Region& region : regions) add(region, ClipperLib::ptSubject, clipper);
  return result_of(ClipperLib::ctUnion, clipper);
}

Region buffer_of(std::span<const Vector2d> path_m, double radius_m) {
  ENSURE(!path_m.empty() && radius_m > 0.0, path_m.size(), radius_m);
  std::vector<Region> parts;
  for (std::size_t i = 0; i + 1 < path_m.size(); ++i) parts.push_back({capsule(path_m[i], path_m[i + 1], radius_m)});
  if (path_m.size() == 1) parts.push_back({capsule(path_m[0], path_m[0], radius_m)});
  return union_of(parts);
}

// Edges between a cell that is true and one that is not, with the true one on the left, are joined to outlines.
Region region_of_cells(const Vector2d& corner_m, double edge_m, int cols, int rows, const std::vector<bool>& cells) {
  ENSURE(static_cast<std::size_t>(cols) * static_cast<std::size_t>(rows) == cells.size(), cols, rows, cells.size());
  const auto is = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < cols && y < rows &&
           cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(cols) + static_cast<std::size_t>(x)];
  };
  // From each corner of the lattice, an edge to the east, north, west or south.
  constexpr std::array<std::array<int, 2>, 4> kWay = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  const auto starts = [&](int x, int y, int way) {
    switch (way) {
      case 0:
        return is(x, y) && !is(x, y - 1);
      case 1:
        return is(x - 1, y) && !is(x, y);
      case 2:
        return is(x - 1, y - 1) && !is(x - 1, y);
      default:
        return is(x, y - 1) && !is(x - 1, y - 1);
    }
  };
  std::vector<std::uint8_t> left(static_cast<std::size_t>(cols + 1) * static_cast<std::size_t>(rows + 1),
                                 0);  // edges not used so far
  const auto at = [&](int x, int y) -> std::uint8_t& {
    return left[static_cast<std::size_t>(y) * static_cast<std::size_t>(cols + 1) + static_cast<std::size_t>(x)];
  };
  for (int y = 0; y <= rows; ++y) {
    for (int x = 0; x <= cols; ++x) {
      for (int way = 0; way < 4; ++way) at(x, y) |= static_cast<std::uint8_t>(starts(x, y, way) << way);
    }
  }
  std::vector<Outline> borders, holes;
  for (int y0 = 0; y0 <= rows; ++y0) {
    for (int x0 = 0; x0 <= cols; ++x0) {
      while (at(x0, y0) != 0) {
        Outline outline;
        int x = x0, y = y0, last = -1;
        do {
          // Where two edges start, to the left: so cells that touch at a corner stay apart.
          int way = last < 0 ? 0 : (last + 1) % 4;
          while ((at(x, y) >> way & 1U) == 0) way = last < 0 ? way + 1 : (way + 3) % 4;
          at(x, y) &= static_cast<std::uint8_t>(~(1U << way));
          if (way != last) outline.push_back(corner_m + edge_m * Vector2d(x, y));
          last = way;
          x += kWay[static_cast<std::size_t>(way)][0];
          y += kWay[static_cast<std::size_t>(way)][1];
        } while (x != x0 || y != y0);
        (signed_area_m2(outline) > 0.0 ? borders : holes).push_back(std::move(outline));
      }
    }
  }
  Region region;
  for (Outline& border : borders) region.push_back({std::move(border), {}});
  for (Outline& hole : holes) {
    // A hole belongs to the smallest border around it; a point just outside of the hole lies in that piece.
    const Vector2d along = (hole[1] - hole[0]).normalized();
    const Vector2d inside = 0.5 * (hole[0] + hole[1]) + 0.25 * edge_m * Vector2d(-along.y(), along.x());
    Polygon* owner = nullptr;
    for (Polygon& polygon : region) {
      if (!encloses(polygon.border, inside)) continue;
      if (owner == nullptr || signed_area_m2(polygon.border) < signed_area_m2(owner->border)) owner = &polygon;
    }
    ENSURE(owner != nullptr, hole.size());
    owner->holes.push_back(std::move(hole));
  }
  return region;
}

Region visible_from(const OccupancyView& view, const Vector3& p_local_m, double range_m, int num_rays) {
  Polygon seen;
  seen.border.reserve(static_cast<std::size_t>(num_rays));
  for (int i = 0; i < num_rays; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / num_rays;
    const Vector3 direction(elementary::cos(angle), elementary::sin(angle), 0.0);
    const auto hit = view.first_hit(p_local_m, p_local_m + range_m * direction);
    seen.border.emplace_back((p_local_m + (hit ? hit->distance_m : range_m) * direction).head<2>());
  }
  return union_of(std::vector<Region>{{seen}});
}

Pole pole_of_inaccessibility(const Polygon& polygon, double precision_m) {
  ENSURE(polygon.border.size() >= 3 && precision_m > 0.0, polygon.border.size(), precision_m);
  struct Square {
    Vector2d middle;
    double half, depth;
    double most() const { return depth + half * std::numbers::sqrt2; }  // that any point of it can have
    bool operator<(const Square& other) const { return most() < other.most(); }
  };
  const auto square = [&](const Vector2d& middle, double half) {
    return Square{middle, half, depth_m(polygon, middle)};
  };
  Vector2d low = polygon.border.front(), high = low, centroid = Vector2d::Zero();
  double twice_area = 0.0;
  for (std::size_t i = 0; i < polygon.border.size(); ++i) {
    const Vector2d &a = polygon.border[i], &b = polygon.border[(i + 1) % polygon.border.size()];
    low = low.cwiseMin(a), high = high.cwiseMax(a);
    const double cross = a.x() * b.y() - a.y() * b.x();
    centroid += cross * (a + b);
    twice_area += cross;
  }
  Square best = square(0.5 * (low + high), 0.0);
  if (twice_area != 0.0) {
    const Square middle = square(centroid / (3.0 * twice_area), 0.0);
    if (middle.depth > best.depth) best = middle;
  }
  const double edge = (high - low).minCoeff();
  if (!(edge > 0.0)) return {best.middle, best.depth};
  std::priority_queue<Square> open;
  const int cols = static_cast<int>(std::ceil((high.x() - low.x()) / edge)),
            rows = static_cast<int>(std::ceil((high.y() - low.y()) / edge));
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x) open.push(square(low + edge * Vector2d(x + 0.5, y + 0.5), 0.5 * edge));
  }
  while (!open.empty()) {
    const Square next = open.top();
    open.pop();
    if (next.depth > best.depth) best = next;
    if (next.most() - best.depth <= precision_m) break;
    const double half = 0.5 * next.half;
    for (const Vector2d& to :
         {Vector2d(-half, -half), Vector2d(half, -half), Vector2d(-half, half), Vector2d(half, half)}) {
      open.push(square(next.middle + to, half));
    }
  }
  return {best.middle, best.depth};
}

}  // namespace swiftlet
