// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/render_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/render/cameras.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

Eigen::Vector3f normal_of(const RenderVertex& v) {
  return Eigen::Vector3f(v.normal_open[0], v.normal_open[1], v.normal_open[2]) / 127.0F;
}

/// Triangles as sorted corner positions, to compare sets.
std::vector<std::array<float, 9>> triangles_of(const std::vector<std::array<Eigen::Vector3f, 3>>& corners) {
  std::vector<std::array<float, 9>> list;
  for (const auto& t : corners) {
    std::array<float, 9> flat;
    for (int i = 0; i < 9; ++i) flat[i] = t[i / 3][i % 3];
    list.push_back(flat);
  }
  std::sort(list.begin(), list.end());
  return list;
}

void expect_same_triangles(const Mesh& mesh, const RenderMesh& ready) {
  std::vector<std::array<Eigen::Vector3f, 3>> before;
  std::vector<std::array<Eigen::Vector3f, 3>> after;
  for (const auto& t : mesh.triangles)
    before.push_back({mesh.vertices_mesh_m[t[0]], mesh.vertices_mesh_m[t[1]], mesh.vertices_mesh_m[t[2]]});
  for (const RenderChunk& chunk : ready.chunks) {
    for (std::uint32_t i = chunk.first_index; i < chunk.first_index + chunk.num_indices; i += 3) {
      std::array<Eigen::Vector3f, 3> corners;
      for (int c = 0; c < 3; ++c) {
        corners[c] = Eigen::Vector3f(ready.vertices[ready.indices[i + c]].position_m.data());
        EXPECT_TRUE(chunk.box_m.contains(corners[c]));
      }
      after.push_back(corners);
    }
  }
  EXPECT_EQ(triangles_of(before), triangles_of(after));
}

TEST(RenderMesh, KeepsBoxEdgesSharp) {
  Mesh mesh;
  add_box(mesh, Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(1, 2, 3));
  const RenderMesh ready = prepare_mesh(mesh);
  EXPECT_EQ(ready.vertices.size(), 24U);
  for (const RenderVertex& v : ready.vertices) EXPECT_NEAR(normal_of(v).cwiseAbs().maxCoeff(), 1.0F, 0.01F);
  expect_same_triangles(mesh, ready);
}

TEST(RenderMesh, MakesASphereRound) {
  Mesh mesh;
  add_icosphere(mesh, {1, 2, 3}, 2.0F, 3);
  const RenderMesh ready = prepare_mesh(mesh);
  EXPECT_EQ(ready.vertices.size(), 642U);  // 10 * 4^3 + 2: no vertex is split
  for (const RenderVertex& v : ready.vertices) {
    const Eigen::Vector3f outward = (Eigen::Vector3f(v.position_m.data()) - Eigen::Vector3f(1, 2, 3)).normalized();
    EXPECT_GT(normal_of(v).normalized().dot(outward), 0.998F);
  }
}

TEST(RenderMesh, CutsMeshesIntoChunksWithoutLoss) {
  Mesh mesh;
  std::vector<float> heights(201 * 201);
  for (std::size_t i = 0; i < heights.size(); ++i) heights[i] = std::sin(0.01F * static_cast<float>(i));
  add_heightfield(mesh, {0, 0}, {1, 1}, 201, 201, heights);
  const RenderMesh ready = prepare_mesh(mesh);
  expect_same_triangles(mesh, ready);
  EXPECT_GE(ready.chunks.size(), 16U);
  for (const RenderChunk& chunk : ready.chunks) EXPECT_LT(chunk.box_m.sizes().head<2>().maxCoeff(), 75.0F);
}

TEST(RenderMesh, KnowsLeavesFromSolids) {
  Mesh mesh;
  mesh.surface_class = SurfaceClass::kVegetation;
  const Random random(1, "test.leaves");
  for (std::uint32_t i = 0; i < 6000; ++i) {
    const auto d = random.normal3(0, i);
    const Eigen::Vector3f at(static_cast<float>(d[0]), static_cast<float>(d[1]), static_cast<float>(d[2]));
    add_quad(mesh, at, at + Eigen::Vector3f(0.2F, 0, 0), at + Eigen::Vector3f(0.2F, 0.2F, 0),
             at + Eigen::Vector3f(0, 0.2F, 0));
  }
  const RenderMesh ready = prepare_mesh(mesh);
  expect_same_triangles(mesh, ready);
  EXPECT_NEAR(ready.leaf_size_m, 0.2F, 1e-3F);
  // Position minus offset is the middle of the leaf: a corner is half a diagonal from it.
  for (const RenderVertex& v : ready.vertices) {
    const Eigen::Vector3f offset = Eigen::Vector3f(v.leaf_offset[0], v.leaf_offset[1], v.leaf_offset[2]) * kLeafUnit_m;
    EXPECT_NEAR(offset.norm(), 0.1414F, 2e-3F);
  }
  // Both triangles of a leaf stay together, so any even first part of a chunk is whole leaves.
  for (const RenderChunk& chunk : ready.chunks) {
    for (std::uint32_t i = chunk.first_index; i < chunk.first_index + chunk.num_indices; i += 6) {
      const auto at = [&](std::uint32_t k) {
        return Eigen::Vector3f(ready.vertices[ready.indices[k]].position_m.data());
      };
      EXPECT_LT((at(i) - at(i + 3)).norm(), 0.3F);
    }
  }
  Mesh ball;
  ball.surface_class = SurfaceClass::kVegetation;
  add_icosphere(ball, {0, 0, 0}, 2.0F, 2);
  EXPECT_EQ(prepare_mesh(ball).leaf_size_m, 0.0F) << "a crown that is one solid";
}

TEST(Frustum, NeverDropsPartlyVisibleBoxes) {
  const View view = perspective_view({1, 2, 3}, {5, 4, 2}, 50.0, 160, 90);
  const Frustum frustum = frustum_of(view.clip_world().cast<float>());
  const Random random(7, "test.frustum");
  int dropped = 0;
  for (std::uint32_t i = 0; i < 4000; ++i) {
    const auto c = random.normal3(0, i);
    const auto s = random.normal3(1, i);
    const auto r = random.normal3(2, i);
    Eigen::Affine3f T = Eigen::Affine3f::Identity();
    T.translate(Eigen::Vector3f(c[0], c[1], c[2]) * 15.0F);
    T.rotate(Eigen::AngleAxisf(static_cast<float>(r[0]) * 3, Eigen::Vector3f(r[1], r[2], 0.3F).normalized()));
    const Eigen::Vector3f half = Eigen::Vector3f(s[0], s[1], s[2]).cwiseAbs();
    const Eigen::AlignedBox3f box(-half, half);
    const bool kept = may_be_seen(frustum, box, T);
    dropped += kept ? 0 : 1;
    for (std::uint32_t k = 0; k < 20; ++k) {
      const Eigen::Vector3f inside(random.uniform(-1, 1, 3, 60 * i + 3 * k),
                                   random.uniform(-1, 1, 3, 60 * i + 3 * k + 1),
                                   random.uniform(-1, 1, 3, 60 * i + 3 * k + 2));
      const auto at = view.project((T * half.cwiseProduct(inside)).cast<double>());
      const bool seen = at && at->x() >= 0 && at->x() <= 160 && at->y() >= 0 && at->y() <= 90 && at->z() < view.far_m;
      ASSERT_TRUE(kept || !seen) << i;
    }
  }
  EXPECT_GT(dropped, 2000) << "most boxes are far outside";
}

}  // namespace
}  // namespace swiftlet::sim
