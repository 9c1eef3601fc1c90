// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/forest_thesis.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "sim/world/placement.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "tests/sim/world/world_support.hpp"

namespace swiftlet::sim {
namespace {

using test::attribute;
using test::objects_of;

TEST(ForestThesis, HasHundredTreesThreeMetersApart) {
  for (const std::uint64_t seed : {1, 2, 3, 99}) {
    const auto trees = objects_of(make_forest_thesis({}, seed), SurfaceClass::kTrunk);
    ASSERT_EQ(trees.size(), 100U);
    for (std::size_t i = 0; i < trees.size(); ++i) {
      EXPECT_LE(std::abs(trees[i].position_world_m.x()), 20.0);
      EXPECT_LE(std::abs(trees[i].position_world_m.y()), 32.0);
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_GE((trees[i].position_world_m - trees[j].position_world_m).norm(), 3.0);
    }
  }
}

TEST(ForestThesis, SizesAreUniformWithinTheirSpreads) {
  double sum_radius = 0, sum_height = 0, sum_crown = 0, sum_height_sq = 0;
  constexpr int kSeeds = 40;
  for (int seed = 0; seed < kSeeds; ++seed) {
    for (const WorldObject& tree : objects_of(make_forest_thesis({}, seed), SurfaceClass::kTrunk)) {
      const double radius_m = 0.5 * attribute(tree, "dbh_m");
      const double height_m = attribute(tree, "height_m");
      const double crown_m = attribute(tree, "crown_radius_m");
      EXPECT_TRUE(radius_m >= 0.3 && radius_m <= 0.7) << radius_m;
      EXPECT_TRUE(height_m >= 5.5 && height_m <= 9.5) << height_m;
      EXPECT_TRUE(crown_m >= 2.0 && crown_m <= 3.0) << crown_m;
      sum_radius += radius_m, sum_height += height_m, sum_crown += crown_m;
      sum_height_sq += (height_m - 7.5) * (height_m - 7.5);
    }
  }
  // The mean of n uniform numbers of half-width w has the standard error w / sqrt(3 n); 5 of them are allowed.
  const double n = 100.0 * kSeeds;
  const double standard_error = 1.0 / std::sqrt(3.0 * n);
  EXPECT_NEAR(sum_radius / n, 0.5, 5 * 0.2 * standard_error);
  EXPECT_NEAR(sum_height / n, 7.5, 5 * 2.0 * standard_error);
  EXPECT_NEAR(sum_crown / n, 2.5, 5 * 0.5 * standard_error);
  EXPECT_NEAR(sum_height_sq / n, 4.0 / 3.0, 0.1);
}

TEST(ForestThesis, RaysMatchTrunksAndCrowns) {
  const Scene scene = make_forest_thesis({}, 5);
  const WorldObject tree = objects_of(scene, SurfaceClass::kTrunk)[17];
  const double radius_m = 0.5 * attribute(tree, "dbh_m");
  // From 1.4 m in front of the axis: no other tree is in between (3 m apart, at most 0.7 m thick).
  const auto trunk =
      test::trace(scene, tree.position_world_m + Eigen::Vector3d(-1.4, 0.001, 1.3), Eigen::Vector3d::UnitX());
  ASSERT_TRUE(trunk);
  EXPECT_EQ(trunk->surface_class, SurfaceClass::kTrunk);
  EXPECT_EQ(trunk->instance, tree.instance);
  EXPECT_NEAR(trunk->range_m, 1.4 - radius_m, 0.012 * radius_m + 1e-4);  // 24 sides: within 1.2 % of the circle

  // From above: the highest sphere at that point.
  const Eigen::Vector3d eye_m = tree.position_world_m + Eigen::Vector3d(0.3, 0.2, 30.0);
  double top_m = 0.0;
  for (const WorldObject& other : objects_of(scene, SurfaceClass::kTrunk)) {
    const double from_axis_sq = (other.position_world_m - eye_m).head<2>().squaredNorm();
    const double crown_radius_m = attribute(other, "crown_radius_m");
    if (from_axis_sq > crown_radius_m * crown_radius_m) continue;
    top_m = std::max(top_m, attribute(other, "height_m") + std::sqrt(crown_radius_m * crown_radius_m - from_axis_sq));
  }
  const auto crown = test::trace(scene, eye_m, -Eigen::Vector3d::UnitZ());
  ASSERT_TRUE(crown);
  EXPECT_EQ(crown->surface_class, SurfaceClass::kVegetation);
  EXPECT_NEAR(eye_m.z() - crown->range_m, top_m, 0.05);
}

TEST(ForestThesis, IsReproducibleFromItsSeed) {
  EXPECT_EQ(test::hash_of(make_forest_thesis({}, 7)), test::hash_of(make_forest_thesis({}, 7)));
  EXPECT_NE(test::hash_of(make_forest_thesis({}, 7)), test::hash_of(make_forest_thesis({}, 8)));
}

TEST(ForestThesis, TrailsStayFreeToClearHeight) {
  ForestThesisConfig config;
  config.keep_clear.trails = {{{{-20, -32, 0}, {20, 32, 0}}, 4.0}};
  config.keep_clear.clear_height_m = 4.0;
  for (const WorldObject& tree : objects_of(make_forest_thesis(config, 3), SurfaceClass::kTrunk)) {
    const double distance_m = distance_to_segment_m(tree.position_world_m.head<2>(), {-20, -32}, {20, 32});
    EXPECT_GE(distance_m, 2.0 + 0.5 * attribute(tree, "dbh_m"));
    if (attribute(tree, "crown_base_m") < 4.0) {
      EXPECT_GE(distance_m, 2.0 + attribute(tree, "crown_radius_m"));
    }
  }
}

TEST(ForestThesis, RefusesTooManyTreesForArea) {
  ForestThesisConfig config;
  config.num_trees = 1000;
  EXPECT_THROW(make_forest_thesis(config, 1), InputError);
}

TEST(ForestThesis, GroundExceedsTheAreaTreesFill) {
  ForestThesisConfig config;
  config.area_min_m = {-3.0, 5.0};
  config.area_max_m = {37.0, 25.0};
  config.min_distance_m = 0.1;
  config.num_trees = 1000;
  const Scene scene = make_forest_thesis(config, 2);
  EXPECT_TRUE(test::bounds_of(scene, SurfaceClass::kGround)
                  .isApprox(Eigen::AlignedBox3d(Eigen::Vector3d(-13, -5, 0), Eigen::Vector3d(47, 35, 0)), 1e-6));
  std::vector<double> xs, ys;
  for (const WorldObject& tree : objects_of(scene, SurfaceClass::kTrunk)) {
    xs.push_back(tree.position_world_m.x());
    ys.push_back(tree.position_world_m.y());
  }
  test::expect_uniform(xs, -3.0, 37.0);
  test::expect_uniform(ys, 5.0, 25.0);
}

}  // namespace
}  // namespace swiftlet::sim
