// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/thinned_scene.hpp"

#include <gtest/gtest.h>

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
    const auto leaf_m2 = [](const Mesh& mesh) { return area_m2(mesh) / static_cast<double>(mesh.triangles.size()); };
    EXPECT_GE(leaf_m2(thin.meshes[m]), leaf_m2(scene.meshes[m]) * (1.0 - 1e-6));
    grown += leaf_m2(thin.meshes[m]) > 1.5 * leaf_m2(scene.meshes[m]);
  }
  EXPECT_GT(crowns, 0);
  EXPECT_GT(grown, crowns / 2);
}

}  // namespace
}  // namespace swiftlet::sim
