// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/plane_region.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <polyclipping/clipper.hpp>
#include <queue>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

namespace clip = ClipperLib;

/// [m] unit of the integer coordinates. Larger values round borders more, smaller ones reduce the largest coordinate.
constexpr double kUnit_m = 1e-6;
/// [m] largest coordinate: products of differences fit into 64 bits.
constexpr double kFarthest_m = 1000.0;

clip::Path to_clipper(const Ring& ring_m) {
  clip::Path path;
  path.reserve(ring_m.size());
  for (const Vector2& p : ring_m) {
    ENSURE(std::abs(p.x()) < kFarthest_m && std::abs(p.y()) < kFarthest_m, p.x(), p.y());
    path.emplace_back(std::llround(p.x() / kUnit_m), std::llround(p.y() / kUnit_m));
  }
  return path;
}

clip::Paths to_clipper(const PlaneRegion& region) {
  clip::Paths paths;
  paths.reserve(region.rings_m.size());
  for (const Ring& ring : region.rings_m) paths.push_back(to_clipper(ring));
  return paths;
}

Ring from_clipper(const clip::Path& path) {
  Ring ring;
  ring.reserve(path.size());
  for (const clip::IntPoint& p : path) {
    ring.emplace_back(static_cast<double>(p.X) * kUnit_m, static_cast<double>(p.Y) * kUnit_m);
  }
  return ring;
}

PlaneRegion from_clipper(const clip::Paths& paths) {
  PlaneRegion region;
  region.rings_m.reserve(paths.size());
  for (const clip::Path& path : paths) region.rings_m.push_back(from_clipper(path));
  return region;
}

PlaneRegion clipped(clip::ClipType type, const clip::Paths& subject, const clip::Paths& clipping) {
  if (subject.empty()) return {};  // Clipper reports an empty subject as a failure
  clip::Clipper clipper;
  clipper.StrictlySimple(true);
  clipper.AddPaths(subject, clip::ptSubject, true);
  clipper.AddPaths(clipping, clip::ptClip, true);
  clip::Paths result;
  ENSURE(clipper.Execute(type, result, clip::pftNonZero, clip::pftNonZero), subject.size(), clipping.size());
  return from_clipper(result);
}

double ring_area_m2(const Ring& ring) {
  double twice_m2 = 0.0;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    twice_m2 += ring[j].x() * ring[i].y() - ring[i].x() * ring[j].y();
  }
  return 0.5 * twice_m2;
}

/// Calls `each` with both ends of every edge.
void each_edge(const PlaneRegion& region, auto&& each) {
  for (const Ring& ring : region.rings_m) {
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) each(ring[j], ring[i]);
  }
}

double distance_to_edge_m(const Vector2& a, const Vector2& b, const Vector2& p) {
  const Vector2 edge = b - a;
  const double length2 = edge.squaredNorm();
  const double share = length2 > 0.0 ? std::clamp((p - a).dot(edge) / length2, 0.0, 1.0) : 0.0;
  return (p - a - share * edge).norm();
}

/// Polygon around all points within a radius of a segment: half a circumscribed polygon at each end.
Ring capsule(const Vector2& a, const Vector2& b, double radius_m) {
  constexpr int kHalf = 16;  // corners of half a turn
  const double out_m = radius_m / elementary::cos(std::numbers::pi / (2.0 * kHalf));
  const Vector2 along = b - a;
  const double heading = along.squaredNorm() > 0.0 ? elementary::atan2(along.y(), along.x()) : 0.0;
  Ring ring;
  ring.reserve(2 * kHalf);
  for (int k = 0; k < 2 * kHalf; ++k) {
    const double angle = heading + std::numbers::pi * ((k + 0.5) / kHalf - 0.5);
    ring.push_back((k < kHalf ? b : a) + out_m * Vector2(elementary::cos(angle), elementary::sin(angle)));
  }
  return ring;
}

/// A square that may hold the pole, with an upper bound on the distance of its points.
struct Square {
  Vector2 center_m;
  double half_m;
  double distance_m;  // signed: negative outside
  double at_most_m() const { return distance_m + half_m * std::numbers::sqrt2; }
  bool operator<(const Square& other) const { return at_most_m() < other.at_most_m(); }
};

double signed_distance_m(const PlaneRegion& region, const Vector2& p_m) {
  const double distance = distance_to_border_m(region, p_m);
  return contains(region, p_m) ? distance : -distance;
}

}  // namespace

PlaneRegion inside_of(const Ring& ring_m) {
  if (ring_m.size() < 3) return {};
  return clipped(clip::ctUnion, {to_clipper(ring_m)}, {});
}

PlaneRegion union_of(std::span<const PlaneRegion> regions) {
  clip::Paths all;
  for (const PlaneRegion& region : regions) {
    const clip::Paths paths = to_clipper(region);
    all.insert(all.end(), paths.begin(), paths.end());
  }
  return clipped(clip::ctUnion, all, {});
}

PlaneRegion intersection_of(const PlaneRegion& a, const PlaneRegion& b) {
  return clipped(clip::ctIntersection, to_clipper(a), to_clipper(b));
}

PlaneRegion difference_of(const PlaneRegion& a, const PlaneRegion& b) {
  return clipped(clip::ctDifference, to_clipper(a), to_clipper(b));
}

PlaneRegion around_path(std::span<const Vector2> path_m, double distance_m) {
  clip::Paths capsules;
  if (path_m.size() == 1) capsules.push_back(to_clipper(capsule(path_m[0], path_m[0], distance_m)));
  for (std::size_t i = 1; i < path_m.size(); ++i) {
    capsules.push_back(to_clipper(capsule(path_m[i - 1], path_m[i], distance_m)));
  }
  return clipped(clip::ctUnion, capsules, {});
}

PlaneRegion region_of(const CellMask& mask) {
  clip::Paths runs;
  for (int row = 0; row < mask.rows; ++row) {
    for (int column = 0; column < mask.columns;) {
      if (!mask.at(column, row)) {
        ++column;
        continue;
      }
      const int first = column;
      while (column < mask.columns && mask.at(column, row)) ++column;
      const auto corner = [&](int i, int j) { return Vector2(mask.origin_m + mask.edge_m * Vector2(i, j)); };
      runs.push_back(
          to_clipper({corner(first, row), corner(column, row), corner(column, row + 1), corner(first, row + 1)}));
    }
  }
  return clipped(clip::ctUnion, runs, {});
}

void mark_inside(const PlaneRegion& region, CellMask& mask) {
  // Scan lines through the cell centers: the inside lies between odd and even crossings.
  std::vector<std::vector<double>> crossings_m(static_cast<std::size_t>(mask.rows));
  each_edge(region, [&](const Vector2& a, const Vector2& b) {
    const auto [low, high] = std::minmax(a.y(), b.y());
    const auto row_from = [&](double y) { return (y - mask.origin_m.y()) / mask.edge_m - 0.5; };
    const int first = static_cast<int>(std::clamp(std::ceil(row_from(low)), 0.0, 1.0 * mask.rows));
    const int end = static_cast<int>(std::clamp(std::ceil(row_from(high)), 0.0, 1.0 * mask.rows));
    for (int row = first; row < end; ++row) {
      const double y = mask.center_m(0, row).y();
      crossings_m[static_cast<std::size_t>(row)].push_back(a.x() + (b.x() - a.x()) * ((y - a.y()) / (b.y() - a.y())));
    }
  });
  for (int row = 0; row < mask.rows; ++row) {
    std::vector<double>& x_m = crossings_m[static_cast<std::size_t>(row)];
    std::sort(x_m.begin(), x_m.end());
    for (std::size_t i = 0; i + 1 < x_m.size(); i += 2) {
      const auto column_from = [&](double x) {
        return static_cast<int>(
            std::clamp(std::ceil((x - mask.origin_m.x()) / mask.edge_m - 0.5), 0.0, 1.0 * mask.columns));
      };
      for (int column = column_from(x_m[i]), end = column_from(x_m[i + 1]); column < end; ++column) {
        mask.at(column, row) = 1;
      }
    }
  }
}

std::vector<PlaneRegion> parts_of(const PlaneRegion& region) {
  if (region.empty()) return {};
  clip::Clipper clipper;
  clipper.StrictlySimple(true);
  clipper.AddPaths(to_clipper(region), clip::ptSubject, true);
  clip::PolyTree tree;
  ENSURE(clipper.Execute(clip::ctUnion, tree, clip::pftNonZero, clip::pftNonZero), region.rings_m.size());
  std::vector<PlaneRegion> parts;
  for (const clip::PolyNode* node = tree.GetFirst(); node != nullptr; node = node->GetNext()) {
    if (node->IsHole()) continue;
    PlaneRegion& part = parts.emplace_back();
    part.rings_m.reserve(1 + node->Childs.size());
    part.rings_m.push_back(from_clipper(node->Contour));
    for (const clip::PolyNode* hole : node->Childs) part.rings_m.push_back(from_clipper(hole->Contour));
  }
  return parts;
}

double area_m2(const PlaneRegion& region) {
  double sum_m2 = 0.0;
  for (const Ring& ring : region.rings_m) sum_m2 += ring_area_m2(ring);
  return sum_m2;
}

bool contains(const PlaneRegion& region, const Vector2& p_m) {
  bool inside = false;
  each_edge(region, [&](const Vector2& a, const Vector2& b) {
    if ((a.y() > p_m.y()) == (b.y() > p_m.y())) return;
    if (p_m.x() < a.x() + (b.x() - a.x()) * ((p_m.y() - a.y()) / (b.y() - a.y()))) inside = !inside;
  });
  return inside;
}

double distance_to_border_m(const PlaneRegion& region, const Vector2& p_m) {
  double least_m = std::numeric_limits<double>::infinity();
  each_edge(region,
            [&](const Vector2& a, const Vector2& b) { least_m = std::min(least_m, distance_to_edge_m(a, b, p_m)); });
  return least_m;
}

Pole pole_of_inaccessibility(const PlaneRegion& region, double precision_m) {
  ENSURE(!region.empty() && precision_m > 0.0, region.rings_m.size(), precision_m);
  Eigen::AlignedBox2d box;
  each_edge(region, [&](const Vector2& a, const Vector2&) { box.extend(a); });
  const double edge_m = std::max(box.sizes().minCoeff(), precision_m);
  std::priority_queue<Square> open;
  const auto open_square = [&](const Vector2& center_m, double half_m) {
    open.push({center_m, half_m, signed_distance_m(region, center_m)});
  };
  const Eigen::Vector2i num = (box.sizes() / edge_m).array().ceil().cast<int>().max(1);
  for (int i = 0; i < num.x(); ++i) {
    for (int j = 0; j < num.y(); ++j) open_square(box.min() + edge_m * Vector2(i + 0.5, j + 0.5), 0.5 * edge_m);
  }
  Square best = open.top();
  while (!open.empty()) {
    const Square square = open.top();
    open.pop();
    if (square.distance_m > best.distance_m) best = square;
    // The remaining squares are bounded by the same value.
    if (square.at_most_m() - best.distance_m <= precision_m) break;
    const double quarter_m = 0.5 * square.half_m;
    for (const double dx_m : {-quarter_m, quarter_m}) {
      for (const double dy_m : {-quarter_m, quarter_m}) open_square(square.center_m + Vector2(dx_m, dy_m), quarter_m);
    }
  }
  return {best.center_m, best.distance_m};
}

}  // namespace swiftlet
