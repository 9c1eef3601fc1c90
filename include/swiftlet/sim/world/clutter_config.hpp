// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// One clutter object at a given position.
struct ClutterThingConfig {
  enum class Kind { kPost, kPerson, kSign };
  Kind kind = Kind::kPost;
  Eigen::Vector2d position_m = {2.0, 0.0};  ///< world frame; the object stands on the ground
  double yaw_deg = 0.0;
  /// [-] Size factor. At 1, a post is 0.4 m wide and 0.95 m high, a person 1.75 m high and a sign 2.4 m high.
  double scale = 1.0;

  void visit(ConfigVisitor& v);
};

/// Clutter of a work site that can be mistaken for flying objects: posts whose lower part is below a LiDAR's field of
/// view, standing people, and retro-reflective signs on thin dark poles that hardly return. Random objects stand in a
/// ring around `center_m`, as many as fit.
struct ClutterConfig {
  std::vector<ClutterThingConfig> things;  ///< objects at given positions
  int num_posts = 0;
  int num_people = 0;
  int num_signs = 0;
  Eigen::Vector2d center_m = Eigen::Vector2d::Zero();
  double radius_min_m = 2.0;   ///< inner radius of the ring
  double radius_max_m = 30.0;  ///< outer radius of the ring

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
