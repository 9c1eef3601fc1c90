// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/forest.hpp"

#include <gtest/gtest.h>

#include <map>

#include "sim/world/relief.hpp"
#include "sim/world/tree.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"
#include "tests/sim/world/world_support.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector3d;
using test::attribute;
using test::objects_of;

ForestConfig bare_stems() {
  ForestConfig config;
  config.detail = 0.05;
  config.bushes_per_ha = config.grass_per_ha = config.fallen_per_ha = config.rocks_per_ha = 0.0;
  return config;
}

KeepClearConfig cross_and_clearing() {
  KeepClearConfig keep_clear;
  keep_clear.trails = {{{{-30, -5, 0}, {0, 0, 0}, {30, 10, 0}}, 5.0}, {{{4, -30, 0}, {4, 30, 0}}, 4.0}};
  keep_clear.clearings = {{{-15.0, 15.0}, 6.0}};
  keep_clear.clear_height_m = 6.0;
  return keep_clear;
}

TEST(Forest, StemsKeepTheirDistanceAndDensity) {
  ForestConfig config = bare_stems();
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto trees = objects_of(make_forest(config, seed), SurfaceClass::kTrunk);
    EXPECT_EQ(trees.size(), 216U);  // 600 / ha on 0.36 ha
    for (std::size_t i = 0; i < trees.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        ASSERT_GE((trees[i].position_world_m - trees[j].position_world_m).head<2>().norm(), config.min_spacing_m);
      }
    }
  }
}

TEST(Forest, FollowsWeibullDiametersAndHeightCurve) {
  ForestConfig config = bare_stems();
  config.size_m = {200.0, 200.0};
  config.ground_cell_m = 10.0;
  const auto trees = objects_of(make_forest(config, 1), SurfaceClass::kTrunk);
  ASSERT_EQ(trees.size(), 2400U);
  const double n = static_cast<double>(trees.size());
  double sum = 0, sum_of_squares = 0, sum_of_deviations = 0;
  std::map<std::string, double> shares;
  for (const WorldObject& tree : trees) {
    const double dbh_m = attribute(tree, "dbh_m");
    EXPECT_GE(dbh_m, config.dbh_min_m);
    sum += dbh_m;
    sum_of_squares += dbh_m * dbh_m;
    shares[tree.kind] += 1.0 / n;
    const Species species = tree.kind == "pine"     ? Species::kPine
                            : tree.kind == "spruce" ? Species::kSpruce
                                                    : Species::kBroadleaf;
    const double deviation = attribute(tree, "height_m") / height_by_diameter_m(species, dbh_m) - 1.0;
    EXPECT_LE(std::abs(deviation), 2.5 * 0.07 + 1e-9);
    sum_of_deviations += deviation;
  }
  constexpr double k = 2.2;  // shape
  const double mean = config.dbh_min_m + config.dbh_scale_m * std::tgamma(1 + 1 / k);
  const double variance =
      config.dbh_scale_m * config.dbh_scale_m * (std::tgamma(1 + 2 / k) - std::pow(std::tgamma(1 + 1 / k), 2));
  EXPECT_NEAR(sum / n, mean, 5 * std::sqrt(variance / n));
  EXPECT_NEAR(sum_of_squares / n - std::pow(sum / n, 2), variance, 0.15 * variance);
  EXPECT_NEAR(sum_of_deviations / n, 0.0, 5 * 0.07 / std::sqrt(n));
  EXPECT_NEAR(shares["pine"], 0.40, 5 * std::sqrt(0.40 * 0.60 / n));
  EXPECT_NEAR(shares["spruce"], 0.35, 5 * std::sqrt(0.35 * 0.65 / n));
  EXPECT_NEAR(shares["broadleaf"], 0.25, 5 * std::sqrt(0.25 * 0.75 / n));
}

TEST(Forest, MatchesStemMapBreastHeightDiameters) {
  ForestConfig config = bare_stems();
  config.lean_max_deg = 0.0;
  const Scene scene = make_forest(config, 4);
  std::map<std::uint16_t, WorldObject> trees;
  for (const WorldObject& tree : objects_of(scene, SurfaceClass::kTrunk)) trees[tree.instance] = tree;
  int measured = 0;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (mesh.surface_class != SurfaceClass::kTrunk) continue;
    const WorldObject& tree = trees.at(instance.instance);
    // Mean distance from the axis to the surface, all around, 1.3 m above the foot.
    const Eigen::Affine3d T = instance.T_world_mesh.cast<double>();
    const Vector3d center = tree.position_world_m + Vector3d(0, 0, 1.3);
    double area_m2 = 0.0;
    constexpr int kDirections = 90;
    for (int i = 0; i < kDirections; ++i) {
      const double angle_rad = 2.0 * std::numbers::pi * i / kDirections;
      const Vector3d direction(std::cos(angle_rad), std::sin(angle_rad), 0);
      for (const auto& [a, b, c] : mesh.triangles) {
        const auto range_m =
            test::intersect(center, direction, T * mesh.vertices_mesh_m[a].cast<double>(),
                            T * mesh.vertices_mesh_m[b].cast<double>(), T * mesh.vertices_mesh_m[c].cast<double>());
        if (!range_m) continue;
        area_m2 += 0.5 * *range_m * *range_m * 2.0 * std::numbers::pi / kDirections;
        break;
      }
    }
    EXPECT_NEAR(2.0 * std::sqrt(area_m2 / std::numbers::pi), attribute(tree, "dbh_m"), 0.02 * attribute(tree, "dbh_m"));
    if (++measured == 60) break;
  }
  EXPECT_EQ(measured, 60);
}

TEST(Forest, NothingReachesIntoTrailsAndClearings) {
  ForestConfig config;
  config.keep_clear = cross_and_clearing();
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene scene = make_forest(config, seed);
    const double top_m = config.relief.amplitude_m + config.keep_clear.clear_height_m;
    for (const Instance& instance : scene.instances) {
      const Mesh& mesh = scene.meshes[instance.mesh];
      if (mesh.surface_class == SurfaceClass::kGround) continue;
      for (const auto& [a, b, c] : mesh.triangles) {
        const Vector3d corners[] = {(instance.T_world_mesh * mesh.vertices_mesh_m[a]).cast<double>(),
                                    (instance.T_world_mesh * mesh.vertices_mesh_m[b]).cast<double>(),
                                    (instance.T_world_mesh * mesh.vertices_mesh_m[c]).cast<double>()};
        // Corners and middles of the edges: the zones are wider than any triangle here.
        for (int i = 0; i < 3; ++i) {
          for (const Vector3d& point : {corners[i], Vector3d(0.5 * (corners[i] + corners[(i + 1) % 3]))}) {
            if (point.z() < top_m) {
              ASSERT_GE(config.keep_clear.distance_m(point.head<2>()), -1e-4)
                  << name_of(mesh.surface_class) << " at " << point.transpose();
            }
          }
        }
      }
    }
  }
}

TEST(Forest, ClearsTrailWithoutChangingOtherTrees) {
  ForestConfig config = bare_stems();
  const auto whole = objects_of(make_forest(config, 6), SurfaceClass::kTrunk);
  config.keep_clear = cross_and_clearing();
  const auto cut = objects_of(make_forest(config, 6), SurfaceClass::kTrunk);
  EXPECT_LT(cut.size(), whole.size());
  EXPECT_GT(cut.size(), whole.size() / 3);
  for (const WorldObject& tree : cut) {
    const bool was_there = std::any_of(whole.begin(), whole.end(), [&](const WorldObject& other) {
      return other.position_world_m == tree.position_world_m && attribute(other, "dbh_m") == attribute(tree, "dbh_m");
    });
    EXPECT_TRUE(was_there);
  }
}

TEST(Forest, SurroundingsLeavePlaceUnchanged) {
  ForestConfig config = bare_stems();
  config.keep_clear = cross_and_clearing();
  config.surroundings_m = 0.0;
  const Scene alone = make_forest(config, 6);
  config.surroundings_m = 30.0;
  const Scene surrounded = make_forest(config, 6);
  ASSERT_GT(surrounded.instances.size(), alone.instances.size() + 200);
  ASSERT_EQ(surrounded.objects.size(), alone.objects.size());
  for (std::size_t i = 0; i < alone.instances.size(); ++i) {
    EXPECT_TRUE(surrounded.instances[i].T_world_mesh.isApprox(alone.instances[i].T_world_mesh, 0.0F));
    EXPECT_EQ(surrounded.instances[i].instance, alone.instances[i].instance);
    EXPECT_EQ(surrounded.meshes[surrounded.instances[i].mesh].vertices_mesh_m,
              alone.meshes[alone.instances[i].mesh].vertices_mesh_m);
  }
  // The bounds are those of the flight area; trees beyond have no number.
  EXPECT_EQ(surrounded.bounds_m.min().head<2>(), alone.bounds_m.min().head<2>());
  EXPECT_EQ(surrounded.bounds_m.max().head<2>(), alone.bounds_m.max().head<2>());
  for (std::size_t i = alone.instances.size(); i < surrounded.instances.size(); ++i) {
    const Instance& instance = surrounded.instances[i];
    EXPECT_EQ(instance.instance, 0);
    if (surrounded.meshes[instance.mesh].surface_class == SurfaceClass::kGround) continue;
    const Vector3d foot = instance.T_world_mesh.translation().cast<double>();
    EXPECT_GE(foot.head<2>().cwiseAbs().maxCoeff(), 30.0 + config.min_spacing_m);
    EXPECT_LE(foot.head<2>().cwiseAbs().maxCoeff(), 60.0);
  }
}

TEST(Forest, ContinuesGroundIntoSurroundingsWithoutGap) {
  for (const double amplitude_m : {0.0, 1.5}) {
    ForestConfig config = bare_stems();
    config.size_m = {21.3, 17.7};
    config.stems_per_ha = 0.0;
    config.relief.amplitude_m = amplitude_m;
    config.surroundings_m = 15.0;
    const Scene scene = make_forest(config, 2);
    const Relief relief(config.relief, 2);
    const auto ground_m = [&](double x_m, double y_m) {
      const auto hit = test::trace(scene, {x_m, y_m, 50.0}, -Vector3d::UnitZ());
      return hit ? 50.0 - hit->range_m : -1e9;
    };
    const Dice start(Random(3, "test"), 0);
    Dice dice = start;
    for (int i = 0; i < 60; ++i) {
      const double along_m = dice.uniform(-8.0, 8.0), side = dice.chance(0.5) ? 1.0 : -1.0;
      for (const double beyond_m : {-1e-3, 0.0, 1e-3}) {
        EXPECT_NEAR(ground_m(side * (0.5 * 21.3 + beyond_m), along_m),
                    relief.height_m(side * (0.5 * 21.3 + beyond_m), along_m), 0.05);
        EXPECT_NEAR(ground_m(along_m, side * (0.5 * 17.7 + beyond_m)),
                    relief.height_m(along_m, side * (0.5 * 17.7 + beyond_m)), 0.05);
      }
      // Larger triangles further out cut off small bumps.
      EXPECT_NEAR(ground_m(side * (0.5 * 21.3 + 29.0), 3.0 * along_m),
                  relief.height_m(side * (0.5 * 21.3 + 29.0), 3.0 * along_m), 0.8);
    }
  }
}

TEST(Forest, DetailChangesTrianglesNotLeafArea) {
  const TreeOptions coarse{.leaf_area_density_per_m = 0.5, .leaf_cluster_m = 0.6};
  const TreeOptions fine{.leaf_area_density_per_m = 0.5, .leaf_cluster_m = 0.3};
  const Dice dice(Random(1, "test"), 0);
  const Tree few = make_tree(Species::kBroadleaf, 0.3, coarse, dice);
  const Tree many = make_tree(Species::kBroadleaf, 0.3, fine, dice);
  EXPECT_NEAR(static_cast<double>(many.leaves.triangles.size()) / static_cast<double>(few.leaves.triangles.size()), 4.0,
              0.05);
  EXPECT_NEAR(area_m2(many.leaves) / area_m2(few.leaves), 1.0, 0.01);
}

// Beer-Lambert: a share exp(-G LAD s) of rays passes the crown, with the path length s inside and G = 1/2.
class CrownGaps : public testing::TestWithParam<Species> {};

TEST_P(CrownGaps, PassRaysByLeafAreaProbability) {
  constexpr double kLeafAreaDensity = 0.6;
  const TreeOptions options{.leaf_area_density_per_m = kLeafAreaDensity, .leaf_cluster_m = 0.25, .lean_max_deg = 3.0};
  double passed = 0, expected = 0, variance = 0;
  for (std::uint32_t i_tree = 0; i_tree < 3; ++i_tree) {
    const Tree tree = make_tree(GetParam(), 0.3, options, Dice(Random(9, "test"), i_tree));
    Dice dice(Random(10, "test"), i_tree);
    for (int i = 0; i < 400; ++i) {
      // A horizontal or a steep ray that aims at the inner part of the crown.
      const double angle_rad = dice.angle_rad();
      const double z_m = dice.uniform(tree.crown.base_m, tree.crown.top_m);
      const double offset_m = dice.uniform(-0.8, 0.8) * tree.crown.outer_radius_m(z_m);
      const Vector3d direction =
          Vector3d(std::cos(angle_rad), std::sin(angle_rad), i % 2 == 0 ? 0.0 : 1.0).normalized();
      const Vector3d aim(tree.crown.lean_x * z_m - offset_m * std::sin(angle_rad),
                         tree.crown.lean_y * z_m + offset_m * std::cos(angle_rad), z_m);
      const Vector3d origin = aim - 30.0 * direction;
      double inside_m = 0.0;
      constexpr double kStep_m = 0.02;
      for (double s = 0.5 * kStep_m; s < 60.0; s += kStep_m) {
        if (tree.crown.contains(origin + s * direction)) inside_m += kStep_m;
      }
      const double p = std::exp(-0.5 * kLeafAreaDensity * inside_m);
      expected += p;
      variance += p * (1 - p);
      bool is_blocked = false;
      for (const auto& [a, b, c] : tree.leaves.triangles) {
        if (test::intersect(origin, direction, tree.leaves.vertices_mesh_m[a].cast<double>(),
                            tree.leaves.vertices_mesh_m[b].cast<double>(),
                            tree.leaves.vertices_mesh_m[c].cast<double>())) {
          is_blocked = true;
          break;
        }
      }
      passed += !is_blocked;
    }
  }
  // 4 standard deviations of the count, and 3 % for leaves that stick out of the crown's body.
  EXPECT_NEAR(passed, expected, 4 * std::sqrt(variance) + 0.03 * 1200);
  EXPECT_GT(passed, 0.05 * 1200);
  EXPECT_LT(passed, 0.95 * 1200);
}

INSTANTIATE_TEST_SUITE_P(Species, CrownGaps, testing::Values(Species::kPine, Species::kSpruce, Species::kBroadleaf),
                         [](const auto& species) { return std::string(name_of(species.param)); });

TEST(Crown, SpansItsHeightAndRadius) {
  for (const Species species : {Species::kPine, Species::kSpruce, Species::kBroadleaf}) {
    const Crown crown{.species = species, .base_m = 4.0, .top_m = 14.0, .radius_m = 2.5};
    double widest_m = 0.0;
    for (double z_m = 4.0; z_m <= 14.0; z_m += 0.1) {
      EXPECT_LE(crown.inner_radius_m(z_m), crown.outer_radius_m(z_m));
      widest_m = std::max(widest_m, crown.outer_radius_m(z_m));
    }
    EXPECT_NEAR(widest_m, 2.5, 0.02);
    EXPECT_NEAR(crown.outer_radius_m(14.0), 0.0, 1e-6);
    for (const double z_m : {3.99, 14.01}) EXPECT_FALSE(crown.contains({0.0, 0.0, z_m}));
  }
}

class TreesOf : public testing::TestWithParam<Species> {};
INSTANTIATE_TEST_SUITE_P(Species, TreesOf, testing::Values(Species::kPine, Species::kSpruce, Species::kBroadleaf),
                         [](const auto& species) { return std::string(name_of(species.param)); });

TEST_P(TreesOf, LeafAreaEqualsDensityTimesVolume) {
  const Tree tree = make_tree(GetParam(), 0.35, {.leaf_area_density_per_m = 0.7}, Dice(Random(1, "test"), 0));
  const Crown& crown = tree.crown;
  Dice dice(Random(2, "test"), 0);
  constexpr int kDraws = 20000;
  int inside = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double z_m = dice.uniform(crown.base_m, crown.top_m);
    const double x_m = dice.uniform(-crown.radius_m, crown.radius_m);
    const double y_m = dice.uniform(-crown.radius_m, crown.radius_m);
    inside += crown.contains({x_m + crown.lean_x * z_m, y_m + crown.lean_y * z_m, z_m});
  }
  const double box_m3 = (crown.top_m - crown.base_m) * 4.0 * crown.radius_m * crown.radius_m,
               share = 1.0 * inside / kDraws;
  EXPECT_NEAR(area_m2(tree.leaves), 0.7 * box_m3 * share,
              0.7 * box_m3 * 4 * std::sqrt(share * (1 - share) / kDraws) + 0.1);
}

TEST_P(TreesOf, BranchesFillCrownWithoutLeavingIt) {
  for (std::uint32_t i = 0; i < 5; ++i) {
    const Tree tree = make_tree(GetParam(), 0.35, {.lean_max_deg = 3.0}, Dice(Random(3, "test"), i));
    const Crown& crown = tree.crown;
    double farthest_m = 0.0;
    for (const Eigen::Vector3f& vertex : tree.branches.vertices_mesh_m) {
      const Vector3d p = vertex.cast<double>();
      ASSERT_TRUE(p.allFinite());
      EXPECT_LT(p.z(), tree.height_m);
      const double from_axis_m = std::hypot(p.x() - crown.lean_x * p.z(), p.y() - crown.lean_y * p.z());
      farthest_m = std::max(farthest_m, from_axis_m);
    }
    EXPECT_LT(farthest_m, 1.05 * crown.radius_m);
    EXPECT_GT(farthest_m, 0.6 * crown.radius_m);
  }
}

TEST_P(TreesOf, MatchHeightsOfStemMap) {
  SceneBuilder builder;
  const TreeStock stock(builder, GetParam(), {0.25, 0.4}, {.lean_max_deg = 0.0}, Random(4, "test"));
  stock.place(builder, {5.0, -3.0, 1.5}, 0.33, 0.8, 0.7);
  const Scene scene = builder.finish();
  ASSERT_EQ(scene.objects.size(), 1U);
  const double height_m = attribute(scene.objects[0], "height_m");
  EXPECT_NEAR(height_m, 0.8 * height_by_diameter_m(GetParam(), 0.33), 1e-9);
  EXPECT_NEAR(test::bounds_of(scene, SurfaceClass::kTrunk).max().z(), 1.5 + height_m, 1e-3);
  EXPECT_NEAR(test::bounds_of(scene, SurfaceClass::kVegetation).min().z(),
              1.5 + attribute(scene.objects[0], "crown_base_m"), 0.3);
}

}  // namespace
}  // namespace swiftlet::sim
