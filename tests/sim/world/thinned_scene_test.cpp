// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/thinned_scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "swiftlet/sim/world/forest.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

Scene some_forest() {
  ForestConfig config;
  config.size_m = {30.0, 30.0};
  return make_forest(config, 1);
}

TEST(ThinnedScene, HasRoughlyTheRequestedTriangleCount) {
  const Scene scene = some_forest();
  ASSERT_GT(scene.num_triangles(), 100'000U);
  for (const std::size_t most : {50'000U, 20'000U}) {
    const Scene thin = thinned_scene(scene, most);
    EXPECT_LT(thin.num_triangles(), most * 3 / 2);
    EXPECT_GT(thin.num_triangles(), most / 4);
    ASSERT_EQ(thin.meshes.size(), scene.meshes.size());
    EXPECT_EQ(thin.instances.size(), scene.instances.size());
  }
}

TEST(ThinnedScene, LeavesSmallScenesUnchanged) {
  const Scene scene = some_forest();
  const Scene same = thinned_scene(scene, 10 * scene.num_triangles());
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    EXPECT_EQ(same.meshes[m].triangles, scene.meshes[m].triangles);
    EXPECT_EQ(same.meshes[m].vertices_mesh_m, scene.meshes[m].vertices_mesh_m);
  }
}

TEST(ThinnedScene, EnlargesLeavesAndBaresNoPlant) {
  const Scene scene = some_forest();
  const Scene thin = thinned_scene(scene, 20'000);
  int crowns = 0, grown = 0;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    if (scene.meshes[m].surface_class != SurfaceClass::kVegetation || scene.meshes[m].triangles.empty()) continue;
    ++crowns;
    ASSERT_FALSE(thin.meshes[m].triangles.empty());
    const auto area_m2 = [](const Mesh& mesh) {
      double sum = 0.0;
      for (const auto& t : mesh.triangles) {
        const Eigen::Vector3f &a = mesh.vertices_mesh_m[t[0]], &b = mesh.vertices_mesh_m[t[1]],
                              &c = mesh.vertices_mesh_m[t[2]];
        sum += 0.5 * (b - a).cross(c - a).norm();
      }
      return sum / static_cast<double>(mesh.triangles.size());
    };
    EXPECT_GE(area_m2(thin.meshes[m]), area_m2(scene.meshes[m]) * (1.0 - 1e-6));
    grown += area_m2(thin.meshes[m]) > 1.5 * area_m2(scene.meshes[m]);
  }
  EXPECT_GT(crowns, 0);
  EXPECT_GT(grown, crowns / 2);
}

Scene scene_of(const std::vector<std::pair<Mesh, int>>& meshes_and_uses) {
  Scene scene;
  for (const auto& [mesh, uses] : meshes_and_uses) {
    for (int i = 0; i < uses; ++i)
      scene.instances.push_back({static_cast<std::uint32_t>(scene.meshes.size()), Eigen::Affine3f::Identity(), 0});
    scene.meshes.push_back(mesh);
  }
  return scene;
}

/// A number of triangles of half a square meter, far from each other.
Mesh leaves(int count, SurfaceClass surface_class) {
  Mesh mesh;
  mesh.surface_class = surface_class;
  for (int i = 0; i < count; ++i) {
    const auto x = 3.0F * static_cast<float>(i);
    add_triangle(mesh, {x, 1, 0}, {x + 1, 1, 0}, {x, 2, 0});
  }
  return mesh;
}

float mean_area(const Mesh& mesh) {
  return static_cast<float>(area_m2(mesh) / static_cast<double>(mesh.triangles.size()));
}

TEST(ThinnedScene, SamplesLeavesEvenlyAndGrowsThem) {
  const Mesh mesh = leaves(1000, SurfaceClass::kVegetation);
  struct Case {
    std::size_t most;
    double share;
  };
  // At least 2 of 100; leaves grow by a factor of three at most.
  for (const auto& [most, share] : {Case{500, 0.5}, {250, 0.25}, {100, 0.1}, {20, 0.02}, {5, 0.02}}) {
    const Scene scene = scene_of({{mesh, 1}});
    const Mesh thin = thinned_scene(scene, most).meshes[0];
    EXPECT_NEAR(static_cast<double>(thin.triangles.size()), 1000.0 * share, 1.0);
    const auto growth = static_cast<float>(std::min(3.0, std::sqrt(1.0 / share)));
    EXPECT_NEAR(mean_area(thin), 0.5F * growth * growth, 1e-3F);
    double before = -1.0;
    for (const auto& t : thin.triangles) {
      const Eigen::Vector3f middle =
          (thin.vertices_mesh_m[t[0]] + thin.vertices_mesh_m[t[1]] + thin.vertices_mesh_m[t[2]]) / 3.0F;
      const double number = (middle.x() - 1.0 / 3.0) / 3.0;  // number of the leaf
      EXPECT_NEAR(number, std::round(number), 1e-3);
      EXPECT_NEAR(middle.y(), 4.0F / 3.0F, 1e-4F);
      if (before >= 0.0) {
        EXPECT_NEAR(number - before, 1.0 / share, 1.01) << "evenly";
      }
      before = number;
    }
  }
}

/// Brute force: every corner moves to the first one of its cell.
std::vector<std::array<std::uint32_t, 3>> coarse(const Mesh& mesh, float edge_m) {
  const auto cell_of = [&](std::uint32_t i) {
    return Eigen::Vector3i((mesh.vertices_mesh_m[i] / edge_m).array().floor().cast<int>());
  };
  const auto first_in_cell = [&](std::uint32_t i) {
    std::uint32_t j = 0;
    while (cell_of(j) != cell_of(i)) ++j;
    return j;
  };
  std::vector<std::array<std::uint32_t, 3>> kept;
  for (const auto& t : mesh.triangles) {
    const std::array<std::uint32_t, 3> moved{first_in_cell(t[0]), first_in_cell(t[1]), first_in_cell(t[2])};
    if (moved[0] != moved[1] && moved[1] != moved[2] && moved[2] != moved[0]) kept.push_back(moved);
  }
  return kept;
}

TEST(ThinnedScene, CoarsensTheRestUntilItFits) {
  Mesh hills;
  std::vector<float> heights;
  for (int i = 0; i < 15 * 12; ++i) heights.push_back(0.1F * static_cast<float>(i * i % 17));
  add_heightfield(hills, {-1.0F, -0.7F}, {0.13F, 0.11F}, 15, 12, heights);
  Mesh ball;
  add_icosphere(ball, {0.3F, 0.2F, 0.4F}, 0.8F, 2);
  const Mesh bush = leaves(300, SurfaceClass::kUndergrowth);
  for (const std::size_t most : {1900U, 1300U, 900U, 500U, 200U, 60U}) {
    const Scene scene = scene_of({{hills, 2}, {bush, 1}, {ball, 3}});
    const double plants = 300.0, half = 0.5 * static_cast<double>(most);
    double rest = 2.0 * static_cast<double>(hills.triangles.size()) + 3.0 * static_cast<double>(ball.triangles.size());
    float edge_m = 0.0F;
    while (rest > std::max(half, 2.0 * half - plants)) {
      edge_m = edge_m == 0.0F ? 0.05F : 1.5F * edge_m;
      if (edge_m > 100.0F) break;
      rest = 2.0 * static_cast<double>(coarse(hills, edge_m).size()) +
             3.0 * static_cast<double>(coarse(ball, edge_m).size());
    }
    const Scene thin = thinned_scene(scene, most);
    EXPECT_EQ(thin.meshes[0].triangles, edge_m > 0.0F ? coarse(hills, edge_m) : hills.triangles) << most;
    EXPECT_EQ(thin.meshes[2].triangles, edge_m > 0.0F ? coarse(ball, edge_m) : ball.triangles) << most;
    EXPECT_EQ(thin.meshes[0].vertices_mesh_m, hills.vertices_mesh_m);
    const double share = std::clamp((2.0 * half - rest) / plants, 0.02, 1.0);
    EXPECT_NEAR(static_cast<double>(thin.meshes[1].triangles.size()), std::max(6.0, share * 300.0), 1.0) << most;
  }
}

TEST(ThinnedScene, KeepsTrianglesAboveAHundredMeters) {
  for (const float size_m : {70.0F, 120.0F}) {
    Mesh mesh;
    add_triangle(mesh, {1, 1, 1}, {1 + size_m, 1, 1}, {1, 1 + size_m, 1});
    EXPECT_EQ(thinned_scene(scene_of({{mesh, 1}}), 0).meshes[0].triangles.size(), size_m > 100.0F ? 1U : 0U);
  }
}

TEST(ThinnedScene, ClassesUndergrowthAndBranchesAsPlants) {
  for (const SurfaceClass surface_class : {SurfaceClass::kVegetation, SurfaceClass::kUndergrowth, SurfaceClass::kBranch,
                                           SurfaceClass::kTrunk, SurfaceClass::kGround, SurfaceClass::kBuilding}) {
    Mesh mesh;
    mesh.surface_class = surface_class;
    EXPECT_EQ(is_plant(mesh), surface_class == SurfaceClass::kVegetation ||
                                  surface_class == SurfaceClass::kUndergrowth ||
                                  surface_class == SurfaceClass::kBranch);
  }
}

}  // namespace
}  // namespace swiftlet::sim
