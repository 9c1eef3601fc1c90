// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/flight_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "sim/dataset/free_space.hpp"
#include "swiftlet/core/planning/grid_search.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

/// A field of 40 m x 40 m with a wall across it, 8 m high, that has a gap 3 m wide at y = 10.
std::shared_ptr<const StaticScene> field_with_gap() {
  TestScene scene;
  scene.add_wall({-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0}, SurfaceClass::kGround);
  scene.add_box({-0.2F, -20, 0}, {0.2F, 8.5F, 8}, SurfaceClass::kWall);
  scene.add_box({-0.2F, 11.5F, 0}, {0.2F, 20, 8}, SurfaceClass::kWall);
  return std::make_shared<const StaticScene>(scene.scene());
}

constexpr double kRadius_m = 0.8;

FreeSpace space_of(const std::shared_ptr<const StaticScene>& world) {
  return {world, {.radius_m = kRadius_m, .height_min_m = 1.0, .height_max_m = 5.0, .border_m = 2.0, .cell_m = 0.5}};
}

TEST(FreeSpace, IsBetweenTheHeightsAndAwayFromSurfacesAndTheBorder) {
  const auto world = field_with_gap();
  const FreeSpace space = space_of(world);
  EXPECT_TRUE(space.is_free(Vector3(10, 0, 3)));
  EXPECT_FALSE(space.is_free(Vector3(10, 0, 0.9)));
  EXPECT_FALSE(space.is_free(Vector3(10, 0, 5.1)));
  EXPECT_FALSE(space.is_free(Vector3(0.9, 0, 3)));  // 0.7 m from the wall
  EXPECT_TRUE(space.is_free(Vector3(1.1, 0, 3)));
  EXPECT_FALSE(space.is_free(Vector3(18.5, 0, 3)));
  EXPECT_TRUE(space.is_free(Vector3(0, 10, 3)));  // in the gap
  EXPECT_FALSE(is_free_segment(space, Vector3(-5, 0, 3), Vector3(5, 0, 3)));
  EXPECT_TRUE(is_free_segment(space, Vector3(-5, 10, 3), Vector3(5, 10, 3)));
}

TEST(FreeSpace, HasAPathThroughTheGap) {
  const auto world = field_with_gap();
  const FreeSpace space = space_of(world);
  const Vector3 from(-10, -10, 3), to(10, -10, 3);
  const std::vector<Vector3> path = find_path(space, from, to).corners_world_m;
  ASSERT_GE(path.size(), 3U);
  EXPECT_EQ(path.front(), from);
  EXPECT_EQ(path.back(), to);
  double length_m = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    length_m += (path[i] - path[i - 1]).norm();
    EXPECT_TRUE(space.is_free(path[i])) << path[i].transpose();
  }
  // The shortest path bends around the corner of the wall at (0, 8.5 + 0.8): 2 hypot(10, 19.3) = 43.5 m.
  EXPECT_GE(length_m, 43.4);
  EXPECT_LE(length_m, 46.5);
  EXPECT_TRUE(
      std::any_of(path.begin(), path.end(), [](const Vector3& p) { return std::abs(p.x()) < 3.0 && p.y() > 8.0; }));
}

TEST(FreeSpace, HasNoPathThroughAWall) {
  TestScene scene;
  scene.add_wall({-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0}, SurfaceClass::kGround);
  scene.add_box({-0.2F, -20, 0}, {0.2F, 20, 8}, SurfaceClass::kWall);
  const FreeSpace space = space_of(std::make_shared<const StaticScene>(scene.scene()));
  EXPECT_TRUE(find_path(space, {-10, 0, 3}, {10, 0, 3}).corners_world_m.empty());
  EXPECT_TRUE(find_path(space, {-10, 0, 3}, {0, 0, 3}).corners_world_m.empty());
}

TEST(FreeSpace, IndoorsIsWhereWallsStandAllAroundTheDoorLeftOpen) {
  TestScene scene;
  scene.add_wall({-30, -30, 0}, {30, -30, 0}, {30, 30, 0}, {-30, 30, 0}, SurfaceClass::kGround);
  // A hall of 20 m x 20 m without a roof, 6 m high; its door of 2 m looks east.
  scene.add_box({-10.2F, -10.2F, 0}, {10.2F, -10, 6}, SurfaceClass::kWall);
  scene.add_box({-10.2F, 10, 0}, {10.2F, 10.2F, 6}, SurfaceClass::kWall);
  scene.add_box({-10.2F, -10, 0}, {-10, 10, 6}, SurfaceClass::kWall);
  scene.add_box({10, -10, 0}, {10.2F, -1, 6}, SurfaceClass::kWall);
  scene.add_box({10, 1, 0}, {10.2F, 10, 6}, SurfaceClass::kWall);
  const auto world = std::make_shared<const StaticScene>(scene.scene());
  const FreeSpace space(world, {.radius_m = kRadius_m, .height_max_m = 9.0, .indoors = true});
  EXPECT_TRUE(space.is_free(Vector3(0, 0, 3)));
  EXPECT_TRUE(space.is_free(Vector3(8, 0, 3)));  // before the door
  EXPECT_TRUE(space.is_free(Vector3(-9, 9, 3)));
  EXPECT_FALSE(space.is_free(Vector3(0, 0, 7)));  // above the walls
  for (const Vector3& outside : {Vector3(14, 0, 3), Vector3(0, 14, 3), Vector3(-14, -14, 3), Vector3(12, 20, 3)}) {
    EXPECT_FALSE(space.is_free(outside)) << outside.transpose();
    EXPECT_TRUE(find_path(space, {0, 0, 3}, outside).corners_world_m.empty());
    EXPECT_TRUE(space_of(world).is_free(outside));  // where it is not asked for
  }
}

TEST(FlightPlan, TeamsStayClearOfWallsAndOfEachOtherAndComeNear) {
  const auto world = field_with_gap();
  FlightConfig config;
  config.height_max_m = 5.0;
  config.leg_max_m = 20.0;
  config.partner_max_m = 15.0;
  const std::vector<double> radii_m = {0.4, 0.3, 0.3};
  constexpr double kDuration_s = 15.0;
  double nearest_of_all_m = 1e9;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto paths = plan_flight(config, world, radii_m, kDuration_s, seed, 0);
    ASSERT_TRUE(paths.has_value());
    ASSERT_EQ(paths->size(), 3U);
    for (double t_s = 0.0; t_s <= kDuration_s; t_s += 0.02) {
      for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 p = (*paths)[i].spline().at(t_s).p_m;
        const auto surface = world->nearest(p, 10.0);
        const double clearance_m = (surface ? surface->distance_m : 10.0) - radii_m[i];
        EXPECT_GE(clearance_m, 0.5 * config.margin_m - 0.05) << "vehicle " << i << " at " << t_s;
        for (std::size_t j = 0; j < i; ++j) {
          const double distance_m = (p - (*paths)[j].spline().at(t_s).p_m).norm();
          EXPECT_GE(distance_m, config.separation_m - 1e-3);
          nearest_of_all_m = std::min(nearest_of_all_m, distance_m);
        }
      }
    }
    const auto again = plan_flight(config, world, radii_m, kDuration_s, seed, 0);
    ASSERT_TRUE(again.has_value());
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ((*again)[i].control_points_m, (*paths)[i].control_points_m);
    const auto other = plan_flight(config, world, radii_m, kDuration_s, seed, 1);
    ASSERT_TRUE(other.has_value());
    EXPECT_NE((*other)[0].control_points_m, (*paths)[0].control_points_m);
  }
  EXPECT_LT(nearest_of_all_m, 6.0);
}

}  // namespace
}  // namespace swiftlet::sim
