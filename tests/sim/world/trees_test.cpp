// SPDX-License-Identifier: BSD-3-Clause
// Trees taken apart: every ring of a trunk, every branch and every leaf, against the law of its species.
#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "sim/world/tree.hpp"
#include "sim/world/undergrowth.hpp"
#include "swiftlet/sim/world/campus.hpp"
#include "swiftlet/sim/world/field.hpp"
#include "swiftlet/sim/world/forest.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"
#include "tests/sim/world/world_support.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using test::attribute;
using test::expect_share;
using test::expect_uniform;
using test::objects_of;
using test::Piece;
using test::Ring;
using test::rings_of;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr Species kAllSpecies[] = {Species::kPine, Species::kSpruce, Species::kBroadleaf};

struct Law {
  double a_m, b_m;                  // Michailow: h = 1.3 + a exp(-b / d)
  double crown_share;               // of the height
  double radius_m, radius_per_dbh;  // of the crown
};
Law law_of(Species species) {
  switch (species) {
    case Species::kPine:
      return {29.0, 0.095, 0.40, 0.7, 4.5};
    case Species::kSpruce:
      return {33.0, 0.105, 0.72, 0.8, 4.0};
    case Species::kBroadleaf:
      return {28.0, 0.080, 0.55, 1.0, 7.0};
  }
  return {};
}

Vector3d axis_at(const Crown& crown, double z_m) { return {crown.lean_x * z_m, crown.lean_y * z_m, z_m}; }

/// Half of the diameter at breast height there, tapering with the power 0.8 of the way to the top, swelling at the
/// foot.
double trunk_radius(double dbh_m, double height_m, double z_m) {
  const double taper = std::pow((height_m - z_m) / (height_m - 1.3), 0.8);
  const double swell = z_m < 1.3 ? 0.35 * (std::exp(-z_m / 0.25) - std::exp(-1.3 / 0.25)) : 0.0;
  return 0.5 * dbh_m * (taper + swell);
}

TEST(Trees, HeightsFollowMichailowsCurve) {
  for (const Species species : kAllSpecies) {
    for (const double dbh_m : {0.08, 0.2, 0.35, 0.6}) {
      const Law law = law_of(species);
      EXPECT_NEAR(height_by_diameter_m(species, dbh_m), 1.3 + law.a_m * std::exp(-law.b_m / dbh_m), 1e-9);
    }
  }
  EXPECT_STREQ(name_of(Species::kPine), "pine");
  EXPECT_STREQ(name_of(Species::kSpruce), "spruce");
  EXPECT_STREQ(name_of(Species::kBroadleaf), "broadleaf");
}

TEST(Trees, TrunksTaperFromASwellingFootToTheirTop) {
  for (const double height_m : {9.0, 22.0}) {
    for (double z_m = 0.0; z_m <= height_m; z_m += 0.07)
      EXPECT_NEAR(trunk_radius_m(0.3, height_m, z_m), trunk_radius(0.3, height_m, z_m), 1e-12) << z_m;
    EXPECT_NEAR(trunk_radius_m(0.3, height_m, 1.3), 0.15, 1e-12);
    EXPECT_EQ(trunk_radius_m(0.3, height_m, height_m), 0.0);
    EXPECT_EQ(trunk_radius_m(0.3, height_m, height_m + 1.0), 0.0) << "above the top";
  }
}

TEST(Trees, CrownsAreHollowAndEndWhereTheirOutlineDoes) {
  Dice dice(Random(5, "test"), 0);
  for (const Species species : kAllSpecies) {
    const Crown crown{
        .species = species, .base_m = 3.0, .top_m = 11.0, .radius_m = 2.0, .lean_x = 0.05, .lean_y = -0.03};
    const double hollow = species == Species::kBroadleaf ? 0.35 : 0.2;
    for (int i = 0; i < 300; ++i) {
      const double z_m = dice.uniform(2.5, 11.5), angle_rad = dice.angle_rad(), from_axis_m = dice.uniform(0.0, 2.2);
      EXPECT_NEAR(crown.inner_radius_m(z_m), hollow * crown.outer_radius_m(z_m), 1e-12);
      const Vector3d p = axis_at(crown, z_m) + from_axis_m * Vector3d(std::cos(angle_rad), std::sin(angle_rad), 0.0);
      const bool inside = z_m > 3.0 && z_m < 11.0 && from_axis_m < crown.outer_radius_m(z_m) &&
                          from_axis_m > hollow * crown.outer_radius_m(z_m);
      EXPECT_EQ(crown.contains(p), inside) << p.transpose();
    }
    EXPECT_EQ(crown.outer_radius_m(2.0), crown.outer_radius_m(3.0)) << "below, as at its foot";
    EXPECT_EQ(crown.outer_radius_m(12.0), crown.outer_radius_m(11.0));
  }
}

TEST(Trees, CrownsAndLeansVaryAsTheLawOfTheirSpeciesSays) {
  const Random random(1, "test.trees");
  for (const Species species : kAllSpecies) {
    const Law law = law_of(species);
    std::vector<double> lengths, radii, leans_deg, directions_rad;
    for (std::uint32_t i = 0; i < 300; ++i) {
      const double dbh_m = 0.1 + 0.001 * i;
      const TreeOptions options{.leaf_area_density_per_m = 0.0, .lean_max_deg = 4.0, .is_far = true};
      const Tree tree = make_tree(species, dbh_m, options, Dice(random, i));
      EXPECT_EQ(tree.dbh_m, dbh_m);
      EXPECT_EQ(tree.species, species);
      EXPECT_EQ(tree.crown.species, species);
      EXPECT_EQ(tree.height_m, height_by_diameter_m(species, dbh_m));
      EXPECT_EQ(tree.crown.top_m, tree.height_m);
      EXPECT_TRUE(tree.leaves.triangles.empty());
      EXPECT_TRUE(tree.branches.triangles.empty()) << "far trees have none";
      lengths.push_back((1.0 - tree.crown.base_m / tree.height_m) / law.crown_share);
      radii.push_back(tree.crown.radius_m / (law.radius_m + law.radius_per_dbh * dbh_m));
      leans_deg.push_back(std::atan(std::hypot(tree.crown.lean_x, tree.crown.lean_y)) * 180.0 / std::numbers::pi);
      directions_rad.push_back(std::atan2(tree.crown.lean_y, tree.crown.lean_x));
    }
    expect_uniform(lengths, 0.9, 1.1);
    expect_uniform(radii, 0.9, 1.1);
    expect_uniform(leans_deg, 0.0, 4.0);
    expect_uniform(directions_rad, -std::numbers::pi, std::numbers::pi);
  }
}

// Rings under the ground, at it, where the foot has stopped swelling, at breast height, then evenly up to the top.
TEST(Trees, TrunksAreRoundWithARingAtBreastHeight) {
  for (const bool is_far : {false, true}) {
    const std::size_t sides = is_far ? 5 : 10, evenly = is_far ? 2 : 6;
    const TreeOptions options{.leaf_area_density_per_m = 0.0, .lean_max_deg = 10.0, .is_far = is_far};
    const Tree tree = make_tree(Species::kSpruce, 0.3, options, Dice(Random(2, "test"), 1));
    const std::vector<Ring> rings = rings_of(test::pieces_in(tree.trunk).at(0), sides);
    std::vector<double> heights_m = {-0.3, 0.0, 0.35, 1.3};
    for (std::size_t i = 1; i <= evenly; ++i)
      heights_m.push_back(1.3 + (tree.height_m - 1.3) * static_cast<double>(i) / static_cast<double>(evenly));
    ASSERT_EQ(rings.size(), heights_m.size());
    for (std::size_t i = 0; i < rings.size(); ++i) {
      EXPECT_LT((rings[i].center - axis_at(tree.crown, heights_m[i])).norm(), 1e-4) << i;
      const double radius_m = i == 0 ? 1.25 * trunk_radius(0.3, tree.height_m, 0.0)
                                     : std::max(0.005, trunk_radius(0.3, tree.height_m, heights_m[i]));
      EXPECT_NEAR(rings[i].radius_m, radius_m, 1e-5) << i;
    }
    EXPECT_GT(signed_volume_m3(tree.trunk), 0.0);
  }
}

struct Tube {
  Vector3d from, middle, to;
  double radius_m = 0.0;

  Vector3d way() const { return to - from; }
  double sag_m() const { return (middle - 0.5 * (from + to)).z(); }
};

/// A branch has three rings; it thins out to 0.6 of its radius in the middle and to 0.2 at its tip.
Tube tube_of(const Piece& piece, std::size_t sides) {
  const std::vector<Ring> rings = rings_of(piece, sides);
  EXPECT_EQ(rings.size(), 3U);
  EXPECT_NEAR(rings[1].radius_m, 0.6 * rings[0].radius_m, 1e-4 * rings[0].radius_m + 2e-6);
  EXPECT_NEAR(rings[2].radius_m, 0.2 * rings[0].radius_m, 1e-4 * rings[0].radius_m + 2e-6);
  EXPECT_LT((rings[1].center - 0.5 * (rings[0].center + rings[2].center)).head<2>().norm(), 1e-4);
  return {rings[0].center, rings[1].center, rings[2].center, rings[0].radius_m};
}

TEST(Trees, ConifersHaveWhorlsOfFourOrFiveBranchesAndPinesDeadStubsBelow) {
  for (const Species species : {Species::kPine, Species::kSpruce}) {
    const bool is_spruce = species == Species::kSpruce;
    std::vector<double> steps, jitters, lengths, rises, stub_heights, stub_lengths, stub_angles;
    int whorls = 0, fives = 0;
    for (std::uint32_t number = 0; number < 12; ++number) {
      const TreeOptions options{.leaf_area_density_per_m = 0.0, .lean_max_deg = 5.0};
      const Tree tree = make_tree(species, 0.35, options, Dice(Random(3, "test.whorls"), number));
      const Crown& crown = tree.crown;
      std::vector<Tube> branches;
      int stubs = 0;
      for (const Piece& piece : test::pieces_in(tree.branches)) {
        if (piece.size() == 12) {
          branches.push_back(tube_of(piece, 4));
          continue;
        }
        ASSERT_EQ(piece.size(), 9U);
        const Tube stub = tube_of(piece, 3);
        const double z_m = stub.from.z(), trunk_m = trunk_radius(0.35, tree.height_m, z_m);
        EXPECT_LT((stub.from - axis_at(crown, z_m)).norm(), 1e-4);
        EXPECT_NEAR(stub.way().z(), -0.05, 1e-4);
        EXPECT_NEAR(stub.sag_m(), 0.0, 1e-4);
        EXPECT_NEAR(stub.radius_m, 0.012, 1e-5);
        stub_heights.push_back(z_m / crown.base_m);
        stub_lengths.push_back(stub.way().head<2>().norm() - trunk_m);
        stub_angles.push_back(std::atan2(stub.way().y(), stub.way().x()));
        ++stubs;
      }
      EXPECT_EQ(stubs, is_spruce ? 0 : 8);
      double below_m = 0.0;  // the whorl before
      for (std::size_t i = 0; i < branches.size();) {
        const double z_m = branches[i].from.z();
        std::size_t end = i;
        while (end < branches.size() && std::abs(branches[end].from.z() - z_m) < 1e-4) ++end;
        const auto count = static_cast<double>(end - i);
        ASSERT_TRUE(count == 4 || count == 5) << count;
        ++whorls;
        fives += count == 5;
        if (i == 0) {
          EXPECT_NEAR(z_m, crown.base_m + 0.2, 1e-4);
        } else {
          steps.push_back((z_m - below_m) / (is_spruce ? 0.75 : 0.9));
        }
        below_m = z_m;
        EXPECT_LT(z_m, crown.top_m - 0.6);
        std::vector<double> turns;
        for (std::size_t k = i; k < end; ++k) {
          const Tube& branch = branches[k];
          const double length_m = branch.way().head<2>().norm();
          EXPECT_LT((branch.from - axis_at(crown, z_m)).norm(), 1e-4);
          lengths.push_back(length_m / (0.92 * crown.outer_radius_m(z_m)));
          rises.push_back(branch.way().z() / length_m);
          EXPECT_NEAR(branch.sag_m(), (is_spruce ? 0.04 : -0.04) * length_m, 1e-4);
          EXPECT_NEAR(branch.radius_m, std::min(0.012 + 0.012 * length_m, 0.8 * trunk_radius(0.35, tree.height_m, z_m)),
                      1e-5);
          turns.push_back(std::atan2(branch.way().y(), branch.way().x()));
        }
        // Evenly around, a fifth of a step to either side.
        for (std::size_t k = 1; k < turns.size(); ++k) {
          const double step = std::remainder(turns[k] - turns[k - 1], kTurn) * count / kTurn;
          jitters.push_back(step);
        }
        i = end;
      }
      EXPECT_GT(below_m + 1.2 * (is_spruce ? 0.75 : 0.9), crown.top_m - 0.6) << "up to the top";
    }
    expect_share(fives, whorls, 0.5);
    expect_uniform(steps, 0.8, 1.2, 1e-3);
    expect_uniform(lengths, 0.75, 1.0, 1e-3);
    if (is_spruce) {
      expect_uniform(rises, -0.25, 0.0, 1e-3);
    } else {
      expect_uniform(rises, 0.05, 0.35, 1e-3);
      expect_uniform(stub_heights, 0.45, 0.98, 1e-3);
      expect_uniform(stub_lengths, 0.15, 0.6, 1e-3);
      expect_uniform(stub_angles, -std::numbers::pi, std::numbers::pi);
    }
    const auto [least, most] = std::minmax_element(jitters.begin(), jitters.end());
    EXPECT_GE(*least, 0.6 - 1e-3);  // the difference of two numbers within 0.2 of zero
    EXPECT_LE(*most, 1.4 + 1e-3);
    EXPECT_LT(*least, 0.68);
    EXPECT_GT(*most, 1.32);
  }
}

TEST(Trees, BroadleafTreesHaveThirteenRisingBoughsThatFork) {
  std::vector<double> starts, rises, reaches, jitters, alongs;
  int forks = 0, boughs_seen = 0;
  Vector3d sum_of_forks = Vector3d::Zero();
  for (std::uint32_t number = 0; number < 30; ++number) {
    const TreeOptions options{.leaf_area_density_per_m = 0.0, .lean_max_deg = 5.0};
    const Tree tree = make_tree(Species::kBroadleaf, 0.4, options, Dice(Random(3, "test.boughs"), number));
    const Crown& crown = tree.crown;
    const double length_m = crown.top_m - crown.base_m;
    int boughs = 0, on_this = 0;
    Tube bough;
    double reach_m = 0.0;
    for (const Piece& piece : test::pieces_in(tree.branches)) {
      if (piece.size() == 15) {
        bough = tube_of(piece, 5);
        const double z_m = bough.from.z(), top_z_m = bough.to.z();
        EXPECT_LT((bough.from - axis_at(crown, z_m)).norm(), 1e-4);
        starts.push_back((z_m - crown.base_m) / (length_m * (0.02 + 0.7 * boughs / 12.0)));
        const Vector3d aside = bough.to - axis_at(crown, top_z_m);
        reach_m = aside.head<2>().norm();
        const double highest_m = crown.top_m - 0.1 * length_m;
        EXPECT_LE(top_z_m, highest_m + 1e-4);
        if (top_z_m < highest_m - 1e-3) rises.push_back((top_z_m - z_m) / length_m);
        reaches.push_back(reach_m / (0.88 * crown.outer_radius_m(top_z_m)));
        jitters.push_back(std::remainder(
            std::atan2(aside.y(), aside.x()) - boughs * std::numbers::pi * (3.0 - std::sqrt(5.0)), kTurn));
        EXPECT_NEAR(bough.radius_m, std::min(0.02 + 0.015 * reach_m, 0.7 * trunk_radius(0.4, tree.height_m, z_m)),
                    1e-5);
        EXPECT_NEAR(bough.sag_m(), -0.06 * reach_m, 1e-4);
        ++boughs;
        on_this = 0;
        continue;
      }
      ASSERT_EQ(piece.size(), 9U);
      const Tube fork = tube_of(piece, 3);
      EXPECT_LE(++on_this, 4);
      // It begins on the straight line of the bough, lower by its sag there.
      const double along =
          (fork.from - bough.from).head<2>().dot(bough.way().head<2>()) / bough.way().head<2>().squaredNorm();
      alongs.push_back(along);
      const Vector3d on_bough =
          bough.from + along * bough.way() - Vector3d(0, 0, 0.12 * reach_m * std::min(along, 1.0 - along));
      EXPECT_LT((fork.from - on_bough).norm(), 1e-3);
      const Vector3d direction = (fork.way() - Vector3d(0, 0, 0.15 * reach_m)) / (0.45 * reach_m);
      EXPECT_NEAR(direction.norm(), 1.0, 1e-3);
      sum_of_forks += direction;
      EXPECT_TRUE(crown.contains(fork.to));
      EXPECT_NEAR(fork.radius_m, 0.4 * bough.radius_m, 1e-5);
      EXPECT_NEAR(fork.sag_m(), 0.0, 1e-4);
      ++forks;
    }
    EXPECT_EQ(boughs, 13);
    boughs_seen += boughs;
  }
  expect_uniform(starts, 0.95, 1.0, 1e-3);
  expect_uniform(reaches, 0.8, 1.0, 1e-3);
  expect_uniform(jitters, -0.3, 0.3, 1e-3);
  const auto [lowest, highest] = std::minmax_element(rises.begin(), rises.end());
  EXPECT_GE(*lowest, 0.12 - 1e-3 - 0.05 * 0.72);
  EXPECT_LT(*lowest, 0.135);
  EXPECT_LE(*highest, 0.25 + 1e-3);
  EXPECT_GT(*highest, 0.235);
  const auto [first, last] = std::minmax_element(alongs.begin(), alongs.end());
  EXPECT_GE(*first, 0.35 - 1e-3);
  EXPECT_LT(*first, 0.37);
  EXPECT_LE(*last, 0.85 + 1e-3);
  EXPECT_GT(*last, 0.83);
  EXPECT_GT(forks, 2 * boughs_seen) << "most of four stay in the crown";
  EXPECT_LT(forks, 4 * boughs_seen);
}

// Needles: triangles as high as a cluster and 0.8 of it wide. Leaves: rhombi with these diagonals.
TEST(Trees, LeavesAreClustersOfOneSizeInsideTheCrownTurnedAnyWay) {
  for (const Species species : kAllSpecies) {
    const TreeOptions options{.leaf_area_density_per_m = 0.3, .leaf_cluster_m = 0.4, .lean_max_deg = 6.0};
    const Tree tree = make_tree(species, 0.3, options, Dice(Random(7, "test"), 4));
    const std::size_t corners = species == Species::kBroadleaf ? 4 : 3;
    std::vector<double> normals_z, alongs_z;
    for (const Piece& piece : test::pieces_in(tree.leaves)) {
      ASSERT_EQ(piece.size(), corners);
      Vector3d center = Vector3d::Zero(), along;
      for (const Vector3d& p : piece) center += p / static_cast<double>(corners);
      EXPECT_TRUE(tree.crown.contains(center)) << center.transpose();
      if (corners == 4) {
        along = piece[2] - piece[0];
        EXPECT_NEAR(along.norm(), 0.4, 1e-4);
        EXPECT_NEAR((piece[3] - piece[1]).norm(), 0.32, 1e-4);
        EXPECT_NEAR(along.dot(piece[3] - piece[1]), 0.0, 1e-4);
      } else {
        along = 0.5 * (piece[1] + piece[2]) - piece[0];
        EXPECT_NEAR(along.norm(), 0.4, 1e-4);
        EXPECT_NEAR((piece[2] - piece[1]).norm(), 0.32, 1e-4);
        EXPECT_NEAR(along.dot(piece[2] - piece[1]), 0.0, 1e-4);
      }
      normals_z.push_back((piece[1] - piece[0]).cross(piece[2] - piece[0]).normalized().z());
      alongs_z.push_back(along.normalized().z());
    }
    expect_uniform(normals_z, -1.0, 1.0);
    expect_uniform(alongs_z, -1.0, 1.0);
  }
}

double volume_of(const Crown& crown) {  // closed forms, less the hollow heart
  const double box = std::numbers::pi * crown.radius_m * crown.radius_m * (crown.top_m - crown.base_m);
  if (crown.species == Species::kSpruce) return box / 3.0 * (1.0 - 0.2 * 0.2);
  if (crown.species == Species::kBroadleaf) return box * 2.0 / 3.0 * (1.0 - 0.35 * 0.35);
  double sum = 0.0;
  for (int i = 0; i < 100000; ++i)
    sum += std::pow(std::sin(std::numbers::pi * std::pow((i + 0.5) / 100000, 0.8)), 1.2) / 100000;
  return box * sum * (1.0 - 0.2 * 0.2);
}

TEST(Trees, HaveAsManyLeavesAsTheirAreaInTheVolumeOfTheCrown) {
  for (const Species species : kAllSpecies) {
    for (const double size_m : {0.25, 0.5}) {
      const TreeOptions options{.leaf_area_density_per_m = 0.6, .leaf_cluster_m = size_m};
      const Tree tree = make_tree(species, 0.3, options, Dice(Random(8, "test"), 2));
      const double expected = 0.6 * volume_of(tree.crown) / (0.4 * size_m * size_m);
      EXPECT_NEAR(static_cast<double>(test::pieces_in(tree.leaves).size()), expected, 0.001 * expected + 1.0);
    }
  }
}

// As long as a cluster is small, its middle is spread as the volume is: half of the leaves in the outer half of the
// volume of any slice.
TEST(Trees, LeavesFillTheCrownEvenly) {
  for (const Species species : kAllSpecies) {
    const TreeOptions options{.leaf_area_density_per_m = 0.5, .leaf_cluster_m = 0.2};
    const Tree tree = make_tree(species, 0.35, options, Dice(Random(9, "test"), 3));
    const double hollow_sq = species == Species::kBroadleaf ? 0.35 * 0.35 : 0.04;
    std::vector<double> shares, angles;
    for (const Piece& piece : test::pieces_in(tree.leaves)) {
      Vector3d center = Vector3d::Zero();
      for (const Vector3d& p : piece) center += p / static_cast<double>(piece.size());
      const Vector2d from_axis = (center - axis_at(tree.crown, center.z())).head<2>();
      const double outer_m = tree.crown.outer_radius_m(center.z());
      shares.push_back((from_axis.squaredNorm() / (outer_m * outer_m) - hollow_sq) / (1.0 - hollow_sq));
      angles.push_back(std::atan2(from_axis.y(), from_axis.x()));
    }
    expect_uniform(shares, 0.0, 1.0, 1e-3);
    expect_uniform(angles, -std::numbers::pi, std::numbers::pi);
  }
}

struct Planted {
  Scene scene;
  TreeStock::Measures measures;
};

Planted plant(Species species, double dbh_m, double factor, bool named) {
  SceneBuilder builder;
  const TreeStock stock(builder, species, {0.15, 0.3, 0.5},
                        {.leaf_area_density_per_m = 0.2, .leaf_cluster_m = 0.4, .lean_max_deg = 4.0},
                        Random(6, "test"));
  const Vector3d foot(4.0, -7.0, 2.0);
  if (named) {
    stock.place(builder, foot, dbh_m, factor, 1.1);
  } else {
    stock.place_nameless(builder, foot, dbh_m, factor, 1.1);
  }
  return {builder.finish(), stock.measures(dbh_m, factor)};
}

TEST(TreeStock, ScalesTheNearestTreeToItsDiameterAtBreastHeightAndItsHeight) {
  for (const Species species : kAllSpecies) {
    for (const double dbh_m : {0.14, 0.22, 0.23, 0.39, 0.41, 0.6}) {
      for (const double factor : {0.6, 1.0, 1.15}) {
        const auto [scene, measures] = plant(species, dbh_m, factor, true);
        ASSERT_EQ(scene.instances.size(), 3U);
        const double model_m = dbh_m < 0.225 ? 0.15 : dbh_m < 0.4 ? 0.3 : 0.5;
        const double height_m = factor * height_by_diameter_m(species, dbh_m);
        const double model_height_m = height_by_diameter_m(species, model_m), vertical = height_m / model_height_m;
        const double horizontal = 0.5 * dbh_m / trunk_radius(model_m, model_height_m, 1.3 / vertical);
        double reach_m = 0.0, leaves_from_m = 1e9;
        for (const Instance& instance : scene.instances) {
          EXPECT_EQ(instance.instance, 1);
          const Eigen::Matrix3f linear = instance.T_world_mesh.linear();
          EXPECT_NEAR(linear.col(0).norm(), horizontal, 1e-4);
          EXPECT_NEAR(linear.col(1).norm(), horizontal, 1e-4);
          EXPECT_NEAR(linear(2, 2), vertical, 1e-4);
          EXPECT_NEAR(std::atan2(linear(1, 0), linear(0, 0)), 1.1, 1e-4);
          EXPECT_TRUE(instance.T_world_mesh.translation().isApprox(Eigen::Vector3f(4, -7, 2), 1e-6F));
          const Mesh& mesh = scene.meshes[instance.mesh];
          for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) {
            const Vector3d p = (instance.T_world_mesh * vertex).cast<double>() - Vector3d(4, -7, 2);
            reach_m = std::max(reach_m, p.head<2>().norm());
            if (mesh.surface_class == SurfaceClass::kVegetation) leaves_from_m = std::min(leaves_from_m, p.z());
          }
        }
        EXPECT_NEAR(measures.height_m, height_m, 1e-9);
        EXPECT_NEAR(measures.crown_radius_m, reach_m, 1e-4);
        EXPECT_LE(measures.crown_base_m, leaves_from_m + 1e-4);
        EXPECT_GT(measures.crown_base_m, leaves_from_m - 0.05 * height_m);
        const WorldObject& tree = scene.objects.at(0);
        EXPECT_EQ(attribute(tree, "dbh_m"), dbh_m);
        EXPECT_EQ(attribute(tree, "height_m"), height_m);
        EXPECT_EQ(attribute(tree, "crown_base_m"), measures.crown_base_m);
        const Law law = law_of(species);
        const double mean_radius_m = horizontal * (law.radius_m + law.radius_per_dbh * model_m);
        EXPECT_NEAR(attribute(tree, "crown_radius_m"), mean_radius_m, 0.1 * mean_radius_m + 1e-9);
        EXPECT_EQ(tree.yaw_rad, 1.1);
        EXPECT_EQ(tree.kind, name_of(species));
        EXPECT_EQ(tree.position_world_m, Vector3d(4, -7, 2));
      }
    }
    const Scene nameless = plant(species, 0.3, 1.0, false).scene;
    EXPECT_TRUE(nameless.objects.empty());
    ASSERT_EQ(nameless.instances.size(), 3U);
    for (const Instance& instance : nameless.instances) EXPECT_EQ(instance.instance, 0);
  }
}

// ---- What grows below them.

std::vector<Mesh> undergrowth_of(double detail, bool bush) {
  SceneBuilder builder;
  const UndergrowthStock stock(builder, detail, Random(3, "test"));
  const auto kind = bush ? UndergrowthStock::Kind::kBush : UndergrowthStock::Kind::kGrass;
  for (std::uint32_t i = 0; i < 200; ++i) {
    Dice dice(Random(4, "test"), i);
    stock.place(builder, kind, Vector3d::Zero(), 1.0, dice);
  }
  Scene scene = builder.finish();
  EXPECT_EQ(scene.meshes.size(), 6U) << "six of each kind";
  std::map<std::uint32_t, int> uses;
  for (const Instance& instance : scene.instances) ++uses[instance.mesh];
  for (const auto& [mesh, count] : uses) expect_share(count, 200, 1.0 / 6.0);
  return scene.meshes;
}

TEST(Undergrowth, BushesAreLeavesInHalfAnEllipsoidOnFourStems) {
  for (const double detail : {0.05, 0.3, 1.0, 4.0}) {
    const std::size_t leaves_expected = std::max(12L, std::lround(70.0 * detail));
    const double leaf_m = 0.16 / std::sqrt(std::max(0.1, detail));
    std::vector<double> volumes, heights, stem_angles, normals_z;
    for (const Mesh& bush : undergrowth_of(detail, true)) {
      std::size_t leaves = 0, stems = 0;
      for (const Piece& piece : test::pieces_in(bush)) {
        if (piece.size() == 6) {
          const std::vector<Ring> rings = rings_of(piece, 3);
          EXPECT_LT((rings[0].center - Vector3d(0, 0, -0.1)).norm(), 1e-5);
          EXPECT_NEAR(rings[0].radius_m, 0.012, 1e-5);
          EXPECT_NEAR(rings[1].radius_m, 0.004, 1e-5);
          EXPECT_NEAR(rings[1].center.z(), 0.7, 1e-5);
          EXPECT_NEAR(rings[1].center.head<2>().norm(), 0.4, 1e-5);
          stem_angles.push_back(std::atan2(rings[1].center.y(), rings[1].center.x()));
          ++stems;
          continue;
        }
        ASSERT_EQ(piece.size(), 3U);
        const Vector3d center = (piece[0] + piece[1] + piece[2]) / 3.0;
        EXPECT_NEAR((piece[0] - center).norm(), leaf_m, 1e-4);
        EXPECT_NEAR((piece[1] - piece[2]).norm(), 1.4 * leaf_m, 1e-4);
        EXPECT_NEAR((0.5 * (piece[1] + piece[2]) - center).norm(), 0.5 * leaf_m, 1e-4);
        EXPECT_NEAR((piece[1] - piece[2]).dot(piece[0] - center), 0.0, 1e-4);
        const Vector3d unit(center.x() / 0.55, center.y() / 0.55, (center.z() - 0.15) / 0.8);
        EXPECT_GE(unit.z(), -1e-5);
        volumes.push_back(std::pow(unit.norm(), 3));
        heights.push_back(unit.normalized().z());
        normals_z.push_back((piece[1] - piece[0]).cross(piece[2] - piece[0]).normalized().z());
        ++leaves;
      }
      EXPECT_EQ(leaves, leaves_expected) << detail;
      EXPECT_EQ(stems, 4U);
    }
    expect_uniform(volumes, 0.1, 1.0, 1e-3);
    expect_uniform(heights, 0.0, 1.0, 1e-3);
    expect_uniform(normals_z, -1.0, 1.0, 1e-3);
  }
}

TEST(Undergrowth, GrassIsBladesThatBendOutward) {
  std::vector<double> heights, bends, feet, angles;
  for (const double detail : {0.1, 1.0, 3.0}) {
    const std::size_t expected = std::max(6L, std::lround(14.0 * detail));
    for (const Mesh& clump : undergrowth_of(detail, false)) {
      const auto blades = test::pieces_in(clump);
      EXPECT_EQ(blades.size(), expected) << detail;
      for (const Piece& blade : blades) {
        ASSERT_EQ(blade.size(), 3U);
        EXPECT_NEAR((blade[1] - blade[0]).norm(), 0.04, 1e-5);
        EXPECT_NEAR(blade[0].z(), -0.05, 1e-5);
        EXPECT_NEAR(blade[1].z(), -0.05, 1e-5);
        const Vector3d foot = 0.5 * (blade[0] + blade[1]), way = blade[2] - foot;
        EXPECT_NEAR(way.head<2>().dot((blade[1] - blade[0]).head<2>()), 0.0, 1e-5);
        heights.push_back(way.z());
        bends.push_back(way.head<2>().norm());
        feet.push_back(foot.head<2>().dot(way.head<2>().normalized()));
        EXPECT_NEAR(std::abs(feet.back()), foot.head<2>().norm(), 1e-5);
        angles.push_back(std::atan2(way.y(), way.x()));
      }
    }
  }
  expect_uniform(heights, 0.25, 0.55);
  expect_uniform(bends, 0.05, 0.3);
  expect_uniform(feet, 0.0, 0.08);
  expect_uniform(angles, -std::numbers::pi, std::numbers::pi);
}

TEST(Undergrowth, ReachesAsFarAsItsWidestPlant) {
  SceneBuilder builder;
  const UndergrowthStock stock(builder, 1.0, Random(3, "test"));
  for (const bool bush : {true, false}) {
    const auto kind = bush ? UndergrowthStock::Kind::kBush : UndergrowthStock::Kind::kGrass;
    double widest_m = 0.0;
    for (const Mesh& mesh : undergrowth_of(1.0, bush)) {
      for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m)
        widest_m = std::max<double>(widest_m, vertex.head<2>().norm());
    }
    EXPECT_NEAR(stock.reach_m(kind, 1.0), widest_m, 1e-6);
    EXPECT_NEAR(stock.reach_m(kind, 2.5), 2.5 * widest_m, 1e-6);
  }
}

TEST(Undergrowth, IsPlacedScaledAndTurnedAsItsEntrySays) {
  SceneBuilder builder;
  const UndergrowthStock stock(builder, 0.3, Random(3, "test"));
  std::vector<double> yaws;
  for (std::uint32_t i = 0; i < 100; ++i) {
    Dice dice(Random(4, "test"), i);
    stock.place(builder, i % 2 == 0 ? UndergrowthStock::Kind::kBush : UndergrowthStock::Kind::kGrass, {1.0, 2.0, 3.0},
                1.5, dice);
  }
  const Scene scene = builder.finish();
  ASSERT_EQ(scene.objects.size(), 100U);
  for (std::size_t i = 0; i < 100; ++i) {
    const WorldObject& plant = scene.objects[i];
    EXPECT_EQ(plant.kind, i % 2 == 0 ? "bush" : "grass");
    EXPECT_EQ(plant.instance, i + 1);
    EXPECT_EQ(attribute(plant, "scale"), 1.5);
    yaws.push_back(plant.yaw_rad);
    const Eigen::Matrix3f linear = scene.instances[i].T_world_mesh.linear();
    EXPECT_NEAR(linear(2, 2), 1.5, 1e-5);
    EXPECT_NEAR(std::remainder(std::atan2(linear(1, 0), linear(0, 0)) - plant.yaw_rad, kTurn), 0.0, 1e-5);
  }
  expect_uniform(yaws, 0.0, kTurn);
}

// ---- Where they stand.

ForestConfig bare_ground(double size_m) {
  ForestConfig config;
  config.size_m = {size_m, size_m};
  config.stems_per_ha = config.bushes_per_ha = config.grass_per_ha = config.fallen_per_ha = config.rocks_per_ha = 0.0;
  config.surroundings_m = 0.0;
  config.detail = 0.05;
  config.ground_cell_m = 5.0;
  return config;
}

TEST(Forest, UndergrowthIsAsDenseAndAsLargeAsToldEverywhere) {
  ForestConfig config = bare_ground(100.0);
  config.size_m = {100.0, 60.0};
  config.bushes_per_ha = 700.0;
  config.grass_per_ha = 500.0;
  const Relief relief(config.relief, 2);
  std::vector<double> bush_scales, grass_scales, xs, ys;
  for (const WorldObject& plant : objects_of(make_forest(config, 2), SurfaceClass::kUndergrowth)) {
    (plant.kind == "bush" ? bush_scales : grass_scales).push_back(attribute(plant, "scale"));
    xs.push_back(plant.position_world_m.x());
    ys.push_back(plant.position_world_m.y());
    EXPECT_NEAR(plant.position_world_m.z(), relief.height_m(xs.back(), ys.back()), 1e-9);
  }
  EXPECT_EQ(bush_scales.size(), 420U);
  EXPECT_EQ(grass_scales.size(), 300U);
  expect_uniform(bush_scales, 0.6, 1.6);
  expect_uniform(grass_scales, 0.7, 1.5);
  expect_uniform(xs, -50.0, 50.0);
  expect_uniform(ys, -30.0, 30.0);
}

TEST(Forest, FallenTrunksLieOnTheGroundAndThinOutWithSnags) {
  ForestConfig config = bare_ground(200.0);
  config.fallen_per_ha = 100.0;
  config.relief.amplitude_m = 0.4;
  const Scene scene = make_forest(config, 3);
  const Relief relief(config.relief, 3);
  const auto trunks = objects_of(scene, SurfaceClass::kFallenTrunk);
  ASSERT_GT(trunks.size(), 380U);
  std::map<std::uint16_t, const WorldObject*> by_number;
  for (const WorldObject& trunk : trunks) by_number[trunk.instance] = &trunk;
  std::vector<double> lengths, radii, yaws, snag_lengths, snag_z, snag_rings;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (mesh.surface_class != SurfaceClass::kFallenTrunk) continue;
    const WorldObject& trunk = *by_number.at(instance.instance);
    const auto pieces = test::pieces_in(mesh);
    ASSERT_EQ(pieces.size(), 7U) << "with six snags";
    const std::vector<Ring> rings = rings_of(pieces[0], 8);
    ASSERT_EQ(rings.size(), 6U);
    const double radius_m = 0.5 * attribute(trunk, "diameter_m"), length_m = attribute(trunk, "length_m");
    const Vector2d foot = trunk.position_world_m.head<2>();
    EXPECT_NEAR(trunk.position_world_m.z(), relief.height_m(foot.x(), foot.y()), 1e-9);
    const Vector2d tip = rings[5].center.head<2>();
    EXPECT_NEAR((tip - foot).norm(), length_m, 1e-3);
    const bool is_cut = tip.cwiseAbs().maxCoeff() > 100.0 - 1e-3;
    EXPECT_LE(tip.cwiseAbs().maxCoeff(), 100.0 + 1e-3);
    radii.push_back(radius_m);
    if (!is_cut) {
      lengths.push_back(length_m);
      yaws.push_back(trunk.yaw_rad);
      EXPECT_NEAR(std::remainder(std::atan2((tip - foot).y(), (tip - foot).x()) - trunk.yaw_rad, kTurn), 0.0, 1e-3);
    }
    for (int i = 0; i < 6; ++i) {
      const double t = i / 5.0, here_m = radius_m * (1.0 - 0.6 * t);
      const Vector2d at = foot + t * (tip - foot);
      EXPECT_LT((rings[i].center.head<2>() - at).norm(), 1e-3);
      EXPECT_NEAR(rings[i].radius_m, here_m, 1e-4);
      EXPECT_NEAR(rings[i].center.z(), relief.height_m(at.x(), at.y()) + 0.7 * here_m, 1e-4);
    }
    for (std::size_t snag = 1; snag < 7; ++snag) {
      const std::vector<Ring> ends = rings_of(pieces[snag], 4);
      ASSERT_EQ(ends.size(), 2U);
      EXPECT_NEAR(ends[0].radius_m, 0.03, 1e-4);
      EXPECT_NEAR(ends[1].radius_m, 0.012, 1e-4);
      int ring = 0;
      while (ring < 6 && (rings[ring].center - ends[0].center).norm() > 1e-3) ++ring;
      ASSERT_LT(ring, 6) << "a snag that begins on no ring";
      EXPECT_GE(ring, 1);
      snag_rings.push_back(ring);
      const Vector3d way = ends[1].center - ends[0].center;
      snag_lengths.push_back(way.norm() - rings[ring].radius_m);
      snag_z.push_back(way.normalized().z());
    }
  }
  expect_uniform(lengths, 4.0, 12.0);
  expect_uniform(radii, 0.08, 0.22);
  expect_uniform(yaws, 0.0, kTurn);
  expect_uniform(snag_lengths, 0.2, 0.475, 2e-4);
  expect_uniform(snag_z, 0.0, 1.0, 1e-3);
  for (int ring = 1; ring < 6; ++ring) {
    expect_share(static_cast<double>(std::count(snag_rings.begin(), snag_rings.end(), ring)),
                 static_cast<double>(snag_rings.size()), 0.2);
  }
}

TEST(Forest, FallenTrunksOfLessThanAMeterAreLeftOut) {
  ForestConfig config = bare_ground(40.0);
  config.fallen_per_ha = 20000.0;
  double shortest_m = 1e9;
  for (const WorldObject& trunk : objects_of(make_forest(config, 1), SurfaceClass::kFallenTrunk))
    shortest_m = std::min(shortest_m, attribute(trunk, "length_m"));
  EXPECT_GE(shortest_m, 1.0);
  EXPECT_LT(shortest_m, 1.1) << "at the border they are cut";
}

// What could reach into a clearing is left out: with half of the way to the next ring, its own radius and a snag.
TEST(Forest, FallenTrunksKeepOffClearingsByWhatTheyReach) {
  ForestConfig config = bare_ground(60.0);
  config.fallen_per_ha = 3000.0;
  const auto all = objects_of(make_forest(config, 4), SurfaceClass::kFallenTrunk);
  config.keep_clear.clearings = {{{3.0, -5.0}, 8.0}};
  std::set<std::pair<double, double>> left;
  for (const WorldObject& trunk : objects_of(make_forest(config, 4), SurfaceClass::kFallenTrunk))
    left.insert({trunk.position_world_m.x(), trunk.position_world_m.y()});
  int gone = 0;
  for (const WorldObject& trunk : all) {
    const Vector2d foot = trunk.position_world_m.head<2>();
    const Vector2d way = attribute(trunk, "length_m") * Vector2d(std::cos(trunk.yaw_rad), std::sin(trunk.yaw_rad));
    const Vector2d tip = foot + way;
    if (tip.cwiseAbs().maxCoeff() > 29.0) continue;  // cut at the border
    double nearest_m = 1e9;
    for (int i = 0; i < 6; ++i)
      nearest_m = std::min(nearest_m, config.keep_clear.distance_m(foot + 0.2 * i * (tip - foot)));
    const double reach_m = 0.1 * attribute(trunk, "length_m") + 0.5 * attribute(trunk, "diameter_m") + 0.5;
    if (std::abs(nearest_m - reach_m) < 1e-6) continue;
    EXPECT_EQ(left.contains({foot.x(), foot.y()}), nearest_m > reach_m) << nearest_m << " " << reach_m;
    gone += nearest_m <= reach_m;
  }
  EXPECT_GT(gone, 50);
}

TEST(Forest, RocksAreDentedHalfSpheresThatKeepOffClearings) {
  ForestConfig config = bare_ground(100.0);
  config.rocks_per_ha = 500.0;
  const Scene scene = make_forest(config, 5);
  const Relief relief(config.relief, 5);
  std::map<std::uint16_t, Eigen::AlignedBox3d> boxes = test::bounds_of_each(scene, SurfaceClass::kObject);
  std::vector<double> radii, dents;
  std::vector<std::array<double, 3>> scales;
  Mesh ball;
  add_icosphere(ball, Eigen::Vector3f::Zero(), 1.0F, 1);
  const auto rocks = objects_of(scene, SurfaceClass::kObject);
  ASSERT_EQ(rocks.size(), 500U);
  std::size_t next = 0;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (mesh.surface_class != SurfaceClass::kObject) continue;
    const WorldObject& rock = rocks[next++];
    EXPECT_EQ(rock.instance, instance.instance);
    EXPECT_EQ(rock.yaw_rad, 0.0);
    ASSERT_EQ(mesh.vertices_mesh_m.size(), ball.vertices_mesh_m.size());
    const Vector3d foot = rock.position_world_m;
    EXPECT_NEAR(foot.z(), relief.height_m(foot.x(), foot.y()), 1e-9);
    const double radius_m = attribute(rock, "radius_m");
    radii.push_back(radius_m);
    // Dents are at most a tenth outward: the scale of an axis by the largest of all ratios.
    std::array<double, 3> largest{};
    for (std::size_t i = 0; i < mesh.vertices_mesh_m.size(); ++i) {
      const Vector3d p = mesh.vertices_mesh_m[i].cast<double>() - foot, b = ball.vertices_mesh_m[i].cast<double>();
      for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(b[axis]) < 0.3) continue;
        largest[axis] = std::max(largest[axis], p[axis] / b[axis] / radius_m);
      }
    }
    scales.push_back(largest);
  }
  expect_uniform(radii, 0.15, 0.6);
  for (int axis = 0; axis < 3; ++axis) {  // times a dent, whose largest of some forty lies near 1.1
    double least = 1e9, most = 0.0;
    for (const auto& scale : scales) least = std::min(least, scale[axis]), most = std::max(most, scale[axis]);
    EXPECT_NEAR(least, (axis == 2 ? 0.5 : 0.8) * 1.09, 0.03);
    EXPECT_NEAR(most, (axis == 2 ? 0.9 : 1.2) * 1.09, 0.03);
  }
  config.keep_clear.clearings = {{{10.0, 5.0}, 30.0}};
  std::size_t expected = 0;
  for (const WorldObject& rock : rocks)
    expected += config.keep_clear.distance_m(rock.position_world_m.head<2>()) >= 1.4 * attribute(rock, "radius_m");
  EXPECT_EQ(objects_of(make_forest(config, 5), SurfaceClass::kObject).size(), expected);
  EXPECT_LT(expected, 400U);
}

// Dents are between 0.85 and 1.1: the ratio of two corners that have the same height and distance on the ball.
TEST(Forest, DentsOfRocksAreBetweenAllOfTheirRange) {
  ForestConfig config = bare_ground(60.0);
  config.rocks_per_ha = 600.0;
  Mesh ball;
  add_icosphere(ball, Eigen::Vector3f::Zero(), 1.0F, 1);
  double least = 1e9, most = 0.0;
  const Scene scene = make_forest(config, 6);
  const auto rocks = objects_of(scene, SurfaceClass::kObject);
  std::size_t next = 0;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (mesh.surface_class != SurfaceClass::kObject) continue;
    const Vector3d foot = rocks[next++].position_world_m;
    for (std::size_t i = 0; i < ball.vertices_mesh_m.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const Eigen::Vector3f &a = ball.vertices_mesh_m[i], &b = ball.vertices_mesh_m[j];
        if ((a + b).norm() > 1e-4F) continue;  // opposite corners
        const double ratio = (mesh.vertices_mesh_m[i].cast<double>() - foot).norm() /
                             (mesh.vertices_mesh_m[j].cast<double>() - foot).norm();
        least = std::min({least, ratio, 1.0 / ratio}), most = std::max({most, ratio, 1.0 / ratio});
      }
    }
  }
  EXPECT_LE(most, 1.1 / 0.85 + 1e-3);
  EXPECT_GT(most, 0.98 * 1.1 / 0.85);
  EXPECT_NEAR(least, 1.0 / most, 1e-9);
}

// A trunk may be as near as its foot, a meter and its lean, where its crown is above the zone; else the crown decides.
TEST(Forest, TreesKeepOffTrailsByWhatTheyReachAndNoFurther) {
  ForestConfig config = bare_ground(60.0);
  config.stems_per_ha = 900.0;
  config.lean_max_deg = 4.0;
  config.relief.amplitude_m = 1.0;
  const Scene whole = make_forest(config, 7);
  const auto all = objects_of(whole, SurfaceClass::kTrunk);
  config.keep_clear.trails = {{{{-30, -12, 0}, {30, 12, 0}}, 5.0}};
  std::map<std::uint16_t, std::pair<double, double>> reach_and_base;  // of the tree from its foot's vertical; crown
  std::map<std::uint16_t, Vector3d> feet;
  for (const WorldObject& tree : all) feet[tree.instance] = tree.position_world_m;
  for (const Instance& instance : whole.instances) {
    const Mesh& mesh = whole.meshes[instance.mesh];
    if (mesh.surface_class != SurfaceClass::kTrunk && mesh.surface_class != SurfaceClass::kBranch &&
        mesh.surface_class != SurfaceClass::kVegetation)
      continue;
    double& reach_m = reach_and_base[instance.instance].first;
    for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) {
      const Vector3d p = (instance.T_world_mesh * vertex).cast<double>() - feet.at(instance.instance);
      reach_m = std::max(reach_m, p.head<2>().norm());
    }
  }
  for (const double clear_m : {2.0, 8.0, 40.0}) {
    config.keep_clear.clear_height_m = clear_m;
    std::set<std::pair<double, double>> left;
    for (const WorldObject& tree : objects_of(make_forest(config, 7), SurfaceClass::kTrunk))
      left.insert({tree.position_world_m.x(), tree.position_world_m.y()});
    for (const WorldObject& tree : all) {
      const Vector3d foot = tree.position_world_m;
      const double crown_m = reach_and_base.at(tree.instance).first;
      const double trunk_m =
          attribute(tree, "dbh_m") + 1.0 + std::tan(4.0 * std::numbers::pi / 180.0) * attribute(tree, "height_m");
      const bool above = foot.z() + attribute(tree, "crown_base_m") >= 1.0 + clear_m;
      const double reach_m = above ? std::min(trunk_m, crown_m) : crown_m;
      const double free_m = config.keep_clear.distance_m(foot.head<2>());
      if (std::abs(free_m - reach_m) < 1e-3) continue;
      EXPECT_EQ(left.contains({foot.x(), foot.y()}), free_m > reach_m) << free_m << " " << reach_m;
    }
  }
}

TEST(Forest, StemsAreSpreadEvenlyTurnedAnyWayAndScatterInHeight) {
  ForestConfig config = bare_ground(200.0);
  config.size_m = {200.0, 150.0};
  config.stems_per_ha = 600.0;
  config.min_spacing_m = 0.1;
  config.ground_cell_m = 20.0;
  std::vector<double> xs, ys, yaws;
  double sum_of_squares = 0.0, most = 0.0;
  const auto trees = objects_of(make_forest(config, 8), SurfaceClass::kTrunk);
  ASSERT_EQ(trees.size(), 1800U);
  for (const WorldObject& tree : trees) {
    xs.push_back(tree.position_world_m.x());
    ys.push_back(tree.position_world_m.y());
    yaws.push_back(tree.yaw_rad);
    const Species species = tree.kind == "pine"     ? Species::kPine
                            : tree.kind == "spruce" ? Species::kSpruce
                                                    : Species::kBroadleaf;
    const double off = attribute(tree, "height_m") / height_by_diameter_m(species, attribute(tree, "dbh_m")) - 1.0;
    sum_of_squares += off * off / 1800.0;
    most = std::max(most, std::abs(off));
  }
  expect_uniform(xs, -100.0, 100.0);
  expect_uniform(ys, -75.0, 75.0);
  expect_uniform(yaws, 0.0, kTurn);
  EXPECT_NEAR(std::sqrt(sum_of_squares), 0.07, 0.005);  // a normal distribution, cut at 2.5 of its deviations
  EXPECT_LE(most, 0.175 + 1e-9);
  EXPECT_GT(most, 0.16);
}

TEST(Forest, TreesAreCopiesOfModelsAtEvenQuantilesOfTheDiameters) {
  ForestConfig config = bare_ground(120.0);
  config.stems_per_ha = 600.0;
  config.variants = 5;
  config.leaf_area_density_per_m = 0.4;
  config.detail = 0.5;
  const Scene scene = make_forest(config, 1);
  std::map<std::string, std::vector<double>> models;  // by their bark
  double leaves = 0.0;
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.surface_class == SurfaceClass::kTrunk)
      models[scene.materials[mesh.material].name].push_back(2.0 *
                                                            rings_of(test::pieces_in(mesh).at(0), 10)[3].radius_m);
    if (mesh.surface_class != SurfaceClass::kVegetation) continue;
    for (const Piece& leaf : test::pieces_in(mesh)) {
      const Vector3d along = leaf.size() == 4 ? leaf[2] - leaf[0] : Vector3d(0.5 * (leaf[1] + leaf[2]) - leaf[0]);
      ASSERT_NEAR(along.norm(), 0.28, 1e-4) << "0.28 / sqrt(2) m at a detail of 1, and half of the leaves";
      leaves += 1.0;
    }
  }
  EXPECT_GT(leaves, 1000.0);
  ASSERT_EQ(models.size(), 3U);
  for (auto& [bark, diameters_m] : models) {
    ASSERT_EQ(diameters_m.size(), 5U) << bark;
    std::sort(diameters_m.begin(), diameters_m.end());
    for (std::size_t i = 0; i < 5; ++i) {
      const double share = (static_cast<double>(i) + 0.5) / 5.0;
      EXPECT_NEAR(diameters_m[i], 0.07 + 0.20 * std::pow(-std::log(1.0 - share), 1.0 / 2.2), 1e-5) << bark;
    }
  }
}

TEST(Forest, FindsRoomForEveryStemAsLongAsThereIsAny) {
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

// Trees of few triangles: leaves of 0.9 m up to 12 m beyond the edge, of 2 m further out, as dense as the place.
TEST(Forest, SurroundingsAreAsDenseAsThePlaceWithCoarserTreesFurtherOut) {
  ForestConfig config = bare_ground(40.0);
  config.size_m = {50.0, 30.0};
  config.stems_per_ha = 500.0;
  config.min_spacing_m = 1.5;
  config.surroundings_m = 40.0;
  config.detail = 0.7;
  config.keep_clear.clearings = {{{40.0, 0.0}, 6.0}};
  const Scene scene = make_forest(config, 9);
  std::vector<Vector2d> feet;
  Eigen::AlignedBox3d ground;
  bool past_place = false;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (mesh.surface_class == SurfaceClass::kGround) {
      for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) ground.extend(vertex.cast<double>());
    }
    if (instance.instance != 0 || mesh.surface_class == SurfaceClass::kGround) continue;
    past_place = true;
    EXPECT_NE(mesh.surface_class, SurfaceClass::kBranch);
    const Vector2d foot = instance.T_world_mesh.translation().head<2>().cast<double>();
    const double beyond_m = (foot.cwiseAbs() - Vector2d(25.0, 15.0)).maxCoeff();
    EXPECT_GE(beyond_m, 1.5 - 1e-5);
    EXPECT_LE(beyond_m, 40.0 + 1e-5);
    if (mesh.surface_class == SurfaceClass::kTrunk) {
      feet.push_back(foot);
      EXPECT_EQ(mesh.vertices_mesh_m.size(), 30U);  // six rings of five sides
      continue;
    }
    const Piece leaf = test::pieces_in(mesh).at(0);
    const Vector3d along = leaf.size() == 4 ? leaf[2] - leaf[0] : Vector3d(0.5 * (leaf[1] + leaf[2]) - leaf[0]);
    EXPECT_NEAR(along.norm(), beyond_m < 12.0 ? 0.9 : 2.0, 1e-3) << beyond_m;
  }
  EXPECT_TRUE(past_place);
  // 5 stems on 100 m^2 of a frame 40 m wide; the clearing takes some.
  const double expected = 500.0 * ((130.0 * 110.0) - 50.0 * 30.0) / 1e4;
  EXPECT_LE(feet.size(), static_cast<std::size_t>(std::lround(expected)));
  EXPECT_GT(feet.size(), 0.93 * expected);
  double in_corners = 0.0, to_clearing_m = 1e9;
  for (std::size_t i = 0; i < feet.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) ASSERT_GE((feet[i] - feet[j]).norm(), 1.5 - 1e-4);
    in_corners += std::abs(feet[i].x()) > 25.0 && std::abs(feet[i].y()) > 15.0;
    to_clearing_m = std::min(to_clearing_m, config.keep_clear.distance_m(feet[i]));
  }
  expect_share(in_corners, static_cast<double>(feet.size()), 4.0 * 40.0 * 40.0 / (130.0 * 110.0 - 50.0 * 30.0));
  EXPECT_GT(to_clearing_m, 0.5) << "crowns stay out of it";
  EXPECT_LT(to_clearing_m, 4.0);
  EXPECT_NEAR(ground.max().x(), 25.0 + 80.0, 1e-3) << "the ground goes on twice as far";
  EXPECT_NEAR(ground.max().y(), 15.0 + 80.0, 1e-3);
}

TEST(Field, TreesAndBushesAreLowInTheOpenAndAsManyAsAsked) {
  FieldConfig config;
  config.size_m = {400.0, 300.0};
  config.num_trees = 800;
  config.num_bushes = 700;
  config.min_distance_m = 1.0;
  config.detail = 0.05;
  const Scene scene = make_field(config, 4);
  std::vector<double> diameters_m, yaws, scales, xs, ys;
  std::vector<double> factors_of_pines, factors_of_broadleaf;
  for (const WorldObject& tree : objects_of(scene, SurfaceClass::kTrunk)) {
    diameters_m.push_back(attribute(tree, "dbh_m"));
    yaws.push_back(tree.yaw_rad);
    const bool is_pine = tree.kind == "pine";
    (is_pine ? factors_of_pines : factors_of_broadleaf)
        .push_back(attribute(tree, "height_m") /
                   height_by_diameter_m(is_pine ? Species::kPine : Species::kBroadleaf, diameters_m.back()));
    xs.push_back(tree.position_world_m.x());
    ys.push_back(tree.position_world_m.y());
  }
  ASSERT_EQ(diameters_m.size(), 800U);
  expect_uniform(diameters_m, 0.2, 0.5);
  expect_uniform(yaws, 0.0, kTurn);
  expect_uniform(factors_of_pines, 0.6, 0.8);
  expect_uniform(factors_of_broadleaf, 0.6, 0.8);
  expect_share(static_cast<double>(factors_of_broadleaf.size()), 800, 0.7);
  EXPECT_GT(*std::max_element(xs.begin(), xs.end()), 198.0);
  EXPECT_LT(*std::min_element(xs.begin(), xs.end()), -198.0);
  EXPECT_GT(*std::max_element(ys.begin(), ys.end()), 148.0);
  EXPECT_LT(*std::min_element(ys.begin(), ys.end()), -148.0);
  for (const WorldObject& bush : objects_of(scene, SurfaceClass::kUndergrowth))
    scales.push_back(attribute(bush, "scale"));
  ASSERT_EQ(scales.size(), 700U);
  expect_uniform(scales, 0.8, 2.0);
}

/// Diameters of the models by their bark, and the length of all their leaves.
std::map<std::string, std::vector<double>> models_of(const Scene& scene, double leaf_m, double most_lean_deg) {
  std::map<std::string, std::vector<double>> models;
  double leans_most_deg = 0.0;
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.surface_class == SurfaceClass::kTrunk) {
      const std::vector<Ring> rings = rings_of(test::pieces_in(mesh).at(0), 10);
      models[scene.materials[mesh.material].name].push_back(2.0 * rings[3].radius_m);
      const Vector3d top = rings.back().center;
      leans_most_deg = std::max(leans_most_deg, std::atan(top.head<2>().norm() / top.z()) * 180.0 / std::numbers::pi);
    }
    if (mesh.surface_class != SurfaceClass::kVegetation) continue;
    for (const Piece& leaf : test::pieces_in(mesh)) {
      const Vector3d along = leaf.size() == 4 ? leaf[2] - leaf[0] : Vector3d(0.5 * (leaf[1] + leaf[2]) - leaf[0]);
      EXPECT_NEAR(along.norm(), leaf_m, 1e-4);
    }
  }
  EXPECT_LE(leans_most_deg, most_lean_deg + 1e-3);
  EXPECT_GT(leans_most_deg, 0.6 * most_lean_deg);
  for (auto& [bark, diameters_m] : models) std::sort(diameters_m.begin(), diameters_m.end());
  return models;
}

void expect_models(const std::map<std::string, std::vector<double>>& models, const std::string& bark,
                   const std::vector<double>& diameters_m) {
  ASSERT_TRUE(models.contains(bark));
  ASSERT_EQ(models.at(bark).size(), diameters_m.size()) << bark;
  for (std::size_t i = 0; i < diameters_m.size(); ++i) EXPECT_NEAR(models.at(bark)[i], diameters_m[i], 1e-4) << bark;
}

TEST(Field, ModelsOfItsTreesSpanTheDiameters) {
  FieldConfig config;
  config.num_trees = 60;
  config.num_bushes = 0;
  config.detail = 0.25;
  const Scene scene = make_field(config, 1);
  const auto models = models_of(scene, 0.7, 3.0);  // 0.35 m at a detail of 1
  expect_models(models, "bark_broadleaf", {0.2, 0.35, 0.5});
  expect_models(models, "bark_pine", {0.25, 0.4});
}

/// Area of the leaves of a model over what its crown would have, by the bounds of its leaves.
double leaf_area_density_of(const Scene& scene) {
  double area = 0.0, volume_m3 = 0.0;
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.surface_class != SurfaceClass::kVegetation || scene.materials[mesh.material].name != "leaves") continue;
    Eigen::AlignedBox3d box;
    for (const Piece& leaf : test::pieces_in(mesh)) box.extend(0.5 * (leaf[0] + leaf[2]));
    area += area_m2(mesh);
    volume_m3 += box.volume() * std::numbers::pi / 6.0 * (1.0 - 0.35 * 0.35);
  }
  return area / volume_m3;
}

TEST(Field, TreesHaveHalfASquareMeterOfLeavesInACubicMeter) {
  FieldConfig config;
  config.num_trees = 30;
  config.num_bushes = 0;
  EXPECT_NEAR(leaf_area_density_of(make_field(config, 1)), 0.5, 0.05);
}

TEST(Campus, ModelsOfItsTreesSpanTheDiametersAndHardlyLean) {
  CampusConfig config;
  config.size_m = {200.0, 200.0};
  config.num_trees = 100;
  config.num_lamps = config.num_cars = 0;
  config.detail = 0.25;
  const auto models = models_of(make_campus(config, 1), 0.6, 2.0);  // 0.3 m at a detail of 1
  expect_models(models, "bark_broadleaf", {0.2, 0.3, 0.4});
  expect_models(models, "bark_spruce", {0.25, 0.4});
  config.detail = 1.0;
  EXPECT_NEAR(leaf_area_density_of(make_campus(config, 1)), 0.55, 0.06);
}

// From half to seven tenths of what they would be in a stand.
TEST(Campus, TreesStayLow) {
  CampusConfig config;
  config.size_m = {300.0, 300.0};
  config.num_trees = 800;
  config.tree_spacing_m = 1.0;
  config.num_lamps = config.num_cars = 0;
  config.detail = 0.05;
  std::vector<double> factors;
  for (const WorldObject& tree : objects_of(make_campus(config, 2), SurfaceClass::kTrunk)) {
    const Species species = tree.kind == "spruce" ? Species::kSpruce : Species::kBroadleaf;
    factors.push_back(attribute(tree, "height_m") / height_by_diameter_m(species, attribute(tree, "dbh_m")));
  }
  expect_uniform(factors, 0.5, 0.7);
}

}  // namespace
}  // namespace swiftlet::sim
