// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "sim/render/cameras.hpp"
#include "sim/render/gl_objects_internal.hpp"
#include "sim/render/render_mesh.hpp"

namespace swiftlet::sim {

/// Shading model of a surface.
enum class SurfaceKind { kPlain = 0, kGround = 1, kPlant = 2, kShiny = 3 };

/// Attributes of the mesh shader that are constant per instance.
struct InstanceAttributes {
  Eigen::Matrix<float, 3, 4, Eigen::RowMajor> T_world_mesh;
  Eigen::Vector4f color;  ///< linear color, and the SurfaceKind
};

/// Declares the attributes of RenderVertex for the bound vertex array and buffer.
void mesh_attributes(const GlFunctions& gl);

struct DrawSelection {
  Frustum frustum;
  Eigen::Vector3f eye_world_m = Eigen::Vector3f::Zero();
  float pixels_at_1m = 1000.0F;
  bool parallel = false;
  bool cull = true;
  bool reduce = true;
  float cut_m = 1e9F;
};

/// GPU representation of the static world: uploaded once, drawn in chunks that are culled individually.
class WorldPainter {
 public:
  WorldPainter(const GlFunctions& gl, const Scene& scene);

  /// Draws with the current program (mesh, depth or ghost), whose uniforms, except those of leaves, must be set.
  void draw(const Program& program, const DrawSelection& selection) const;
  /// Bounds of shadow casters: everything except the ground.
  const Eigen::AlignedBox3f& casters_m() const { return casters_m_; }

 private:
  struct PlacedMesh {
    std::vector<RenderChunk> chunks;
    float leaf_size_m = 0.0F;
    float branch_thickness_m = 0.0F;
    std::uint32_t first_instance = 0;
    std::vector<Eigen::Affine3f> T_world_mesh;
    GLint base_vertex = 0;
    std::uint32_t first_index = 0;
  };
  struct Batch {
    const PlacedMesh* mesh;
    const RenderChunk* chunk;
    std::uint32_t instance;
    float nearest_m;
  };
  std::vector<Batch> select(const DrawSelection& selection) const;

  const GlFunctions& gl_;
  VertexBuffer vertices_;
  std::vector<PlacedMesh> meshes_;
  Eigen::AlignedBox3f casters_m_;
};

}  // namespace swiftlet::sim
