// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/counter.hpp"

namespace swiftlet {

/// Prior knowledge of the world [Vrba 2025, sec. III-E]: points in occupied and in free voxels, world frame.
struct PriorMap {
  std::vector<Eigen::Vector3f> occupied_world_m;
  std::vector<Eigen::Vector3f> free_world_m;
  std::vector<Counter> counters;  ///< numbers of invalid parts of the files; settings relative to the detector
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
           "point cloud (PCD, PLY) whose points lie in occupied voxels, or octree (OctoMap's .bt, .ot), of which the "
           "occupied voxels are used; world frame");
    v.file("free", free,
           "point cloud with a point in each free voxel, or octree, of which the free voxels are used; world frame");
    v.file("recorded", recorded,
           "pcd_index.csv or ply_index.csv of a finished run, by a recorder with `frame: world`; voxels with a "
           "recorded point are occupied");
    v.file("mesh", mesh, "mesh (OBJ, PLY, STL) whose surface is occupied, world frame");
    v.field("world", world, "[-] whether the surfaces of the scenario's world are occupied in the prior map");
  }
};

}  // namespace swiftlet
