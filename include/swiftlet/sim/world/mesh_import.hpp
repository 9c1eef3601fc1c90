// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Surface of the parts of a file: the first rule whose `name` occurs in the name of a mesh or of its material applies.
struct SurfaceRuleConfig {
  std::string name;
  std::string surface_class = "object";
  double reflectivity = 0.3;
  bool retroreflective = false;

  void visit(ConfigVisitor& v);
};

/// A world from an OBJ, PLY or STL file. A mesh named <class>_<instance>..., as `swiftlet world` exports them, keeps
/// class and instance; the others are numbered.
struct MeshImportConfig : ModuleConfigOf<MeshImportConfig> {
  std::string file;
  enum class UpAxis { kZ, kY };
  UpAxis up_axis = UpAxis::kZ;
  double scale = 1.0;
  double yaw_deg = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::string surface_class = "building";
  double reflectivity = 0.35;
  std::vector<SurfaceRuleConfig> surfaces;

  void visit(ConfigVisitor& v) override;
};

Scene make_mesh_import(const MeshImportConfig& config, std::uint64_t seed);

}  // namespace swiftlet::sim
