// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/placement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "sim/world/building.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/world/keep_clear_config.hpp"
#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

TEST(DistanceToSegment, IsToItsNearestPoint) {
  const Eigen::Vector2d a(1, 1), b(5, 1);
  EXPECT_DOUBLE_EQ(distance_to_segment_m({3, 4}, a, b), 3.0);
  EXPECT_DOUBLE_EQ(distance_to_segment_m({-2, 5}, a, b), 5.0);
  EXPECT_DOUBLE_EQ(distance_to_segment_m({8, -3}, a, b), 5.0);
  EXPECT_DOUBLE_EQ(distance_to_segment_m({4, 5}, a, a), 5.0) << "a point";
}

TEST(KeepClear, MeasuresDistanceToNearestZoneEdge) {
  KeepClearConfig zones;
  EXPECT_EQ(zones.distance_m({0, 0}), std::numeric_limits<double>::infinity());
  zones.clearings = {{{10, 0}, 3.0}, {{-10, 0}, 1.0}};
  EXPECT_DOUBLE_EQ(zones.distance_m({10, 5}), 2.0);
  EXPECT_DOUBLE_EQ(zones.distance_m({10, 1}), -2.0);
  EXPECT_DOUBLE_EQ(zones.distance_m({-10, 5}), 4.0);
  zones.trails = {{{{0, 20, 7}, {10, 20, 9}, {10, 40, 1}}, 4.0}};
  EXPECT_DOUBLE_EQ(zones.distance_m({5, 17}), 1.0);
  EXPECT_DOUBLE_EQ(zones.distance_m({11, 30}), -1.0);
  EXPECT_DOUBLE_EQ(zones.distance_m({0, 30}), 8.0);
  zones.trails = {{{{0, 100, 0}}, 2.0}};
  EXPECT_DOUBLE_EQ(zones.distance_m({0, 104}), 3.0) << "a trail of one point is a disc";
}

TEST(Spacing, TakesPointsExactlyWhenFarEnough) {
  const Random random(4, "test.spacing");
  for (const double spacing_m : {0.7, 2.5}) {
    Spacing spacing(spacing_m);
    std::vector<Eigen::Vector2d> taken;
    for (std::uint32_t i = 0; i < 2000; ++i) {
      const double x_m = random.uniform(-12.0, 12.0, i, 0), y_m = random.uniform(-12.0, 12.0, i, 1);
      const Eigen::Vector2d p_m(x_m, y_m);
      bool free = true;
      for (const Eigen::Vector2d& other_m : taken) free = free && (other_m - p_m).norm() >= spacing_m;
      ASSERT_EQ(spacing.try_add(p_m), free) << i;
      if (free) taken.push_back(p_m);
    }
    EXPECT_GT(taken.size(), 30U);
  }
}

TEST(Spacing, OfZeroTakesAll) {
  Spacing spacing(0.0);
  EXPECT_TRUE(spacing.try_add({1, 1}));
  EXPECT_TRUE(spacing.try_add({1, 1}));
}

TEST(Wall, HasVolumeOfWholeLessOpenings) {
  Mesh whole, pierced;
  const Eigen::Vector2d start_m(1, 2), end_m(7, 10);  // 10 m
  add_wall(whole, start_m, end_m, 3.0, 0.2, {}, 0.5);
  EXPECT_NEAR(signed_volume_m3(whole), 10.0 * 3.0 * 0.2, 1e-4);
  EXPECT_NEAR(bounds_m(whole).min().z(), 0.5, 1e-6);
  EXPECT_NEAR(bounds_m(whole).max().z(), 3.5, 1e-6);
  EXPECT_NEAR(bounds_m(whole).min().x(), 1.0 - 0.1 * 0.8, 1e-5);  // half the thickness, across
  EXPECT_NEAR(bounds_m(whole).max().y(), 10.0 + 0.1 * 0.6, 1e-5);

  const Opening openings[] = {{2.0, 1.0, 0.0, 2.0}, {6.0, 2.0, 1.0, 2.5}, {9.5, 1.0, 0.0, 9.0}};
  add_wall(pierced, start_m, end_m, 3.0, 0.2, openings);
  EXPECT_NEAR(signed_volume_m3(pierced), (30.0 - 1.0 * 2.0 - 2.0 * 1.5 - 1.0 * 3.0) * 0.2, 1e-4);
}

/// Winding number of the mesh around a point: nonzero inside.
double winding_at(const Mesh& mesh, const Eigen::Vector3d& p_m) {
  double sum = 0.0;
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices_mesh_m[triangle[0]].cast<double>() - p_m,
                          b = mesh.vertices_mesh_m[triangle[1]].cast<double>() - p_m,
                          c = mesh.vertices_mesh_m[triangle[2]].cast<double>() - p_m;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4.0 * std::acos(-1.0));
}

TEST(Wall, IsSolidButForItsOpenings) {
  Mesh mesh;
  const Opening openings[] = {{2.0, 1.0, 0.0, 2.0}, {6.0, 2.0, 1.0, 2.5}};
  add_wall(mesh, {0, 0}, {10, 0}, 3.0, 0.2, openings);
  const auto solid = [&](double x_m, double z_m) { return winding_at(mesh, {x_m, 0.01, z_m}) > 0.5; };
  for (const auto& [x_m, z_m] : {std::pair{2.0, 1.0}, {1.55, 1.9}, {6.0, 1.5}, {6.95, 2.4}, {5.05, 1.1}})
    EXPECT_FALSE(solid(x_m, z_m)) << x_m << ' ' << z_m;
  for (const auto& [x_m, z_m] : {std::pair{1.4, 1.0},
                                 {2.6, 1.0},
                                 {2.0, 2.1},
                                 {6.0, 0.9},
                                 {6.0, 2.6},
                                 {4.9, 1.5},
                                 {7.1, 1.5},
                                 {0.1, 0.1},
                                 {9.9, 2.9}})
    EXPECT_TRUE(solid(x_m, z_m)) << x_m << ' ' << z_m;
}

}  // namespace
}  // namespace swiftlet::sim
