// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/surroundings.hpp"

#include <gtest/gtest.h>

#include "core/interception/pursuit_laws.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

const MotionLimits kInterceptor{8.0, 4.0, 60.0, 4.0, 2.0, 60.0, 2.0, 2.0};

/// No obstacles, only a wide fence.
Surroundings open_air() {
  Surroundings around;
  GeofenceConfig config;
  config.min_m = {-100.0, -100.0, 0.0};
  config.max_m = {100.0, 100.0, 100.0};
  around.fence = Geofence(config, FrameChange());
  return around;
}

Reference flying(const Vector3& p_local_m, const Vector3& v_local_mps) {
  Reference state;
  state.position_m = p_local_m;
  state.velocity_mps = v_local_mps;
  return state;
}

TEST(Geofence, MeasuresNearestInsideAndFarthestOutside) {
  GeofenceConfig config;
  config.min_m = {-10.0, -20.0, 2.0};
  config.max_m = {30.0, 40.0, 50.0};
  const Geofence fence(config, FrameChange());
  EXPECT_DOUBLE_EQ(fence.excess_m({29.0, 0.0, 20.0}), -1.0);
  EXPECT_DOUBLE_EQ(fence.excess_m({0.0, -18.0, 20.0}), -2.0);
  EXPECT_DOUBLE_EQ(fence.excess_m({0.0, 0.0, 1.5}), 0.5);
  EXPECT_DOUBLE_EQ(fence.excess_m({33.0, 41.0, 20.0}), 3.0);
  EXPECT_EQ(fence.inside({33.0, -21.0, 60.0}), Vector3(30.0, -20.0, 50.0));
  EXPECT_EQ(fence.inside({5.0, 6.0, 7.0}), Vector3(5.0, 6.0, 7.0));
}

TEST(Geofence, StaysFixedWhenLocalFrameMoves) {
  StateEstimate estimate;
  estimate.T_world_local = level_alignment(0.7, {4.0, -3.0, 1.0}, Vector3::Zero());
  GeofenceConfig config;
  config.min_m = {-10.0, -20.0, 2.0};
  config.max_m = {30.0, 40.0, 50.0};
  const Geofence in_world(config, FrameChange()), in_local(config, FrameChange::to_local(estimate));
  for (const Vector3& p_world_m : {Vector3(0, 0, 10), Vector3(35, 3, 10), Vector3(12, -25, 60), Vector3(-11, 41, 1)}) {
    const Vector3 p_local_m = FrameChange::to_local(estimate).point(p_world_m);
    EXPECT_NEAR(in_local.excess_m(p_local_m), in_world.excess_m(p_world_m), 1e-9);
    EXPECT_LT((FrameChange::to_world(estimate).point(in_local.inside(p_local_m)) - in_world.inside(p_world_m)).norm(),
              1e-9);
  }
}

TEST(Surroundings, KeepsTheClearanceFromOccupiedCells) {
  Surroundings around = open_air();
  const testing::CellListMap map(0.2, {Vector3(10.0, 0.0, 20.0)});
  around.map = &map;
  around.clearance_m = 1.5;
  EXPECT_NEAR(around.intrusion_m({8.9, 0.0, 20.0}, 0.0), 0.5, 1e-12);   // 1 m from its side
  EXPECT_NEAR(around.intrusion_m({7.9, 0.0, 20.0}, 0.0), -0.5, 1e-12);  // 2 m
  EXPECT_NEAR(around.intrusion_m({0, 0, 0.25}, 0.0), -0.25, 1e-12) << "the ground is near";
  EXPECT_NEAR(around.intrusion_m({0, 0, -2.0}, 0.0), 2.0, 1e-12);
}

TEST(Surroundings, AvoidsPredictedPositionOfBystander) {
  Surroundings around = open_air();
  around.moving_obstacles.push_back({{0, 0, 50}, {4, 0, 0}, 3.0, false});
  EXPECT_NEAR(around.intrusion_m({8, 2, 50}, 2.0), 1.0, 1e-12);
  EXPECT_LT(around.intrusion_m({8, 2, 50}, 0.0), 0.0);
  EXPECT_NEAR(around.intrusion_m({0, 0, 53.5}, 0.0), -0.5, 1e-12);
}

/// The half-spaces that hold a place at this time.
std::vector<Wall> walls_at(const Surroundings& around, const Vector3& p_local_m, double ahead_s = 0.0) {
  ChaseAim aim;
  around.walls(p_local_m, ahead_s, aim);
  return {aim.walls.begin(), aim.walls.begin() + aim.num_walls};
}

TEST(Surroundings, BoundsNearObstaclesByPlanes) {
  Surroundings around = open_air();
  EXPECT_TRUE(walls_at(around, {0, 0, 50}).empty());
  const std::vector<Wall> ground = walls_at(around, {0, 0, 2});
  ASSERT_EQ(ground.size(), 1U);
  EXPECT_NEAR(ground[0].excess_m({5, 5, 1.0}), -1.0, 1e-12);

  around.moving_obstacles.push_back({{0, 0, 50}, {2, 0, 0}, 2.0, false});
  EXPECT_TRUE(walls_at(around, {9, 0, 50}).empty());
  const std::vector<Wall> side = walls_at(around, {4, 0, 50});
  ASSERT_EQ(side.size(), 1U);
  // The plane touches the sphere at its nearest point; space beyond is outside.
  EXPECT_NEAR(side[0].excess_m({2.0, 7.0, 55.0}), 0.0, 1e-12);
  EXPECT_NEAR(side[0].excess_m({4.0, 0.0, 50.0}), -2.0, 1e-12);
  EXPECT_NEAR(walls_at(around, {4, 0, 50}, 0.5).at(0).excess_m({4, 0, 50}), -1.0, 1e-12)
      << "the obstacle is 1 m nearer after 0.5 s";
}

TEST(Surroundings, PutsTheNearestOccupiedCellFirst) {
  Surroundings around = open_air();
  const testing::CellListMap map(0.2, {Vector3(10, 0, 2), Vector3(6, 0, 2), Vector3(0, 8, 2)});
  around.map = &map;
  around.clearance_m = 1.0;
  const std::vector<Wall> walls = walls_at(around, {3, 0, 2});
  ASSERT_EQ(walls.size(), 2U);  // and the ground
  const double keep_m = 1.0 + 0.1 * std::sqrt(3.0);
  EXPECT_NEAR(walls[0].excess_m({3, 0, 2}), keep_m - 3.0, 2e-3);
  EXPECT_NEAR(walls[0].excess_m({6, 0, 2}), keep_m, 2e-3);
  EXPECT_NEAR(walls[1].excess_m({3, 0, 2}), -2.0, 1e-12);
}

TEST(Surroundings, StaysAboveAnOverflownTarget) {
  Surroundings around = open_air();
  around.moving_obstacles.push_back({{0, 0, 50}, {0, 0, 0}, 2.0, true});
  // A floor on top of it.
  const std::vector<Wall> over = walls_at(around, {1.5, 0, 52});
  ASSERT_EQ(over.size(), 1U);
  EXPECT_NEAR(over[0].excess_m({9, 9, 52}), 0.0, 1e-12);
  EXPECT_NEAR(over[0].excess_m({0, 0, 53}), -1.0, 1e-12);
  EXPECT_LT(walls_at(around, {2.4, 0, 50}).at(0).normal.x(), -0.5) << "its side";
  around.moving_obstacles[0].flown_over = false;
  EXPECT_LT(walls_at(around, {1.5, 0, 51}).at(0).normal.x(), -0.5);
}

TEST(Surroundings, CapsWallsAndSkipsCoincidentBystanders) {
  Surroundings around = open_air();
  around.moving_obstacles.push_back({{0, 0, 50}, {0, 0, 0}, 2.0, false});
  EXPECT_TRUE(walls_at(around, {0, 0, 50}).empty()) << "no direction leads away";
  for (int i = 0; i < 9; ++i) around.moving_obstacles.push_back({{3.0, 0.1 * i, 50}, {0, 0, 0}, 2.0, false});
  EXPECT_EQ(walls_at(around, {0, 0, 50}).size(), static_cast<std::size_t>(ChaseAim::kMaxWalls));
}

TEST(Braking, OpposesTheVelocityWithinTheLimits) {
  const Surroundings around = open_air();
  const Vector3 slow = braking_mps2(flying({0, 0, 50}, {0.2, 0, 0}), around, 0.0, kInterceptor);
  const Vector3 full = braking_mps2(flying({0, 0, 50}, {6, 0, 0}), around, 0.0, kInterceptor);
  EXPECT_LT(slow.x(), 0.0);
  EXPECT_GT(slow.x(), full.x());
  EXPECT_LT((full - Vector3(-kInterceptor.horizontal_acceleration_mps2, 0, 0)).norm(), 1e-9);
}

TEST(Braking, EvadesConflictsWithinItsTimeHorizon) {
  const auto evasion_mps2 = [](const Vector3& bystander_m, double ahead_s = 0.0) {
    Surroundings around = open_air();
    around.moving_obstacles.push_back({bystander_m, {0, 4, 0}, 2.0, false});
    return braking_mps2(flying({0, 0, 50}, {0, 0, 0}), around, ahead_s, kInterceptor);
  };
  const Vector3 away_mps2(kInterceptor.horizontal_acceleration_mps2, 0, 0);
  // A vehicle flies straight at this one's right side and will pass 1 m behind it: forward is away from it.
  EXPECT_LT((evasion_mps2({-1, -4, 50}) - away_mps2).norm(), 1e-6);
  EXPECT_TRUE(evasion_mps2({-1, -9, 50}).isZero()) << "the conflict lies beyond the time horizon";
  EXPECT_GT(evasion_mps2({-1, -9, 50}, 1.0).x(), 1.0) << "a second from now";
  EXPECT_TRUE(evasion_mps2({-4, -4, 50}).isZero()) << "the other vehicle passes at a sufficient distance";
}

TEST(Braking, ClimbsBeforeAHeadOnCollision) {
  Surroundings around = open_air();
  around.moving_obstacles.push_back({{4, 0, 50}, {-4, 0, 0}, 1.0, false});
  const Vector3 a_mps2 = braking_mps2(flying({0, 0, 50}, {0, 0, 0}), around, 0.0, kInterceptor);
  EXPECT_NEAR(a_mps2.z(), kInterceptor.vertical_acceleration_mps2, 1e-9);
  EXPECT_NEAR(a_mps2.x(), 0.0, 1e-9);
}

bool stops(const Surroundings& around, const Vector3& p_local_m, const Vector3& v_local_mps, double allowed_m = 0.0) {
  ReferenceGovernor governor(kInterceptor);
  governor.reset(flying(p_local_m, v_local_mps));
  return can_stop(governor, around, 0.0, allowed_m);
}

TEST(Braking, StopsBeforeTheFenceIfPossible) {
  const Surroundings around = open_air();
  // v^2 / 2a, and the distance during the build-up of the acceleration.
  const double v = 6.0, a = kInterceptor.horizontal_acceleration_mps2;
  const double way_m = v * v / (2.0 * a) + 0.5 * v * a / kInterceptor.horizontal_jerk_mps3;
  EXPECT_TRUE(stops(around, {100.0 - way_m - 0.3, 0, 50}, {v, 0, 0}));
  EXPECT_FALSE(stops(around, {100.0 - way_m + 0.3, 0, 50}, {v, 0, 0}));
  EXPECT_TRUE(stops(around, {100.0 - way_m + 0.3, 0, 50}, {v, 0, 0}, 0.6)) << "what was there already may stay";
  EXPECT_FALSE(stops(around, {100.5, 0, 50}, {-v, 0, 0})) << "the vehicle is outside of the fence already";
}

TEST(Braking, RefusesStopsCrossedByABystander) {
  Surroundings around = open_air();
  EXPECT_TRUE(stops(around, {0, 0, 50}, {6, 0, 0}));
  // From the side, too fast to brake or evade, towards the vehicle's position in half a second.
  around.moving_obstacles.push_back({{3, 20, 50}, {0, -40, 0}, 2.5, false});
  EXPECT_FALSE(stops(around, {0, 0, 50}, {6, 0, 0}));
}

}  // namespace
}  // namespace swiftlet
