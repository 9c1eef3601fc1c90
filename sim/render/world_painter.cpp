// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/world_painter.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/sim/render/colors.hpp"

namespace swiftlet::sim {
namespace {

// [px] Size below which leaves are thinned out. Larger values save time and show sparser crowns.
constexpr float kLeafPixels = 7.0F;
// [-] Least share of drawn leaves. At 0, distant crowns would vanish.
constexpr float kFewestLeaves = 0.1F;
// [px] Thickness below which branches are thinned out. Larger values save time and show fewer branches.
constexpr float kBranchPixels = 1.5F;
// [-] Least share of drawn branches. At 0, distant branches would vanish.
constexpr float kFewestBranches = 0.15F;

SurfaceKind kind_of(const Mesh& mesh) {
  switch (mesh.surface_class) {
    case SurfaceClass::kGround:
      return SurfaceKind::kGround;
    case SurfaceClass::kVegetation:
    case SurfaceClass::kUndergrowth:
      return SurfaceKind::kPlant;
    default:
      return SurfaceKind::kPlain;
  }
}

/// Varies the color of each tree.
Rgb vary(const Rgb& srgb, const Instance& instance, SurfaceKind kind) {
  if (instance.instance == 0 || kind == SurfaceKind::kGround) return srgb;
  const std::uint32_t h = (instance.instance * 0x9E3779B9U) ^ (instance.instance * 0x85EBCA77U >> 11);
  const auto signed_unit = [&](int shift) { return static_cast<float>((h >> shift) & 0xFFU) / 127.5F - 1.0F; };
  const float amount = kind == SurfaceKind::kPlant ? 1.0F : 0.5F;
  const Rgb tint(1.0F + amount * 0.10F * signed_unit(3), 1.0F, 1.0F - amount * 0.12F * signed_unit(11));
  return ((1.0F + amount * 0.13F * signed_unit(21)) * srgb.cwiseProduct(tint)).cwiseMin(1.0F);
}

/// Rounds up to discrete levels, so that a moving camera seldom changes them.
float on_ladder(float share) { return std::min(1.0F, std::exp2(std::ceil(2.0F * std::log2(share)) / 2.0F)); }

/// Share of leaves drawn at a projected leaf size.
float share_of_leaves(float leaf_px) {
  return leaf_px >= kLeafPixels ? 1.0F : on_ladder(std::max(kFewestLeaves, std::pow(leaf_px / kLeafPixels, 1.5F)));
}

/// Share of branches drawn at a projected thickness.
float share_of_branches(float thickness_px) {
  return thickness_px >= kBranchPixels ? 1.0F : on_ladder(std::max(kFewestBranches, thickness_px / kBranchPixels));
}

}  // namespace

void mesh_attributes(const GlFunctions& gl) {
  constexpr GLsizei kStride = sizeof(RenderVertex);
  float_attribute(gl, 0, 3, kStride, offsetof(RenderVertex, position_m));
  gl.EnableVertexAttribArray(1);
  gl.VertexAttribPointer(1, 4, GL_BYTE, GL_TRUE, kStride,
                         reinterpret_cast<const void*>(offsetof(RenderVertex, normal_open)));
  gl.EnableVertexAttribArray(2);
  gl.VertexAttribPointer(2, 4, GL_SHORT, GL_FALSE, kStride,
                         reinterpret_cast<const void*>(offsetof(RenderVertex, leaf_offset)));
}

WorldPainter::WorldPainter(const GlFunctions& gl, const Scene& scene) : gl_(gl) {
  // Instances grouped by mesh, in the scene's order.
  std::vector<std::vector<const Instance*>> instances_of(scene.meshes.size());
  for (const Instance& instance : scene.instances) instances_of[instance.mesh].push_back(&instance);

  std::vector<RenderVertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<InstanceAttributes> attributes;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    if (instances_of[m].empty() || mesh.triangles.empty()) continue;
    RenderMesh ready = prepare_mesh(mesh);
    PlacedMesh placed;
    placed.leaf_size_m = ready.leaf_size_m;
    placed.branch_thickness_m = ready.branch_thickness_m;
    placed.base_vertex = static_cast<GLint>(vertices.size());
    placed.first_index = static_cast<std::uint32_t>(indices.size());
    placed.first_instance = static_cast<std::uint32_t>(attributes.size());
    placed.chunks = std::move(ready.chunks);
    vertices.insert(vertices.end(), ready.vertices.begin(), ready.vertices.end());
    indices.insert(indices.end(), ready.indices.begin(), ready.indices.end());
    const SurfaceKind kind = kind_of(mesh);
    for (const Instance* instance : instances_of[m]) {
      InstanceAttributes attribute;
      attribute.T_world_mesh = instance->T_world_mesh.matrix().topRows<3>();
      attribute.color = with_alpha(to_linear(vary(scene.materials.at(mesh.material).color_rgb, *instance, kind)),
                                   static_cast<float>(kind));
      attributes.push_back(attribute);
      placed.T_world_mesh.push_back(instance->T_world_mesh);
      if (kind == SurfaceKind::kGround) continue;
      for (const RenderChunk& chunk : placed.chunks) {
        casters_m_.extend(chunk.box_m.transformed(instance->T_world_mesh));
      }
    }
    meshes_.push_back(std::move(placed));
  }

  vertices_ = make_vertex_buffer(gl_);
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(RenderVertex)), vertices.data(),
                 GL_STATIC_DRAW);
  mesh_attributes(gl_);
  make_buffer(gl_, GL_ARRAY_BUFFER, attributes.data(), attributes.size() * sizeof(InstanceAttributes));
  for (GLuint row = 0; row < 3; ++row) {
    float_attribute(gl_, 3 + row, 4, sizeof(InstanceAttributes), row * 4 * sizeof(float), 1);
  }
  float_attribute(gl_, 6, 4, sizeof(InstanceAttributes), offsetof(InstanceAttributes, color), 1);
  make_buffer(gl_, GL_ELEMENT_ARRAY_BUFFER, indices.data(), indices.size() * sizeof(std::uint32_t));
}

std::vector<WorldPainter::Batch> WorldPainter::select(const DrawSelection& selection) const {
  std::vector<Batch> batches;
  for (const PlacedMesh& mesh : meshes_) {
    for (const RenderChunk& chunk : mesh.chunks) {
      for (std::uint32_t i = 0; i < mesh.T_world_mesh.size(); ++i) {
        if (selection.cull && !may_be_seen(selection.frustum, chunk.box_m, mesh.T_world_mesh[i])) continue;
        const Eigen::AlignedBox3f box = chunk.box_m.transformed(mesh.T_world_mesh[i]);
        if (selection.cull && box.min().z() > selection.cut_m) continue;
        batches.push_back({&mesh, &chunk, mesh.first_instance + i, box.exteriorDistance(selection.eye_world_m)});
      }
    }
  }
  // From near to far, so that hidden surfaces are not shaded. Ties keep their order.
  std::stable_sort(batches.begin(), batches.end(),
                   [](const Batch& a, const Batch& b) { return a.nearest_m < b.nearest_m; });
  return batches;
}

void WorldPainter::draw(const Program& program, const DrawSelection& selection) const {
  gl_.BindVertexArray(vertices_.array);
  const GLint growth = program.location("u_leaf_growth");
  program.set("u_leaf_unit_m", kLeafUnit_m);
  gl_.Uniform1f(growth, 0.0F);
  float grown = 0.0F;
  for (const Batch& batch : select(selection)) {
    std::uint32_t count = batch.chunk->num_indices;
    float grow = 0.0F;
    if (selection.reduce) {
      const float scale = selection.parallel ? 1.0F : 1.0F / std::max(batch.nearest_m, 0.1F);
      const float pixels_per_m = selection.pixels_at_1m * scale;
      float share = 1.0F;
      if (batch.mesh->leaf_size_m > 0.0F) {
        share = share_of_leaves(batch.mesh->leaf_size_m * pixels_per_m);
        grow = 1.0F / std::sqrt(share) - 1.0F;
      } else if (batch.mesh->branch_thickness_m > 0.0F) {
        share = share_of_branches(batch.mesh->branch_thickness_m * pixels_per_m);
      }
      count = std::max(3U, static_cast<std::uint32_t>(share * static_cast<float>(count / 3)) * 3);
    }
    if (grow != grown) gl_.Uniform1f(growth, grown = grow);
    gl_.DrawElementsInstancedBaseVertexBaseInstance(
        GL_TRIANGLES, static_cast<GLsizei>(count), GL_UNSIGNED_INT,
        reinterpret_cast<const void*>(sizeof(std::uint32_t) *
                                      (batch.mesh->first_index + std::size_t{batch.chunk->first_index})),
        1, batch.mesh->base_vertex, batch.instance);
  }
}

}  // namespace swiftlet::sim
