// SPDX-License-Identifier: BSD-3-Clause
#include "core/planning/guiding_viewpoint.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

/// Lengths along a line of sight, in cell edges.
struct SightConstants {
  /// Diagonal of a cell, rounded up: bound of the difference between a clearance and the true distance.
  static constexpr double kDiagonal = 1.7321;
  /// Least step by clearance. Near obstacles, cells are tested one by one over a length of kWalked. Both affect time
  /// alone.
  static constexpr double kMinStep = 2.0, kWalked = 4.0;
};

/// A point of a region and its distance from the guide.
struct Candidate {
  Vector2 p_local_m;
  double distance_m;
};

class ViewpointSearch {
 public:
  ViewpointSearch(const OccupancyView& map, const Vector3& watcher_local_m, std::span<const Vector3> path_local_m,
                  const ViewpointRules& rules, std::span<const Vector3> before_local_m,
                  std::span<const KeepOut> keep_outs)
      : map_(map),
        safe_map_(map, {keep_outs.begin(), keep_outs.end()}),
        watcher_local_m_(watcher_local_m),
        path_local_m_(path_local_m),
        before_local_m_(before_local_m),
        rules_(rules) {}

  GuidingViewpoints run() {
    see_waypoints();
    GuidingViewpoints found;
    std::vector<std::pair<double, GuidingViewpoint>> by_distance;
    for (const PlaneRegion& safe : safe_parts()) {
      GuidingViewpoint viewpoint = overlap_from(safe, 0);
      for (std::size_t first = 1; viewpoint.num_visible == 0 && rules_.unseen_start && first < visible_.size();
           ++first) {
        viewpoint = overlap_from(safe, first);
      }
      if (viewpoint.num_visible == 0) continue;
      const Candidate pole = closest_pole(viewpoint.overlap);
      viewpoint.p_local_m = {pole.p_local_m.x(), pole.p_local_m.y(), watcher_local_m_.z()};
      by_distance.emplace_back(pole.distance_m, std::move(viewpoint));
    }
    std::stable_sort(by_distance.begin(), by_distance.end(), [](const auto& a, const auto& b) {
      return std::tuple(a.second.first_visible, -a.second.num_visible, a.first) <
             std::tuple(b.second.first_visible, -b.second.num_visible, b.first);
    });
    found.best_first.reserve(by_distance.size());
    for (auto& [distance_m, viewpoint] : by_distance) found.best_first.push_back(std::move(viewpoint));
    found.visible = std::move(visible_);
    return found;
  }

 private:
  /// V_all and S: lines 1 to 14.
  void see_waypoints() {
    std::vector<Vector2> path_plane_local_m;
    path_plane_local_m.reserve(path_local_m_.size());
    for (const Vector3& p_local_m : path_local_m_) path_plane_local_m.push_back(p_local_m.head<2>());
    PlaneRegion buffer = around_path(path_plane_local_m, rules_.buffer_m);
    if (!before_local_m_.empty()) {
      std::vector<Vector2> before_plane_local_m;
      before_plane_local_m.reserve(before_local_m_.size());
      for (const Vector3& p_local_m : before_local_m_) before_plane_local_m.push_back(p_local_m.head<2>());
      const PlaneRegion both[] = {std::move(buffer), around_path(before_plane_local_m, rules_.buffer_m)};
      buffer = union_of(both);
    }

    safe_ = mask_around(path_plane_local_m);
    visible_.reserve(path_local_m_.size());
    if (rules_.sight == ViewpointRules::Sight::kAtWaypoint) {
      for (const Vector3& p_local_m : path_local_m_) {
        const Ring ring = visibility_ring(map_, p_local_m, rules_.ray_max_m, rules_.num_rays);
        visible_.push_back(difference_of(inside_of(ring), buffer));
        mark_inside(visible_.back(), safe_);
      }
      keep_safe(safe_);
      return;
    }
    CellMask allowed = safe_;  // cells within reach of a waypoint, outside the buffer, clear of obstacles
    for (const Vector2& p_local_m : path_plane_local_m) {
      mark_inside(difference_of(around_path(std::span(&p_local_m, 1), rules_.ray_max_m), buffer), allowed);
    }
    keep_safe(allowed);
    for (const Vector3& p_local_m : path_local_m_) {
      const CellMask seen = seen_in_space(p_local_m, allowed);
      visible_.push_back(region_of(seen));
      for (std::size_t i = 0; i < safe_.cells.size(); ++i) safe_.cells[i] |= seen.cells[i];
    }
  }

  /// Mask of all cells from which a waypoint may be seen, on the map's lattice.
  CellMask mask_around(const std::vector<Vector2>& path_local_m) const {
    Eigen::AlignedBox2d box;
    for (const Vector2& p_local_m : path_local_m) box.extend(p_local_m);
    const double edge_m = map_.edge_m();
    const auto lattice = [edge_m](const Vector2& p) { return Eigen::Array2d((p / edge_m).array().floor()); };
    const Vector2 reach_m = Vector2::Constant(rules_.ray_max_m + edge_m);
    const Eigen::Array2d first = lattice(box.min() - reach_m), last = lattice(box.max() + reach_m);
    CellMask mask;
    mask.edge_m = edge_m;
    mask.origin_m = edge_m * first.matrix();
    mask.columns = static_cast<int>(last.x() - first.x()) + 1;
    mask.rows = static_cast<int>(last.y() - first.y()) + 1;
    mask.cells.assign(static_cast<std::size_t>(mask.columns) * mask.rows, 0);
    return mask;
  }

  Vector3 at_watchers_height(const CellMask& mask, int column, int row) const {
    const Vector2 p_local_m = mask.center_m(column, row);
    return {p_local_m.x(), p_local_m.y(), watcher_local_m_.z()};
  }

  /// Line 13: farther than the clearance from obstacles.
  void keep_safe(CellMask& mask) const {
    for (int row = 0; row < mask.rows; ++row) {
      for (int column = 0; column < mask.columns; ++column) {
        char& cell = mask.at(column, row);
        if (!cell) continue;
        const Vector3 p_local_m = at_watchers_height(mask, column, row);
        const bool known = rules_.unknown_is_free || map_.state(p_local_m) != CellState::kUnknown;
        cell = static_cast<char>(known && safe_map_.clearance_m(p_local_m, rules_.clearance_m + map_.edge_m()) >
                                              rules_.clearance_m);
      }
    }
  }

  CellMask seen_in_space(const Vector3& waypoint_local_m, const CellMask& allowed) const {
    CellMask seen = allowed;
    for (int row = 0; row < seen.rows; ++row) {
      for (int column = 0; column < seen.columns; ++column) {
        char& cell = seen.at(column, row);
        if (!cell) continue;
        const Vector3 p_local_m = at_watchers_height(seen, column, row);
        const double distance_m = (p_local_m - waypoint_local_m).head<2>().norm();
        cell = static_cast<char>(distance_m <= rules_.ray_max_m && is_in_sight(p_local_m, waypoint_local_m));
      }
    }
    return seen;
  }

  /// No occupied cell on the straight line. Steps by the clearance where nothing is near: the distance between a point
  /// and the center of an occupied cell exceeds the true one by at most a cell's diagonal.
  bool is_in_sight(const Vector3& from_local_m, const Vector3& to_local_m) const {
    const double edge_m = map_.edge_m(), far_m = rules_.clearance_m + edge_m;
    const Vector3 displacement_m = to_local_m - from_local_m;
    const double length_m = displacement_m.norm();
    const Vector3 direction = displacement_m / length_m;
    double at_m = 0.0;
    while (at_m < length_m) {
      const Vector3 p_local_m = from_local_m + at_m * direction;
      const double free_m = map_.clearance_m(p_local_m, far_m) - SightConstants::kDiagonal * edge_m;
      if (free_m > SightConstants::kMinStep * edge_m) {
        at_m += free_m;
        continue;
      }
      const double next_m = std::min(length_m, at_m + SightConstants::kWalked * edge_m);
      if (map_.first_hit(p_local_m, from_local_m + next_m * direction)) return false;
      if (!rules_.unknown_is_free && passes_unknown(p_local_m, direction, next_m - at_m)) return false;
      at_m = next_m;
    }
    return true;
  }

  /// A wall seen at a grazing angle has holes in the map, but its inside is unknown.
  bool passes_unknown(const Vector3& from_local_m, const Vector3& direction, double length_m) const {
    const int steps = static_cast<int>(2.0 * length_m / map_.edge_m());
    for (int i = 0; i <= steps; ++i) {
      const Vector3 p_local_m = from_local_m + (0.5 * map_.edge_m() * i) * direction;
      if (map_.state(p_local_m) == CellState::kUnknown) return true;
    }
    return false;
  }

  /// The connected parts of S that count: line 15 and its other interpretation.
  std::vector<PlaneRegion> safe_parts() const {
    PlaneRegion safe = region_of(safe_);
    if (!before_local_m_.empty()) safe = difference_of(safe, around_path(long_chord(), 0.5 * map_.edge_m()));
    std::vector<PlaneRegion> parts = parts_of(safe);
    if (rules_.safe_space == ViewpointRules::SafeSpace::kMaxVisible || parts.size() < 2) return parts;
    const auto distance_m = [&](const PlaneRegion& part) {
      const Vector2 p_local_m = watcher_local_m_.head<2>();
      return contains(part, p_local_m) ? 0.0 : distance_to_border_m(part, p_local_m);
    };
    const auto closest = std::min_element(parts.begin(), parts.end(),
                                          [&](const auto& a, const auto& b) { return distance_m(a) < distance_m(b); });
    return {std::move(*closest)};
  }

  /// The line through the path's beginning and end, extended in both directions beyond the range of sight.
  std::array<Vector2, 2> long_chord() const {
    const Vector2 first_local_m = path_local_m_.front().head<2>(), last_local_m = path_local_m_.back().head<2>();
    const Vector2 displacement_m = last_local_m - first_local_m;
    const double more = 3.0 * rules_.ray_max_m / std::max(displacement_m.norm(), 1e-3);
    return {first_local_m - more * displacement_m, last_local_m + more * displacement_m};
  }

  /// Lines 16 to 24: intersection of as many visibility regions from `first` on as have a point in common.
  GuidingViewpoint overlap_from(const PlaneRegion& safe, std::size_t first) const {
    GuidingViewpoint found;
    found.safe = found.overlap = safe;
    found.first_visible = static_cast<int>(first);
    for (const PlaneRegion& visible : std::span(visible_).subspan(first)) {
      PlaneRegion common = intersection_of(found.overlap, visible);
      if (common.empty() || is_narrow(common)) break;
      found.overlap = std::move(common);
      ++found.num_visible;
    }
    return found;
  }

  /// True if the region is so narrow that a guide slightly off any viewpoint would leave the region.
  bool is_narrow(const PlaneRegion& region) const {
    return rules_.margin_m > 0.0 && pole_of_inaccessibility(region, 0.25 * map_.edge_m()).distance_m < rules_.margin_m;
  }

  /// Line 26: the pole closest to the guide among those of all polygons.
  Candidate closest_pole(const PlaneRegion& overlap) const {
    Candidate closest{Vector2::Zero(), std::numeric_limits<double>::infinity()};
    for (const PlaneRegion& part : parts_of(overlap)) {
      const Pole pole = pole_of_inaccessibility(part, 0.25 * map_.edge_m());
      const double distance_m = (pole.p_m - watcher_local_m_.head<2>()).norm();
      if (pole.distance_m >= rules_.margin_m && distance_m < closest.distance_m) closest = {pole.p_m, distance_m};
    }
    return closest;
  }

  const OccupancyView& map_;
  OverlaidOccupancy safe_map_;  // for clearance only: vehicles do not block the view
  Vector3 watcher_local_m_;
  std::span<const Vector3> path_local_m_, before_local_m_;
  const ViewpointRules& rules_;
  std::vector<PlaneRegion> visible_;
  CellMask safe_;
};

}  // namespace

Ring visibility_ring(const OccupancyView& map, const Vector3& p_local_m, double ray_max_m, int num_rays) {
  Ring ring;
  ring.reserve(static_cast<std::size_t>(num_rays));
  for (int k = 0; k < num_rays; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / num_rays;
    const Vector3 direction(elementary::cos(angle), elementary::sin(angle), 0.0);
    const std::optional<SegmentHit> hit = map.first_hit(p_local_m, p_local_m + ray_max_m * direction);
    const double length_m = hit ? std::min(hit->distance_m, ray_max_m) : ray_max_m;
    ring.push_back((p_local_m + length_m * direction).head<2>());
  }
  return ring;
}

GuidingViewpoints find_guiding_viewpoints(const OccupancyView& map, const Vector3& watcher_local_m,
                                          std::span<const Vector3> path_local_m, const ViewpointRules& rules,
                                          std::span<const Vector3> before_local_m, std::span<const KeepOut> keep_outs) {
  ENSURE(!path_local_m.empty() && rules.num_rays >= 3, path_local_m.size(), rules.num_rays);
  return ViewpointSearch(map, watcher_local_m, path_local_m, rules, before_local_m, keep_outs).run();
}

void ViewpointRules::visit(ConfigVisitor& v) {
  v.field("ray_max_m", ray_max_m, "[m] largest horizontal distance from which a waypoint is observed",
          Range{0.0, 200.0, true});
  v.field("margin_m", margin_m,
          "[m] radius around a viewpoint in which all positions see the same waypoints; 0: as in the document",
          Range::between(0.0, 10.0));
  v.field("unseen_start", unseen_start,
          "[-] whether the rest of the path is observed if no safe position sees its beginning; false: planning fails");
  v.choice("sight", sight, {"at_waypoint", "in_space"},
           "[-] visibility of a waypoint: in the plane at its height, or along the straight line");
  v.choice("safe_space", safe_space, {"closest", "most_visible"},
           "[-] connected safe space that is used: the closest, or the reachable one that sees most");
}

}  // namespace swiftlet
