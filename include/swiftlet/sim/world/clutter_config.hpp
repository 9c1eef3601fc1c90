// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// One thing at a chosen place.
struct ClutterThingConfig {
  enum class Kind { kPost, kPerson, kSign };
  Kind kind = Kind::kPost;
  Eigen::Vector2d position_m = {2.0, 0.0};  ///< world frame; its foot is on the ground
  double yaw_deg = 0.0;
  double scale = 1.0;  ///< size factor; a post is 0.4 m wide and 0.95 m high, a person 1.75 m, a sign 2.4 m

  void visit(ConfigVisitor& v);
};

/// Things that stand around where people work: posts whose foot is below a LiDAR's field of view, standing people, and
/// retro-reflective signs on thin dark poles, whose boards seem to float. Random ones stand in a ring around
/// `center_m`.
struct ClutterConfig {
  std::vector<ClutterThingConfig> things;
  int num_posts = 0;
  int num_people = 0;
  int num_signs = 0;
  Eigen::Vector2d center_m = Eigen::Vector2d::Zero();
  double radius_min_m = 2.0;
  double radius_max_m = 30.0;

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
