// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "sim/world/relief.hpp"
#include "swiftlet/sim/world/forest.hpp"
#include "tests/sim/world/world_support.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3d;
using test::attribute;
using test::expect_uniform;
using test::objects_of;

ForestConfig bare_ground(double size_m) {
  ForestConfig config;
  config.size_m = {size_m, size_m};
  config.stems_per_ha = config.bushes_per_ha = config.grass_per_ha = config.fallen_per_ha = config.rocks_per_ha = 0.0;
  config.surroundings_m = 0.0;
  config.detail = 0.05;
  config.ground_cell_m = 5.0;
  return config;
}

TEST(Forest, UndergrowthHasItsDensityEverywhere) {
  ForestConfig config = bare_ground(100.0);
  config.size_m = {100.0, 60.0};
  config.bushes_per_ha = 700.0;
  config.grass_per_ha = 500.0;
  const Relief relief(config.relief, 2);
  std::vector<double> xs, ys;
  int bushes = 0;
  for (const WorldObject& plant : objects_of(make_forest(config, 2), SurfaceClass::kUndergrowth)) {
    bushes += plant.kind == "bush";
    xs.push_back(plant.position_world_m.x());
    ys.push_back(plant.position_world_m.y());
    EXPECT_NEAR(plant.position_world_m.z(), relief.height_m(xs.back(), ys.back()), 1e-9);
  }
  EXPECT_EQ(bushes, 420);
  EXPECT_EQ(xs.size(), 720U);
  expect_uniform(xs, -50.0, 50.0);
  expect_uniform(ys, -30.0, 30.0);
}

TEST(Forest, FindsRoomForEveryStem) {
  ForestConfig config = bare_ground(30.0);
  config.detail = 0.05;
  config.leaf_area_density_per_m = 0.0;
  config.min_spacing_m = 2.0;
  config.stems_per_ha = 1500.0;  // discs thrown by chance cover 0.547 of the area at most, these 0.471
  EXPECT_EQ(objects_of(make_forest(config, 1), SurfaceClass::kTrunk).size(), 135U);
  try {
    config.stems_per_ha = 10000.0;
    make_forest(config, 1);
    FAIL() << "no exception";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("room for 900 stems"), std::string::npos) << error.what();
  }
}

TEST(Forest, RocksAndFallenTrunksTouchGround) {
  ForestConfig config = bare_ground(100.0);
  config.rocks_per_ha = 300.0;
  config.fallen_per_ha = 100.0;
  const Relief relief(config.relief, 5);
  const Scene scene = make_forest(config, 5);
  for (const SurfaceClass surface_class : {SurfaceClass::kObject, SurfaceClass::kFallenTrunk}) {
    const auto things = objects_of(scene, surface_class);
    EXPECT_GT(things.size(), 80U);
    for (const WorldObject& thing : things) {
      const Vector3d& p_m = thing.position_world_m;
      EXPECT_NEAR(p_m.z(), relief.height_m(p_m.x(), p_m.y()), 1e-9);
    }
  }
  config.keep_clear.clearings = {{{10.0, 5.0}, 30.0}};
  for (const WorldObject& rock : objects_of(make_forest(config, 5), SurfaceClass::kObject))
    EXPECT_GT(config.keep_clear.distance_m(rock.position_world_m.head<2>()), attribute(rock, "radius_m"));
}

}  // namespace
}  // namespace swiftlet::sim
