// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/config.hpp"

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
  /// Horizontal distance [m] from a point to the edge of the nearest zone; negative inside, +infinity without zones.
  double distance_m(const Eigen::Vector2d& point_world_m) const;
};

}  // namespace swiftlet::sim
