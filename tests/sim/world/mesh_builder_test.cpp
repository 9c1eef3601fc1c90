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

TEST(MeshBuilder, BoxHasItsVolumeAndArea) {
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

TEST(MeshBuilder, CylinderAndFrustumHaveExactVolume) {
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

TEST(MeshBuilder, IcosphereHasSphereVolumeAndArea) {
  Mesh mesh;
  add_icosphere(mesh, {1, 1, 1}, 2.5F, 3);
  EXPECT_EQ(mesh.triangles.size(), 1280U);
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_NEAR(signed_volume_m3(mesh), 4.0 / 3.0 * kPi * std::pow(2.5, 3), 1e-3);
  EXPECT_NEAR(area_m2(mesh), 4.0 * kPi * 6.25, 0.005 * 4.0 * kPi * 6.25);
  for (const Vector3f& vertex : mesh.vertices_mesh_m) EXPECT_NEAR((vertex - Vector3f(1, 1, 1)).norm(), 2.5F, 0.02F);
}

TEST(MeshBuilder, HeightfieldCoversRectangleWithoutHoles) {
  Mesh mesh;
  constexpr int kColumns = 5, kRows = 4;
  std::vector<float> heights;
  for (int i = 0; i < kColumns * kRows; ++i) heights.push_back(static_cast<float>(i % 7));
  add_box(mesh, Vector3f(-9, -9, -9), Vector3f(-8, -8, -8));  // existing content, to which the mesh is appended
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
    EXPECT_GT(twice_m2, 0.0F) << "faces up";
    covered_m2 += 0.5 * twice_m2;
  }
  EXPECT_NEAR(covered_m2, 4 * 0.5 * 3 * 0.25, 1e-5);
  EXPECT_EQ(mesh.vertices_mesh_m.back(), Vector3f(3, 2.75F, heights.back()));
}

TEST(MeshBuilder, TubesFollowTheirLine) {
  const std::vector<Vector3f> line = {{0, 0, 0}, {0.2F, 0.1F, 1}, {0.5F, -0.3F, 1.8F}, {1.4F, 0, 2.2F}};
  const std::vector<float> radii = {0.3F, 0.25F, 0.2F, 0.05F};
  for (const std::size_t sides : {3U, 7U, 12U}) {
    Mesh mesh;
    add_tube(mesh, line, radii, static_cast<int>(sides), Caps::kBoth);
    EXPECT_TRUE(is_closed(mesh));
    EXPECT_GT(signed_volume_m3(mesh), 0.0);
    ASSERT_EQ(mesh.vertices_mesh_m.size(), 4 * sides);
    for (std::size_t i = 0; i < 4 * sides; ++i) {
      const float from_line_m = (mesh.vertices_mesh_m[i] - line[i / sides]).norm();
      EXPECT_GE(from_line_m, radii[i / sides]);  // a ring has the area of its circle
      EXPECT_LE(from_line_m, 1.6F * radii[i / sides]);
    }
  }
}

TEST(MeshBuilder, StraightTubesHaveFrustumVolume) {
  const std::vector<Vector3f> line = {{0, 0, 0}, {0, 0, 1}, {0, 0, 3}};
  const std::vector<float> radii = {0.5F, 0.2F, 0.4F};
  Mesh mesh;
  add_tube(mesh, line, radii, 9, Caps::kBoth);
  const double expected = kPi / 3.0 * (1.0 * (0.25 + 0.1 + 0.04) + 2.0 * (0.04 + 0.08 + 0.16));
  EXPECT_NEAR(signed_volume_m3(mesh), expected, 1e-4);
}

TEST(MeshBuilder, CapsCloseTheRequestedEnds) {
  const auto ends = [](Caps caps) {
    Mesh mesh;
    add_frustum(mesh, {0, 0, 0}, 0.5F, {0, 0, 2}, 0.5F, 6, caps);
    EXPECT_GE(mesh.triangles.size(), 12U);
    std::pair<int, int> low_high{0, 0};
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vector3f normal = (mesh.vertices_mesh_m[b] - mesh.vertices_mesh_m[a])
                                  .cross(mesh.vertices_mesh_m[c] - mesh.vertices_mesh_m[a])
                                  .normalized();
      low_high.first += normal.z() < -0.9F;
      low_high.second += normal.z() > 0.9F;
    }
    return low_high;
  };
  EXPECT_EQ(ends(Caps::kNone), (std::pair{0, 0}));
  EXPECT_EQ(ends(Caps::kStart), (std::pair{4, 0}));
  EXPECT_EQ(ends(Caps::kEnd), (std::pair{0, 4}));
  EXPECT_EQ(ends(Caps::kBoth), (std::pair{4, 4}));
}

TEST(MeshBuilder, AppendsPiecesToExistingMesh) {
  Mesh mesh, ball;
  add_box(mesh, Vector3f(-1, -1, -1), Vector3f(0, 0, 0));
  add_triangle(mesh, {1, 0, 0}, {2, 0, 0}, {1, 2, 0});
  EXPECT_EQ(mesh.triangles.back(), (std::array<std::uint32_t, 3>{8, 9, 10}));
  add_quad(mesh, {5, 0, 0}, {6, 0, 0}, {6, 1, 0}, {5, 1, 0});
  EXPECT_NEAR(area_m2(mesh), 6.0 + 1.0 + 1.0, 1e-5);
  EXPECT_NEAR((mesh.vertices_mesh_m[mesh.triangles.back()[1]] - Vector3f(6, 1, 0)).norm(), 0.0F, 1e-6F);
  add_icosphere(ball, Vector3f::Zero(), 1.0F, 1);
  const double volume = signed_volume_m3(mesh);
  Eigen::Affine3f T = Eigen::Affine3f::Identity();
  T.translate(Vector3f(10, 0, 0)).scale(2.0F);
  append(mesh, ball, T);
  EXPECT_NEAR(signed_volume_m3(mesh), volume + 8.0 * signed_volume_m3(ball), 1e-3);
  EXPECT_NEAR(bounds_m(mesh).max().x(), 10.0F + 2.0F * bounds_m(ball).max().x(), 1e-5F);
  Mesh moved;
  add_box(moved, Eigen::Affine3f(Eigen::Translation3f(1, 2, 3)), Vector3f(2, 4, 6));
  EXPECT_TRUE(bounds_m(moved).isApprox(Eigen::AlignedBox3f(Vector3f(0, 0, 0), Vector3f(2, 4, 6))));
}

}  // namespace
}  // namespace swiftlet::sim
