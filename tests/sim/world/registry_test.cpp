// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/registry/worlds.hpp"
#include "swiftlet/sim/world/forest.hpp"
#include "tests/sim/world/world_support.hpp"
#include "tests/support/config_checks.hpp"

namespace swiftlet::sim {
namespace {

bool needs_file(const WorldType& type) {
  return std::string(type.module.name) == "mesh" || std::string(type.module.name) == "cloud";
}

TEST(SurfaceClasses, DoNotCollideWithSemanticKitti) {
  // All labels of semantic-kitti.yaml, and the classes that share one: "ground" is a road or its edge.
  const std::set<int> theirs = {0,  1,  10, 11, 13, 15, 16, 18, 20, 30,  31,  32,  40,  44,  48,  49,  50,
                                51, 52, 60, 70, 71, 72, 80, 81, 99, 252, 253, 254, 255, 256, 257, 258, 259};
  const std::map<std::string, int> shared = {{"unlabeled", 0},   {"ground", 40},       {"kerb", 48},
                                             {"building", 50},   {"fence", 51},        {"other-structure", 52},
                                             {"vegetation", 70}, {"trunk", 71},        {"terrain", 72},
                                             {"pole", 80},       {"traffic-sign", 81}, {"object", 99}};
  std::set<int> numbers;
  for (const char* name : static_class_names()) {
    const int number = static_cast<int>(*surface_class_of(name));
    EXPECT_TRUE(numbers.insert(number).second) << name;
    if (!theirs.contains(number)) continue;
    ASSERT_TRUE(shared.contains(name)) << name;
    EXPECT_EQ(shared.at(name), number) << name;
  }
}

TEST(Worlds, ListEveryGeneratorWithValidDefault) {
  std::set<std::string> names;
  for (const WorldType& type : world_registry().rows()) {
    EXPECT_TRUE(names.insert(type.module.name).second) << type.module.name;
    const auto config = type.module.make_config();
    EXPECT_THAT(swiftlet::test::ConfigChecks(*config).problems(), testing::IsEmpty()) << type.module.name;
  }
  EXPECT_THAT(names, testing::IsSupersetOf({"forest_thesis", "forest", "warehouse", "two_rooms_gap", "hall", "campus",
                                            "field", "empty", "walls", "mesh", "cloud"}));
  EXPECT_EQ(world_module_types().size(), world_registry().rows().size());
}

TEST(Worlds, SameSeedGivesTheSameBytes) {
  for (const WorldType& type : world_registry().rows()) {
    if (needs_file(type)) continue;
    const Module module(world_module_types(), type.module.name);
    EXPECT_EQ(test::hash_of(make_world(module, 3)), test::hash_of(make_world(module, 3))) << type.module.name;
  }
}

TEST(Worlds, VaryRandomGeneratorsWithTheSeed) {
  for (const char* name : {"forest_thesis", "forest", "warehouse", "hall", "campus", "field"}) {
    const Module module(world_module_types(), name);
    EXPECT_NE(test::hash_of(make_world(module, 3)), test::hash_of(make_world(module, 4))) << name;
  }
}

TEST(Worlds, ScenesAreSoundWhateverTheSeed) {
  for (const WorldType& type : world_registry().rows()) {
    if (needs_file(type)) continue;
    Module module(world_module_types(), type.module.name);
    // Bounds are those of the place without its surroundings.
    if (std::string(type.module.name) == "forest") module.as<ForestConfig>().surroundings_m = 0.0;
    for (const std::uint64_t seed : {1, 2}) {
      const Scene scene = make_world(module, seed);
      for (const Mesh& mesh : scene.meshes) {
        EXPECT_LT(mesh.material, scene.materials.size());
        for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) ASSERT_TRUE(vertex.allFinite()) << type.module.name;
        for (const auto& triangle : mesh.triangles) {
          for (const std::uint32_t corner : triangle) ASSERT_LT(corner, mesh.vertices_mesh_m.size());
        }
      }
      for (const Instance& instance : scene.instances) {
        ASSERT_LT(instance.mesh, scene.meshes.size());
        for (const Eigen::Vector3f& vertex : scene.meshes[instance.mesh].vertices_mesh_m) {
          ASSERT_LE(scene.bounds_m.exteriorDistance((instance.T_world_mesh * vertex).cast<double>()), 1e-4);
        }
      }
      for (const Material& material : scene.materials) {
        EXPECT_TRUE(material.reflectivity > 0.0F && material.reflectivity <= 1.0F) << material.name;
      }
      // Class and instance identify objects, and objects of one kind have the same attributes.
      std::set<std::pair<SurfaceClass, std::uint16_t>> labels;
      std::map<std::string, std::vector<std::string>> keys;
      for (const WorldObject& object : scene.objects) {
        EXPECT_TRUE(labels.insert({object.surface_class, object.instance}).second)
            << type.module.name << " " << object.kind;
        std::vector<std::string> own;
        for (const auto& [key, value] : object.attributes) own.push_back(key);
        EXPECT_EQ(keys.try_emplace(object.kind, own).first->second, own);
      }
    }
  }
}

TEST(Worlds, AnUnknownTypeIsAnError) {
  Module module(world_module_types(), "field");
  module.type = "feild";
  EXPECT_THROW(make_world(module, 1), std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet::sim
