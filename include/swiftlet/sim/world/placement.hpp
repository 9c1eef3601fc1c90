// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/world/scene.hpp"

/// Placement of objects: spacing between them, and zones kept free for flights.
namespace swiftlet::sim {

struct TrailConfig {
  std::vector<Eigen::Vector3d> points_m;
  double width_m = 5.0;

  void visit(ConfigVisitor& v);
};

struct ClearingConfig {
  Eigen::Vector2d center_m = Eigen::Vector2d::Zero();
  double radius_m = 5.0;

  void visit(ConfigVisitor& v);
};

/// The `keep_clear` object of the forests: zones without stems, undergrowth, branches and crowns from the ground up to
/// clear_height_m above the highest ground.
struct KeepClearConfig {
  std::vector<TrailConfig> trails;
  std::vector<ClearingConfig> clearings;
  double clear_height_m = 6.0;

  void visit(ConfigVisitor& v);
  /// Horizontal distance from a point to the edge of the nearest zone, negative inside; +infinity without zones [m].
  double distance_m(const Eigen::Vector2d& point_world_m) const;
};

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
