// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_obstacles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/guidance/flocking/rbl_planner.hpp"
#include "swiftlet/core/guidance/rbl_agent.hpp"
#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

constexpr double kEdge = 0.2, kEncumbrance = 0.5, kEta = 0.9;

Vector3 voxel_at(const Vector3& p) { return ((p.array() / kEdge).floor() + 0.5).matrix() * kEdge; }

/// A trunk of voxels.
void add_trunk(std::vector<Vector3>& voxels, double x, double y, double radius, double z_low, double z_high) {
  for (double z = z_low; z < z_high; z += kEdge) {
    for (int i = 0; i < 40; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / 40;
      voxels.push_back(voxel_at({x + radius * std::cos(angle), y + radius * std::sin(angle), z + 0.01}));
    }
  }
  std::sort(voxels.begin(), voxels.end(), [](const Vector3& a, const Vector3& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  });
  voxels.erase(std::unique(voxels.begin(), voxels.end()), voxels.end());
}

double distance_to_voxel(const Vector3& q, const Vector3& center) {
  return (q - nearest_in_voxel(q, center, kEdge)).norm();
}

TEST(NearestInVoxel, ClampsToFacesEdgesAndCorners) {
  const Vector3 center(1, 2, 3);
  EXPECT_EQ(nearest_in_voxel({0, 2.05, 3}, center, 0.2), Vector3(0.9, 2.05, 3));
  EXPECT_EQ(nearest_in_voxel({0, 0, 0}, center, 0.2), Vector3(0.9, 1.9, 2.9));
  EXPECT_EQ(nearest_in_voxel({1.02, 1.95, 3.05}, center, 0.2), Vector3(1.02, 1.95, 3.05));
}

TEST(ObstacleCutter, KeepsItsDistanceFromEveryVoxel) {
  std::vector<Vector3> voxels;
  const Vector3 p(0.3, -0.2, 2.0);
  add_trunk(voxels, 2.0, 0.5, 0.5, 0.0, 6.0);
  add_trunk(voxels, 0.2, 2.2, 0.3, 0.0, 6.0);
  add_trunk(voxels, -1.6, -1.5, 0.4, 0.0, 6.0);
  RblCell cell(3.5, 0.2, false);
  ObstacleCutter cutter;
  std::vector<HalfSpace> cuts;
  cutter.cut(cell, p, voxels, kEdge, kEncumbrance, kEta, cuts);
  ASSERT_GT(cell.num_partitioned(), 100);
  EXPECT_LT(cuts.size(), 120U);
  for (int i = 0; i < cell.num_samples(); i += 7) {
    if (!cell.contains(i)) continue;
    for (const Vector3& voxel : voxels) ASSERT_GE(distance_to_voxel(p + cell.point(i), voxel), kEncumbrance - 1e-3);
  }
  EXPECT_TRUE(cell.contains(cell.nearest_partitioned(Vector3::Zero())));
  EXPECT_LT(cell.point(cell.nearest_partitioned(Vector3::Zero())).norm(), 1e-6);  // the agent is inside
}

TEST(ObstacleCutter, PushesAgentOutOfAVoxel) {
  RblCell cell(3.5, 0.2, false);
  ObstacleCutter cutter;
  std::vector<HalfSpace> cuts;
  const std::vector<Vector3> voxels = {{0.4, 0.1, 0.1}};
  cutter.cut(cell, Vector3(0.1, 0.1, 0.1), voxels, kEdge, kEncumbrance, kEta, cuts);
  EXPECT_LT(cell.partitioned_centroid({20, 0, 0}, 0.5).x(), 0.0);
}

TEST(FieldOfView, SpansWedgeFromGammaToAlpha) {
  const auto planes = field_of_view(Matrix3::Identity(), 20.0, 59.0);
  const auto sees = [&](double elevation_deg, double azimuth_deg) {
    const double e = elevation_deg * std::numbers::pi / 180.0, a = azimuth_deg * std::numbers::pi / 180.0;
    const Vector3 q(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
    return planes[0].normal_local.dot(q) <= planes[0].offset_m && planes[1].normal_local.dot(q) <= planes[1].offset_m;
  };
  EXPECT_TRUE(sees(-19.5, 0));
  EXPECT_FALSE(sees(-20.5, 0));
  EXPECT_TRUE(sees(38.5, 0));
  EXPECT_FALSE(sees(39.5, 0));
  EXPECT_FALSE(sees(0, 180));
  EXPECT_FALSE(sees(10, 150));
  // The field of view rotates with the vehicle.
  const Matrix3 left = Eigen::AngleAxisd(std::numbers::pi / 2.0, Vector3::UnitZ()).toRotationMatrix();
  const auto turned = field_of_view(left, 20.0, 59.0);
  EXPECT_LE(turned[0].normal_local.dot(Vector3(0, 1, 0)), 0.0);
  EXPECT_GT(turned[0].normal_local.dot(Vector3(0, -1, 0)), 0.0);
}

TEST(FieldOfView, PlanesPassThroughTheMountedLidar) {
  const Vector3 lidar_body_m(0.1, 0.0, 0.3);
  const Matrix3 left = Eigen::AngleAxisd(std::numbers::pi / 2.0, Vector3::UnitZ()).toRotationMatrix();
  for (const HalfSpace& plane : field_of_view(left, 20.0, 59.0, lidar_body_m)) {
    EXPECT_NEAR(plane.normal_local.dot(left * lidar_body_m), plane.offset_m, 1e-12);
    EXPECT_GT(std::abs(plane.offset_m), 0.1);
  }
}

/// The document's failure (sec. 3.4.3): leaves around the vehicle are mapped once and are gone in the next sweep.
double progress_after_leaves(double p_miss) {
  OccupancyMapConfig config;
  config.edge_m = kEdge;
  config.p_miss = p_miss;
  const auto map = make_occupancy_map(config);
  const Vector3 p(0.1, 0.1, 2.1);
  const auto shell = [&](double radius, bool hit) {
    std::vector<OccupancyMap::Ray> rays;
    for (int i = -45; i <= 45; ++i) {
      for (int j = 0; j < 120; ++j) {
        const double e = i * std::numbers::pi / 180.0 * 2.0, a = j * std::numbers::pi / 60.0;
        const Vector3 end = p + radius * Vector3(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
        rays.push_back({p.cast<float>(), end.cast<float>(), hit});
      }
    }
    return rays;
  };
  map->insert(shell(0.9, true), 1);                                                     // leaves
  for (int i = 2; i <= 12; ++i) map->insert(shell(8.0, false), i * kNsPerSecond / 10);  // nothing there any more
  std::vector<Vector3> voxels;
  map->occupied_within(p, 4.5, kEver, voxels);
  RblCell cell(3.5, 0.2, false);
  ObstacleCutter cutter;
  std::vector<HalfSpace> cuts;
  cutter.cut(cell, p, voxels, kEdge, kEncumbrance, kEta, cuts);
  return cell.is_empty() ? 0.0 : cell.partitioned_centroid({20, 0, 0}, 0.5).x();
}

TEST(Ghosts, LockInOnlyWithConservativeMap) {
  EXPECT_LT(progress_after_leaves(0.5), 0.4);
  EXPECT_GT(progress_after_leaves(0.4), 2.0);
}

TEST(ObstacleCutter, WithoutVoxelsCutsNothing) {
  ObstacleCutter cutter;
  RblCell cell(2.0, 0.3, false);
  const int all = cell.num_partitioned();
  std::vector<HalfSpace> cuts;
  cutter.cut(cell, {0, 0, 0}, {}, kEdge, kEncumbrance, kEta, cuts);
  EXPECT_EQ(cell.num_partitioned(), all);
  EXPECT_TRUE(cuts.empty());
  cutter.cut(cell, {0, 0, 0}, std::vector<Vector3>{{50.1, 0.1, 0.1}}, kEdge, kEncumbrance, kEta, cuts);
  EXPECT_EQ(cell.num_partitioned(), all) << "out of reach";
}

TEST(RblAgent, StepsLikeItsParts) {
  const RblCellConfig config;
  RblRules rules;
  rules.beta_desired_m = 0.6;
  RblAgent agent(config, rules, false);
  RblPlanner planner(config, rules, false);
  ObstacleCutter cutter;
  const std::vector<Vector3> neighbors_m = {{1.4, 0.3, 3.0}, {-0.5, 1.6, 3.2}};
  const std::vector<Vector3> voxels_m = {{2.1, -0.5, 3.1}, {2.1, -0.7, 3.1}};
  Vector3 p_m(0.0, 0.0, 3.0);
  for (int i = 0; i < 20; ++i) {
    const RblAgent::Step step = agent.step({.p_local_m = p_m,
                                            .neighbors_local_m = neighbors_m,
                                            .goal_local_m = {9.0, 1.0, 3.0},
                                            .z_min_m = 1.0,
                                            .z_max_m = 5.0,
                                            .voxels_local_m = voxels_m,
                                            .voxel_edge_m = kEdge},
                                           0.1);
    planner.partition(p_m, neighbors_m, 1.0, 5.0);
    cutter.cut(planner.cell(), p_m, voxels_m, kEdge, config.encumbrance_m, config.eta, planner.cuts());
    const RblPlanner::Step expected = planner.update({9.0, 1.0, 3.0}, 0.1);
    ASSERT_EQ(step.centroid_local_m, expected.centroid_local_m) << i;
    ASSERT_EQ(step.sensing_local_m, expected.sensing_local_m) << i;
    ASSERT_EQ(step.destination_local_m, expected.destination_local_m) << i;
    ASSERT_EQ(step.empty_cell, expected.empty_cell) << i;
    ASSERT_EQ(step.beta_m, planner.state().beta_m) << i;
    ASSERT_EQ(step.theta_rad, planner.state().theta_rad) << i;
    ASSERT_EQ(step.phi_rad, planner.state().phi_rad) << i;
    p_m += 0.2 * (step.centroid_local_m - p_m);
  }
}

}  // namespace
}  // namespace swiftlet
