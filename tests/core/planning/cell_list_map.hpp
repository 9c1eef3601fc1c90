// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet::testing {

/// A map as a list of occupied cells, searched linearly; otherwise free inside a box, unknown outside.
class CellListMap : public OccupancyView {
 public:
  /// @param centers_local_m  of occupied cells, on any lattice
  explicit CellListMap(double edge_m = 0.1, std::vector<Vector3> centers_local_m = {})
      : edge_m_(edge_m), centers_local_m_(std::move(centers_local_m)) {}

  void occupy_box(const Vector3& min_local_m, const Vector3& max_local_m) {
    ++revision_;
    const auto cell = [&](double m) { return static_cast<int>(std::floor(m / edge_m_ + 1e-9)); };
    for (int x = cell(min_local_m.x()); x < cell(max_local_m.x()); ++x) {
      for (int y = cell(min_local_m.y()); y < cell(max_local_m.y()); ++y) {
        for (int z = cell(min_local_m.z()); z < cell(max_local_m.z()); ++z) {
          centers_local_m_.push_back(edge_m_ * Vector3(x + 0.5, y + 0.5, z + 0.5));
        }
      }
    }
  }
  double known_within_m = std::numeric_limits<double>::infinity();  ///< half edge of the known box around the origin

  double edge_m() const override { return edge_m_; }
  CellState state(const Vector3& p_local_m) const override {
    if (p_local_m.cwiseAbs().maxCoeff() > known_within_m) return CellState::kUnknown;
    return distance_m(p_local_m, 1.0) > 0.0 ? CellState::kFree : CellState::kOccupied;
  }
  void occupied_within(const Vector3& center_local_m, double radius_m, TimeNs,
                       std::vector<Vector3>& centers_local_m) const override {
    centers_local_m.clear();
    for (const Vector3& c : centers_local_m_) {
      if (distance_to(c, center_local_m) <= radius_m) centers_local_m.push_back(c);
    }
  }
  void occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                   std::vector<Vector3>& centers_local_m) const override {
    centers_local_m.clear();
    for (const Vector3& c : centers_local_m_) {
      const bool reaches =
          ((c - min_local_m).array() >= -0.5 * edge_m_).all() && ((max_local_m - c).array() >= -0.5 * edge_m_).all();
      if (reaches) centers_local_m.push_back(c);
    }
  }
  double distance_m(const Vector3& p_local_m, double max_m) const override {
    double least_m = max_m;
    for (const Vector3& c : centers_local_m_) least_m = std::min(least_m, distance_to(c, p_local_m));
    return least_m;
  }
  std::optional<SegmentHit> first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const override {
    const double length_m = (to_local_m - from_local_m).norm();
    std::optional<SegmentHit> first;
    for (const Vector3& c : centers_local_m_) {
      const double enters = entry(c, from_local_m, to_local_m) * length_m;
      if (enters <= length_m && (!first || enters < first->distance_m)) first = SegmentHit{enters, c};
    }
    return first;
  }
  std::uint64_t revision() const override { return revision_; }
  bool changed_since(std::uint64_t, std::vector<VoxelGrid>&) const override { return false; }

 private:
  double distance_to(const Vector3& center_local_m, const Vector3& p_local_m) const {
    return ((p_local_m - center_local_m).cwiseAbs().array() - 0.5 * edge_m_).max(0.0).matrix().norm();
  }
  /// Share of the segment before the cell; 2 when it is not met.
  double entry(const Vector3& c, const Vector3& from_local_m, const Vector3& to_local_m) const {
    double first = 0.0, last = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double along = to_local_m[axis] - from_local_m[axis], off = c[axis] - from_local_m[axis];
      if (std::abs(along) < 1e-12) {
        if (std::abs(off) > 0.5 * edge_m_ + 1e-12) return 2.0;
        continue;
      }
      const double a = (off - 0.5 * edge_m_) / along, b = (off + 0.5 * edge_m_) / along;
      first = std::max(first, std::min(a, b));
      last = std::min(last, std::max(a, b));
    }
    return first <= last ? first : 2.0;
  }

  double edge_m_;
  std::vector<Vector3> centers_local_m_;
  std::uint64_t revision_ = 1;
};

}  // namespace swiftlet::testing
