// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/mesh_builder.hpp"

#include <gtest/gtest.h>

#include <map>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3f;

// Every edge of a closed, consistently turned surface is used once in each direction.
bool is_closed(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& [a, b, c] : mesh.triangles) {
    for (const auto& edge : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
      if (++edges[edge] > 1) return false;
    }
  }
  for (const auto& [edge, count] : edges) {
    if (!edges.contains({edge.second, edge.first})) return false;
  }
  return !edges.empty();
}

TEST(MeshBuilder, BoxHasItsVolumeAndAreaOutward) {
  Mesh mesh;
  add_box(mesh, Vector3f(-1, 0, 2), Vector3f(1, 3, 2.5));
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_NEAR(signed_volume_m3(mesh), 2 * 3 * 0.5, 1e-5);
  EXPECT_NEAR(area_m2(mesh), 2 * (2 * 3 + 2 * 0.5 + 3 * 0.5), 1e-5);
}

TEST(MeshBuilder, TurnedBoxKeepsItsVolume) {
  Mesh mesh;
  Eigen::Affine3f T = Eigen::Affine3f::Identity();
  T.translate(Vector3f(4, 5, 6)).rotate(Eigen::AngleAxisf(0.7F, Vector3f(1, 2, 3).normalized()));
  add_box(mesh, T, Vector3f(1, 2, 3));
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_NEAR(signed_volume_m3(mesh), 6.0, 1e-4);
}

TEST(MeshBuilder, CylinderAndConeFrustumHaveTheirClosedFormVolumeAtAnyResolution) {
  for (const int sides : {3, 8, 24}) {
    Mesh cylinder;
    add_frustum(cylinder, {1, 2, 3}, 0.4F, {2, 4, 5}, 0.4F, sides);
    EXPECT_TRUE(is_closed(cylinder));
    EXPECT_NEAR(signed_volume_m3(cylinder), kPi * 0.16 * 3.0, 1e-4);  // length |(1, 2, 2)| = 3
    Mesh frustum;
    add_frustum(frustum, {0, 0, 0}, 0.5F, {0, 0, 2}, 0.1F, sides);
    EXPECT_TRUE(is_closed(frustum));
    EXPECT_NEAR(signed_volume_m3(frustum), kPi * 2.0 / 3.0 * (0.25 + 0.05 + 0.01), 1e-4);
  }
}

TEST(MeshBuilder, IcosphereHasTheSpheresVolumeAndNearlyItsArea) {
  Mesh mesh;
  add_icosphere(mesh, {1, 1, 1}, 2.5F, 3);
  EXPECT_EQ(mesh.triangles.size(), 1280U);
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_NEAR(signed_volume_m3(mesh), 4.0 / 3.0 * kPi * std::pow(2.5, 3), 1e-3);
  EXPECT_NEAR(area_m2(mesh), 4.0 * kPi * 6.25, 0.005 * 4.0 * kPi * 6.25);
  for (const Vector3f& vertex : mesh.vertices_mesh_m) EXPECT_NEAR((vertex - Vector3f(1, 1, 1)).norm(), 2.5F, 0.02F);
}

TEST(MeshBuilder, HeightfieldFacesUpAndPassesThroughItsHeights) {
  Mesh mesh;
  const std::vector<float> heights = {0, 1, 0, 0, 2, 0};
  add_heightfield(mesh, {10, 20}, {1, 2}, 3, 2, heights);
  EXPECT_EQ(mesh.triangles.size(), 4U);
  EXPECT_EQ(mesh.vertices_mesh_m[4], Vector3f(11, 22, 2));
  for (const auto& [a, b, c] : mesh.triangles) {
    EXPECT_GT((mesh.vertices_mesh_m[b] - mesh.vertices_mesh_m[a])
                  .cross(mesh.vertices_mesh_m[c] - mesh.vertices_mesh_m[a])
                  .z(),
              0.0F);
  }
}

TEST(MeshBuilder, HeightfieldCoversItsRectangleOnceWithoutHoles) {
  Mesh mesh;
  constexpr int kColumns = 5, kRows = 4;
  std::vector<float> heights;
  for (int i = 0; i < kColumns * kRows; ++i) heights.push_back(static_cast<float>(i % 7));
  add_box(mesh, Vector3f(-9, -9, -9), Vector3f(-8, -8, -8));  // it is appended to what was there
  const std::size_t first = mesh.triangles.size();
  add_heightfield(mesh, {1, 2}, {0.5F, 0.25F}, kColumns, kRows, heights);
  ASSERT_EQ(mesh.triangles.size() - first, 2U * (kColumns - 1) * (kRows - 1));
  double covered_m2 = 0.0;
  for (std::size_t i = first; i < mesh.triangles.size(); ++i) {
    Eigen::AlignedBox3f box;
    for (const std::uint32_t corner : mesh.triangles[i]) {
      ASSERT_LT(corner, mesh.vertices_mesh_m.size());
      box.extend(mesh.vertices_mesh_m[corner]);
    }
    EXPECT_TRUE(box.sizes().head<2>().isApprox(Eigen::Vector2f(0.5F, 0.25F)));  // half of one cell
    const auto& [a, b, c] = mesh.triangles[i];
    const float twice_m2 = (mesh.vertices_mesh_m[b] - mesh.vertices_mesh_m[a])
                               .cross(mesh.vertices_mesh_m[c] - mesh.vertices_mesh_m[a])
                               .z();
    EXPECT_GT(twice_m2, 0.0F);
    covered_m2 += 0.5 * twice_m2;
  }
  EXPECT_NEAR(covered_m2, 4 * 0.5 * 3 * 0.25, 1e-5);
}

}  // namespace
}  // namespace swiftlet::sim
