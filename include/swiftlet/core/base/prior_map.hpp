// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/counter.hpp"

namespace swiftlet {

/// Prior knowledge of the world [Vrba 2025, sec. III-E]: points of occupied and of free voxels, world frame.
struct PriorMap {
  std::vector<Eigen::Vector3f> occupied_world_m;
  std::vector<Eigen::Vector3f> free_world_m;
  std::vector<Counter> counters;  ///< points of the files that were left out; settings relative to the detector's own
};

/// Sources of the prior map; none by default.
struct PriorConfig {
  std::string occupied;
  std::string free;
  std::string recorded;
  std::string mesh;
  bool world = false;

  void visit(ConfigVisitor& v) {
    v.file("occupied", occupied,
           "point cloud (PCD, PLY) of occupied voxels, or those of an octree (OctoMap's .bt, .ot), world frame");
    v.file("free", free, "point cloud of free voxels, one point in each, or those of an octree");
    v.file(
        "recorded", recorded,
        "finished run: pcd_index.csv or ply_index.csv of a recorder with `frame: world`; all its points are occupied");
    v.file("mesh", mesh, "mesh (OBJ, PLY, STL) whose surface is occupied, world frame");
    v.field("world", world, "[-] the scenario's own world is known");
  }
};

}  // namespace swiftlet
