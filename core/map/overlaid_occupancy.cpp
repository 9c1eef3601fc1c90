// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/overlaid_occupancy.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

/// Interval of the segment parameter, 0 to 1, inside a body; cuts only shrink it.
struct Inside {
  double first = 0.0, last = 1.0;
  bool empty() const { return first > last; }
  void cut_by_slab(double at, double displacement, double half) {
    if (displacement == 0.0) {
      if (std::abs(at) > half) last = -1.0;
      return;
    }
    const double a = (-half - at) / displacement, b = (half - at) / displacement;
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  void cut_by_circle(const Eigen::Vector2d& at, const Eigen::Vector2d& displacement, double radius) {
    const double a = displacement.squaredNorm(), b = at.dot(displacement), c = at.squaredNorm() - radius * radius;
    if (a == 0.0) {
      if (c > 0.0) last = -1.0;
      return;
    }
    const double discriminant = b * b - a * c;
    if (discriminant < 0.0) {
      last = -1.0;
      return;
    }
    const double root = std::sqrt(discriminant);
    first = std::max(first, (-b - root) / a);
    last = std::min(last, (-b + root) / a);
  }
};

}  // namespace

double KeepOut::distance_m(const Vector3& p_local_m) const {
  const Vector3 to = p_local_m - center_local_m;
  if (shape == Shape::kBox) return (to.cwiseAbs() - 0.5 * size_m).cwiseMax(0.0).norm();
  const double aside = std::max(to.head<2>().norm() - 0.5 * size_m.x(), 0.0);
  const double above = std::max(std::abs(to.z()) - 0.5 * size_m.z(), 0.0);
  return std::sqrt(aside * aside + above * above);
}

std::optional<double> KeepOut::entered_after_m(const Vector3& from_local_m, const Vector3& to_local_m) const {
  const Vector3 at = from_local_m - center_local_m, displacement = to_local_m - from_local_m;
  Inside inside;
  inside.cut_by_slab(at.z(), displacement.z(), 0.5 * size_m.z());
  if (shape == Shape::kBox) {
    inside.cut_by_slab(at.x(), displacement.x(), 0.5 * size_m.x());
    inside.cut_by_slab(at.y(), displacement.y(), 0.5 * size_m.y());
  } else {
    inside.cut_by_circle(at.head<2>(), displacement.head<2>(), 0.5 * size_m.x());
  }
  if (inside.empty()) return std::nullopt;
  return inside.first * displacement.norm();
}

CellState OverlaidOccupancy::state(const Vector3& p_local_m) const {
  const Vector3 center_local_m = center_of_cell(p_local_m);
  for (const KeepOut& keep_out : keep_outs_) {
    if (keep_out.contains(center_local_m)) return CellState::kOccupied;
  }
  return map_.state(p_local_m);
}

template <class Accept>
void OverlaidOccupancy::append_cells(const Vector3& min_local_m, const Vector3& max_local_m,
                                     std::vector<Vector3>& centers_local_m, Accept&& accept) const {
  const double edge = edge_m();
  for (std::size_t i = 0; i < keep_outs_.size(); ++i) {
    const KeepOut& keep_out = keep_outs_[i];
    const Vector3 low_local_m = min_local_m.cwiseMax(keep_out.center_local_m - 0.5 * keep_out.size_m);
    const Vector3 high_local_m = max_local_m.cwiseMin(keep_out.center_local_m + 0.5 * keep_out.size_m);
    const Cell low = (low_local_m.array() / edge).floor().cast<int>(),
               high = (high_local_m.array() / edge).floor().cast<int>();
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) {
          const Vector3 cell_local_m = (Eigen::Array3d(x, y, z) + 0.5) * edge;
          if (!keep_out.contains(cell_local_m) || !accept(cell_local_m)) continue;
          const bool listed = std::any_of(keep_outs_.begin(), keep_outs_.begin() + static_cast<std::ptrdiff_t>(i),
                                          [&](const KeepOut& other) { return other.contains(cell_local_m); });
          if (!listed && map_.state(cell_local_m) != CellState::kOccupied) centers_local_m.push_back(cell_local_m);
        }
      }
    }
  }
}

void OverlaidOccupancy::occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                                        std::vector<Vector3>& centers_local_m) const {
  map_.occupied_within(center_local_m, radius_m, since, centers_local_m);
  const double half_m = 0.5 * edge_m();
  append_cells(center_local_m.array() - radius_m - edge_m(), center_local_m.array() + radius_m + edge_m(),
               centers_local_m, [&](const Vector3& cell_local_m) {
                 const Vector3 gap = ((cell_local_m - center_local_m).array().abs() - half_m).cwiseMax(0.0);
                 return gap.squaredNorm() <= radius_m * radius_m;
               });
}

void OverlaidOccupancy::occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                                    std::vector<Vector3>& centers_local_m) const {
  map_.occupied_in(min_local_m, max_local_m, centers_local_m);
  const double half_m = 0.5 * edge_m();
  append_cells(min_local_m, max_local_m, centers_local_m, [&](const Vector3& cell_local_m) {
    return (cell_local_m.array() + half_m >= min_local_m.array()).all() &&
           (cell_local_m.array() - half_m <= max_local_m.array()).all();
  });
}

double OverlaidOccupancy::distance_m(const Vector3& p_local_m, double max_m) const {
  double least_m = map_.distance_m(p_local_m, max_m);
  for (const KeepOut& keep_out : keep_outs_) least_m = std::min(least_m, keep_out.distance_m(p_local_m));
  return least_m;
}

double OverlaidOccupancy::clearance_m(const Vector3& p_local_m, double max_m) const {
  double least_m = map_.clearance_m(p_local_m, max_m);
  const Vector3 center_local_m = center_of_cell(p_local_m);
  for (const KeepOut& keep_out : keep_outs_) least_m = std::min(least_m, keep_out.distance_m(center_local_m));
  return least_m;
}

std::optional<SegmentHit> OverlaidOccupancy::first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const {
  std::optional<SegmentHit> first = map_.first_hit(from_local_m, to_local_m);
  const double length_m = (to_local_m - from_local_m).norm();
  for (const KeepOut& keep_out : keep_outs_) {
    const std::optional<double> hit_distance_m = keep_out.entered_after_m(from_local_m, to_local_m);
    if (!hit_distance_m || (first && first->distance_m <= *hit_distance_m)) continue;
    const double part = length_m > 0.0 ? *hit_distance_m / length_m : 0.0;
    first = SegmentHit{*hit_distance_m, center_of_cell(from_local_m + part * (to_local_m - from_local_m))};
  }
  return first;
}

}  // namespace swiftlet
