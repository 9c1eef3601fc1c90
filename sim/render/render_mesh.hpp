// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Vertex in the layout of the vertex buffer: 24 bytes.
struct RenderVertex {
  std::array<float, 3> position_m;
  std::array<std::int8_t, 4> normal_open;   ///< normal * 127; fourth: openness to the sky * 127 (ambient light)
  std::array<std::int16_t, 4> leaf_offset;  ///< offset from the center of its leaf, in kLeafUnit_m; 0: not a leaf
};
/// Unit of RenderVertex::leaf_offset. Smaller units limit the size of a leaf.
inline constexpr float kLeafUnit_m = 1.0F / 4096.0F;

/// A part of a mesh that is drawn or culled as a unit.
struct RenderChunk {
  std::uint32_t first_index = 0;
  std::uint32_t num_indices = 0;
  Eigen::AlignedBox3f box_m;
};

/// A mesh prepared for drawing: vertices split at creases, triangles in compact chunks. Independent of GL.
struct RenderMesh {
  std::vector<RenderVertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<RenderChunk> chunks;
  /// Typical edge of a leaf [m]; 0: no leaves. Leaves of a chunk are shuffled, so that each first part of it samples
  /// the crown evenly: at large distances, fewer and larger leaves give the same appearance.
  float leaf_size_m = 0.0F;
  /// Typical thickness of branches [m]; 0: no branches. Branches of a chunk are sorted from long to short, so that at
  /// large distances its first part suffices.
  float branch_thickness_m = 0.0F;
};

RenderMesh prepare_mesh(const Mesh& mesh);

/// Six planes of a view volume; the inside has n.p + d >= 0.
struct Frustum {
  std::array<Eigen::Vector4f, 6> planes;
};
/// @param clip_world  with clip depth in [0, 1]
Frustum frustum_of(const Eigen::Matrix4f& clip_world);
/// False only when the box is certainly outside. The box is in mesh coordinates.
bool may_be_seen(const Frustum& frustum, const Eigen::AlignedBox3f& box_m, const Eigen::Affine3f& T_world_mesh);

}  // namespace swiftlet::sim
