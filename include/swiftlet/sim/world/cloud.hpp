// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// A world from a point cloud: voxels that hold enough points are solid cubes; only their outer faces are kept.
struct CloudConfig : ModuleConfigOf<CloudConfig> {
  std::string file;
  double leaf_m = 0.2;
  int min_points = 1;
  double scale = 1.0;
  double yaw_deg = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::string surface_class = "unlabeled";
  double reflectivity = 0.4;

  void visit(ConfigVisitor& v) override;
};

Scene make_cloud(const CloudConfig& config, std::uint64_t seed);

/// Faces between a voxel with at least `min_points` points and one without, merged into rectangles; voxel (0, 0, 0)
/// begins at the origin. Throws InputError when a point lies 2^20 - 2 voxels or more from the origin along an axis; the
/// caller adds the file's name to the message. Any frame, the same for all arguments.
Mesh voxelize(std::span<const Eigen::Vector3d> points_m, double leaf_m, int min_points);

}  // namespace swiftlet::sim
