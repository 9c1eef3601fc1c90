// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <unordered_map>

#include <Eigen/Core>

/// Placement of objects.
namespace swiftlet::sim {

/// Horizontal distance from a point to a segment [m].
double distance_to_segment_m(const Eigen::Vector2d& point_world_m, const Eigen::Vector2d& a_world_m,
                             const Eigen::Vector2d& b_world_m);

/// Keeps points at least `spacing_m` apart; a hash grid makes queries fast.
class Spacing {
 public:
  explicit Spacing(double spacing_m) : spacing_m_(spacing_m) {}
  /// Adds the point and returns true if no earlier one is nearer than the spacing.
  bool try_add(const Eigen::Vector2d& point_world_m);

 private:
  std::int64_t cell_of(double x_m, double y_m) const;

  double spacing_m_;
  std::unordered_multimap<std::int64_t, Eigen::Vector2d> points_;  // only for look-up, never iterated
};

}  // namespace swiftlet::sim
