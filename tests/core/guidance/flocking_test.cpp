// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/flocking.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/guidance/flocking/flock_response.hpp"
#include "core/guidance/separation/neighbor_memory.hpp"
#include "tests/core/guidance/guidance_driver.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using testing::CellListMap;
using testing::GuidanceDriver;

TEST(Pacnav, RatesLinesOneAndLoopsZero) {
  EXPECT_NEAR(path_persistence(std::vector<Vector3>{{0, 0, 0}, {1, 0, 0}, {3, 0, 0}}), 1.0, 1e-12);
  EXPECT_NEAR(path_persistence(std::vector<Vector3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}}), 0.0,
              1e-12);
  EXPECT_EQ(path_persistence(std::vector<Vector3>{{1, 1, 1}, {1, 1, 1}}), 0.0);
}

/// Position of a neighbor as a function of time.
using Course = std::function<Vector3(double t_s)>;

Course straight(const Vector3& from_m, const Vector3& v_mps) {
  return [=](double t_s) { return Vector3(from_m + t_s * v_mps); };
}
Course around(const Vector3& center_m, double radius_m, double rate_radps) {
  return [=](double t_s) {
    return Vector3(center_m + radius_m * Vector3(std::cos(rate_radps * t_s), std::sin(rate_radps * t_s), 0.0));
  };
}

PacnavConfig follower() {
  PacnavConfig config;
  config.informed = false;
  config.goal_m = {1000.0, 0.0, 2.0};
  return config;
}

/// Velocity that is wanted after a vehicle that stays at (0, 0, 2) has watched the others for a while.
Vector3 wanted_mps(const PacnavConfig& config, const std::vector<Course>& ways, double watch_s) {
  GuidanceDriver driver("pacnav", config, {0.0, 0.0, 2.0});
  const int ticks = static_cast<int>(std::round(watch_s / driver.dt_s));
  for (int tick = 1; tick <= ticks; ++tick) {
    for (std::size_t i = 0; i < ways.size(); ++i) driver.sees(static_cast<VehicleId>(i) + 1, ways[i](0.1 * tick));
    driver.step();
  }
  return driver.out.goal.position_m - driver.p_m();
}

TEST(PacnavFlight, StaysWithoutALeader) {
  EXPECT_EQ(wanted_mps(follower(), {}, 3.0), Vector3::Zero());
  // A circling neighbor makes no progress; a neighbor seen once has no path yet.
  EXPECT_EQ(wanted_mps(follower(), {around({9.0, 0.0, 2.0}, 2.0, 2.0)}, 8.0), Vector3::Zero());
  EXPECT_EQ(wanted_mps(follower(), {straight({9.0, 0.0, 2.0}, {1.0, 0.0, 0.0})}, 0.4), Vector3::Zero());
}

TEST(PacnavFlight, FollowsStraightPathsToItsDistance) {
  const Vector3 v_mps = wanted_mps(follower(), {straight({9.0, 4.0, 2.0}, {0.0, 0.5, 0.0})}, 4.0);
  EXPECT_NEAR(v_mps.norm(), 1.0, 1e-9) << "as fast as it may";
  EXPECT_NEAR(std::atan2(v_mps.y(), v_mps.x()), std::atan2(6.0, 9.0), 0.05);
  // 4 m away, and 3 m are kept: there is 1 m left, less what it takes in the second ahead.
  PacnavConfig config = follower();
  config.follow_radius_m = 4.0;  // beyond the distance of the repulsion
  EXPECT_LT((wanted_mps(config, {straight({3.1, 0.0, 2.0}, {0.1, 0.0, 0.0})}, 4.0)).norm(), 1e-9) << "near enough";
  config.follow_radius_m = 3.0;
  config.speed_mps = 5.0;
  const Vector3 near_mps = wanted_mps(config, {straight({0.0, 3.5, 2.0}, {0.0, 0.1, 0.0})}, 5.0);
  EXPECT_NEAR(near_mps.y(), 1.0, 0.06) << "4 m less the 3 m that it keeps, within a second";
  EXPECT_NEAR(near_mps.x(), 0.0, 1e-6);
}

TEST(PacnavFlight, FollowsTheMorePersistentPath) {
  const Course wavy = [](double t_s) { return Vector3(0.5 * t_s, -9.0 + 0.8 * std::sin(3.0 * t_s), 2.0); };
  const Course straight_on = straight({0.0, 9.0, 2.0}, {0.5, 0.0, 0.0});
  EXPECT_GT(wanted_mps(follower(), {wavy, straight_on}, 6.0).y(), 0.5);
  EXPECT_GT(wanted_mps(follower(), {straight_on, wavy}, 6.0).y(), 0.5) << "whatever the order";
}

TEST(PacnavFlight, FollowsThePathMostLikeOthers) {
  const Vector3 east(0.5, 0.0, 0.0), west(-0.5, 0.0, 0.0);
  // All are straight. One goes against two that agree; the one that lies apart from the agreeing ones is not followed.
  const std::vector<Course> ways = {straight({0.0, 9.0, 2.0}, west), straight({0.0, -9.0, 2.0}, east),
                                    straight({-1.0, -9.0, 2.0}, east)};
  EXPECT_LT(wanted_mps(follower(), ways, 6.0).y(), -0.5);
}

TEST(PacnavFlight, IgnoresPathsOfLowPersistence) {
  PacnavConfig config = follower();
  const Course there_and_back = [](double t_s) { return Vector3(9.0, std::abs(std::remainder(t_s, 5.0)), 2.0); };
  config.least_persistence = 0.0;
  EXPECT_GT(wanted_mps(config, {there_and_back}, 4.0).norm(), 0.5);
  config.least_persistence = 0.9;
  EXPECT_EQ(wanted_mps(config, {there_and_back}, 4.0), Vector3::Zero());
}

TEST(PacnavFlight, ForgetsPathsOlderThanItsMemory) {
  // The neighbor turns around at 4 s. Within the memory of 8 s it makes no progress; once the turn is forgotten, its
  // path is straight.
  const Course turned = [](double t_s) { return Vector3(9.0, t_s < 4.0 ? t_s : 8.0 - t_s, 2.0); };
  EXPECT_EQ(wanted_mps(follower(), {turned}, 8.0), Vector3::Zero());
  EXPECT_GT(wanted_mps(follower(), {turned}, 13.0).norm(), 0.9);
}

TEST(PacnavFlight, ForgetsLostLeadersAfterTheMemory) {
  GuidanceDriver driver("pacnav", follower(), {0.0, 0.0, 2.0});
  double wanted = 0.0;
  for (int tick = 1; tick <= 140; ++tick) {
    if (tick <= 30) driver.sees(1, {9.0 + 0.1 * tick, 0.0, 2.0});
    wanted = driver.step().goal.position_m.x();
    // Seen last at 3 s, known for a second (timeout_s), remembered for eight more.
    if (tick == 110) {
      EXPECT_GT(wanted, 0.9);
    }
  }
  EXPECT_NEAR(wanted, 0.0, 1e-12);
}

TEST(PacnavFlight, SlowsInformedMembersBeforeTheGoal) {
  PacnavConfig config;
  config.goal_m = {10.0, 0.0, 7.0};
  config.speed_mps = 1.5;
  GuidanceDriver driver("pacnav", config, {0.0, 0.0, 2.0}, 0.4);
  EXPECT_LT((driver.step().goal.position_m - Vector3(1.5, 0.0, 2.0)).norm(), 1e-9) << "at its own height";
  EXPECT_EQ(driver.out.speed_limit_mps, 1.5);
  EXPECT_NEAR(driver.out.goal.yaw_rad, 0.4, 1e-12);
  EXPECT_EQ(driver.out.mission, MissionStatus::kRunning);
  driver.put({9.5, 0.0, 2.0});
  EXPECT_LT((driver.step().goal.position_m - Vector3(10.0, 0.0, 2.0)).norm(), 1e-9);
  EXPECT_EQ(driver.out.mission, MissionStatus::kRunning);
  driver.put({9.9, 0.0, 2.0});
  EXPECT_EQ(driver.step().mission, MissionStatus::kDone);
  driver.put({0.0, 0.0, 2.0});
  EXPECT_EQ(driver.step().mission, MissionStatus::kDone) << "once arrived is arrived";
}

TEST(PacnavFlight, StopsUninformedMembersNearTheGoal) {
  PacnavConfig config = follower();
  config.goal_m = {0.0, 0.0, 2.0};
  config.follow_radius_m = 2.0;
  EXPECT_EQ(GuidanceDriver("pacnav", config, {4.1, 0.0, 2.0}).step().mission, MissionStatus::kRunning);
  EXPECT_EQ(GuidanceDriver("pacnav", config, {3.9, 0.0, 2.0}).step().mission, MissionStatus::kDone);
}

TEST(PacnavFlight, PushesByGainAtHalfDistance) {
  PacnavConfig config = follower();
  config.speed_mps = 5.0;
  const auto push = [&](const Vector3& other_m) {
    return wanted_mps(config, {straight(other_m, Vector3::Zero())}, 0.1);
  };
  EXPECT_LT((push({1.5, 0.0, 2.0}) - Vector3(-1.5, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_LT((push({0.0, -1.5, 9.0}) - Vector3(0.0, 1.5, 0.0)).norm(), 1e-9) << "heights do not count";
  EXPECT_LT((push({0.0, 2.0, 2.0}) - Vector3(0.0, -0.75, 0.0)).norm(), 1e-9);
  EXPECT_EQ(push({3.01, 0.0, 2.0}), Vector3::Zero());
  EXPECT_NEAR(push({0.01, 0.0, 2.0}).norm(), 5.0, 1e-9) << "never faster than it may";
}

TEST(PacnavFlight, AvoidsMappedObstaclesAtItsHeight) {
  PacnavConfig config = follower();
  config.lidar.enabled = true;
  config.speed_mps = 5.0;
  const auto push = [&](const std::vector<Vector3>& cells_m) {
    const CellListMap map(0.2, cells_m);
    GuidanceDriver driver("pacnav", config, {0.0, 0.0, 2.0});
    EXPECT_TRUE(driver.guidance->needs().map);
    driver.map = &map;
    return Vector3(driver.step().goal.position_m - driver.p_m());
  };
  // The cell's nearest face is 1 m away, half of the distance.
  EXPECT_LT((push({{1.1, 0.0, 2.0}}) - Vector3(-1.5, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_LT((push({{1.1, 0.0, 2.0}, {0.0, 1.6, 2.0}}) - Vector3(-1.5, 0.0, 0.0)).norm(), 1e-9) << "the nearest counts";
  EXPECT_LT((push({{0.0, 1.6, 2.0}, {1.1, 0.0, 2.0}}) - Vector3(-1.5, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_EQ(push({{1.1, 0.0, 2.7}}), Vector3::Zero()) << "above";
  EXPECT_EQ(push({{1.1, 0.0, 1.3}}), Vector3::Zero()) << "below";
  EXPECT_LT((push({{1.1, 0.0, 2.5}}) - Vector3(-1.5, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_EQ(push({{2.2, 0.0, 2.0}}), Vector3::Zero());
}

MezeyConfig alone(double goal_weight_radps) {
  MezeyConfig config;
  config.goal_m = {0.0, 100.0, 2.0};
  config.goal_weight_radps = goal_weight_radps;
  return config;
}

TEST(MezeyFlight, ReturnsToCruiseExponentiallyWhenAlone) {
  MezeyConfig config = alone(0.0);
  config.cruise_speed_mps = 2.0;
  GuidanceDriver driver("mezey", config, {0.0, 0.0, 2.0}, 0.3);
  driver.dt_s = 0.001;
  for (int i = 1; i <= 3000; ++i) {
    const Vector3 v_mps = driver.step().goal.position_m - driver.p_m();
    ASSERT_NEAR(v_mps.norm(), 2.0 * (1.0 - std::exp(-0.5 * 0.001 * i)), 2e-3);
    ASSERT_NEAR(std::atan2(v_mps.y(), v_mps.x()), 0.3, 1e-9) << "without a goal it goes straight on";
    ASSERT_NEAR(driver.out.goal.yaw_rad, 0.3, 1e-9);
  }
  EXPECT_EQ(driver.out.mission, MissionStatus::kEndless);
  EXPECT_EQ(driver.out.speed_limit_mps, 4.0);
}

// psi' = w sin(psi_goal - psi): tan(e / 2) of the error e falls as exp(-w t).
TEST(MezeyFlight, TurnsToGoalsInClosedForm) {
  GuidanceDriver driver("mezey", alone(0.8), {0.0, 0.0, 2.0}, -0.5);
  driver.dt_s = 0.001;
  const double before = std::tan(0.5 * (0.5 * M_PI + 0.5));
  for (int i = 1; i <= 3000; ++i) {
    const double error_rad = 0.5 * M_PI - driver.step().goal.yaw_rad;
    ASSERT_NEAR(std::tan(0.5 * error_rad), before * std::exp(-0.8 * 0.001 * i), 2e-3);
  }
  EXPECT_EQ(driver.out.mission, MissionStatus::kRunning);
}

TEST(MezeyFlight, RestsOnceArrived) {
  MezeyConfig config = alone(0.8);
  GuidanceDriver driver("mezey", config, {0.0, 99.0, 2.0});
  for (int i = 0; i < 20; ++i) driver.step();
  EXPECT_EQ(driver.out.mission, MissionStatus::kRunning);
  EXPECT_GT((driver.out.goal.position_m - driver.p_m()).norm(), 0.3);
  driver.put({0.0, 99.6, 2.0});
  EXPECT_EQ(driver.step().mission, MissionStatus::kDone);
  EXPECT_EQ(driver.out.goal.position_m, driver.p_m());
  driver.put({0.0, 90.0, 2.0});
  EXPECT_EQ(driver.step().mission, MissionStatus::kDone) << "once arrived is arrived";
  // Without a weight the goal has no effect and is never reached.
  GuidanceDriver published("mezey", alone(0.0), {0.0, 100.0, 2.0});
  EXPECT_EQ(published.step().mission, MissionStatus::kEndless);
}

TEST(MezeyFlight, BoundsSpeedByTwiceTheCruise) {
  for (const double side : {1.0, -1.0}) {  // a wall of others ahead brakes, one behind drives
    MezeyConfig config = alone(0.0);
    config.alpha0 = 20.0;
    GuidanceDriver driver("mezey", config, {0.0, 0.0, 2.0});
    double v_mps = 0.0;
    for (int i = 0; i < 60; ++i) {
      driver.sees(1, {1.0 * side, 0.0, 2.0});
      v_mps = driver.step().goal.position_m.x();
      ASSERT_GE(v_mps, 0.0);
      ASSERT_LE(v_mps, 2.0);
    }
    EXPECT_NEAR(v_mps, side > 0.0 ? 0.0 : 2.0, 1e-4);
  }
}

TEST(MezeyFlight, AvoidsMappedObstacles) {
  MezeyConfig config = alone(0.0);
  config.lidar.enabled = true;
  const CellListMap map(0.2, {{0.0, 1.1, 2.0}});
  GuidanceDriver driver("mezey", config, {0.0, 0.0, 2.0});
  driver.map = &map;
  EXPECT_NEAR(driver.step().goal.position_m.y(), -1.5, 1e-9);
}

VisualResponse response_to(const MezeyConfig& config, const std::vector<Vector3>& others_m, double heading_rad,
                           std::size_t pixels = 360) {
  std::vector<Neighbor> neighbors;
  neighbors.reserve(others_m.size());
  for (const Vector3& other_m : others_m)
    neighbors.push_back({static_cast<std::int64_t>(neighbors.size()), other_m, Vector3::Zero(), 0});
  std::vector<char> retina(pixels);
  return visual_response(config, {1.0, 2.0, 3.0}, heading_rad, neighbors, retina);
}

TEST(Mezey, RepelsNearAndAttractsFarNeighbors) {
  const auto seen = [](const Vector3& to_m) { return response_to({}, {Vector3(1.0, 2.0, 3.0) + to_m}, 0.0); };
  EXPECT_LT(seen({1.0, 0, 0}).acceleration_mps2, 0.0);   // ahead and near: slow down
  EXPECT_GT(seen({20.0, 0, 0}).acceleration_mps2, 0.0);  // ahead and far: catch up
  EXPECT_LT(seen({0, 1.0, 0}).turn_radps, 0.0);          // near on the left: turn right
  EXPECT_GT(seen({0, 20.0, 0}).turn_radps, 0.0);         // far on the left: turn left
  EXPECT_EQ(response_to({}, {}, 0.0).turn_radps, 0.0);
  EXPECT_EQ(response_to({}, {}, 0.0).acceleration_mps2, 0.0);
}

// A disc of half-angle a at the bearing b: int cos = 2 sin a cos b, int sin = 2 sin a sin b, and the two edges alike.
TEST(MezeyFlight, IntegratesTheDiscAtAnyBearing) {
  MezeyConfig config;
  config.alpha1 = 0.3;
  config.beta1 = 0.2;
  const double a = std::asin(0.5 / 3.0), heading_rad = 0.7;
  for (int i_b = 0; 0.31 * i_b - 3.1 < 3.2; ++i_b) {
    const double b = 0.31 * i_b - 3.1;
    const Vector3 other_m =
        Vector3(1.0, 2.0, 9.0) + 3.0 * Vector3(std::cos(heading_rad + b), std::sin(heading_rad + b), 0.0);
    const VisualResponse response = response_to(config, {other_m}, heading_rad, 36000);
    EXPECT_NEAR(response.acceleration_mps2, config.alpha0 * std::cos(b) * (-2.0 * std::sin(a) + 0.6 * std::cos(a)),
                1e-3)
        << b;
    EXPECT_NEAR(response.turn_radps, config.beta0 * std::sin(b) * (-2.0 * std::sin(a) + 0.4 * std::cos(a)), 1e-3) << b;
  }
}

TEST(MezeyFlight, IgnoresFullyOccludedNeighbors) {
  const MezeyConfig config;
  const VisualResponse one = response_to(config, {{3.0, 3.0, 3.0}}, 0.2, 3600);
  const VisualResponse two = response_to(config, {{3.0, 3.0, 3.0}, {5.0, 4.0, 3.0}}, 0.2, 3600);
  EXPECT_EQ(one.acceleration_mps2, two.acceleration_mps2);
  EXPECT_EQ(one.turn_radps, two.turn_radps);
}

}  // namespace
}  // namespace swiftlet
