// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_detour.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/guidance/separation/neighbor_memory.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "tests/core/guidance/guidance_driver.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using testing::CellListMap;
using testing::GuidanceDriver;

constexpr double kAhead_m = 3.5;

RblDetourConfig quick() {
  RblDetourConfig config;
  config.patience_s = 1.0;
  config.climb_m = 0.1;
  config.planning_latency_s = 0.3;
  config.retry_after_s = 0.5;
  config.retries = 1;
  config.planner.clearance_m = 0.6;
  config.planner.max_expansions = 5000;
  return config;
}

/// A point that flies straight towards the next goal, and stops where it would come too near to something.
struct Flight {
  explicit Flight(const RblDetourConfig& config) : detour(config, kAhead_m) {
    now.goal_local_m = {8, 0, 1};
    now.p_local_m = {0, 0, 1};
    now.z_min_m = 0.0;
    now.z_max_m = 2.0;
    now.encumbrance_m = 0.5;
    now.map = &world;
  }
  void tick() {
    now.neighbors = neighbors;
    next_m = detour.next_goal_local_m(now);
    now.now += from_seconds(0.1);
    if (detour.on_path()) farthest_ahead_m = std::max(farthest_ahead_m, (next_m - now.p_local_m).norm());
    const Vector3 way_m = next_m - now.p_local_m;
    const Vector3 step_m = way_m.norm() > 0.1 ? Vector3(0.1 * way_m.normalized()) : way_m;
    const Vector3 p_m = now.p_local_m + step_m;
    const double before_m = world.distance_m(now.p_local_m, 5.0), after_m = world.distance_m(p_m, 5.0);
    if (!held && (after_m >= 0.05 || after_m > before_m)) now.p_local_m = p_m;
    least_m = std::min(least_m, world.distance_m(now.p_local_m, 5.0));
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(10.0 * seconds) && left_m() > 0.1; ++i) tick();
  }
  double left_m() const { return (now.goal_local_m - now.p_local_m).norm(); }

  CellListMap world{0.25};
  std::vector<Neighbor> neighbors;
  RblDetour detour;
  RblDetour::Situation now;
  Vector3 next_m = Vector3::Zero();
  double least_m = 5.0, farthest_ahead_m = 0.0;
  bool held = false;
};

void add_u(CellListMap& world) {
  world.occupy_box({4.0, -2.5, 0.0}, {4.25, 2.5, 2.0});
  world.occupy_box({1.0, -2.75, 0.0}, {4.25, -2.5, 2.0});
  world.occupy_box({1.0, 2.5, 0.0}, {4.25, 2.75, 2.0});
}

TEST(RblDetour, FliesDirectlyWhileApproachingTheGoal) {
  Flight flight(quick());
  flight.world.occupy_box({4.0, 3.0, 0.0}, {4.25, 6.0, 2.0});
  while (flight.left_m() > 0.1) {
    flight.tick();
    ASSERT_EQ(flight.next_m, flight.now.goal_local_m);
  }
  EXPECT_EQ(flight.detour.num_plans(), 0U);
  EXPECT_STREQ(flight.detour.note(), "");
}

TEST(RblDetour, BacksOutOfUAndArrives) {
  Flight flight(quick());
  add_u(flight.world);
  flight.run(60.0);
  EXPECT_LT(flight.left_m(), 0.1);
  EXPECT_GE(flight.least_m, 0.04);
  EXPECT_LT(flight.farthest_ahead_m, kAhead_m + 0.3) << "the next goal is never farther along the path than it may";
  RblDetourConfig off = quick();
  off.enabled = false;
  Flight caught(off);
  add_u(caught.world);
  caught.run(60.0);
  EXPECT_GT(caught.left_m(), 4.0);
}

TEST(RblDetour, WaitsForPatienceAndPlannerLatency) {
  Flight flight(quick());
  flight.held = true;
  flight.world.occupy_box({2.0, -2.0, 0.0}, {2.25, 2.0, 2.0});
  while (flight.next_m == Vector3::Zero() || flight.next_m == flight.now.goal_local_m) flight.tick();
  const double waited_s = to_seconds(flight.now.now) - 0.1;
  EXPECT_NEAR(waited_s, 1.0 + 0.3, 0.11);
  EXPECT_TRUE(flight.detour.on_path());
  EXPECT_NE(std::string(flight.detour.note()).find("around an obstacle"), std::string::npos);
}

TEST(RblDetour, FliesStraightWhereClearWhenHeld) {
  Flight flight(quick());
  flight.world.occupy_box({2.0, -2.0, 0.0}, {2.25, 2.0, 2.0});
  while (!flight.detour.on_path()) flight.tick();
  for (int i = 0; i < 5; ++i) flight.tick();
  EXPECT_FALSE(flight.detour.straight_local_m()) << "no straight flight while the vehicle is not held up";
  flight.held = true;
  for (int i = 0; i < 30; ++i) flight.tick();
  ASSERT_TRUE(flight.detour.straight_local_m());
  const Vector3 from_m = flight.now.p_local_m, to_m = *flight.detour.straight_local_m();
  EXPECT_GT((to_m - from_m).norm(), 0.5);
  // Clearance of the encumbrance, to half a cell. A start that is already nearer to an obstacle gets no nearer.
  const double least_m = std::min(flight.world.distance_m(from_m, 5.0), 0.5 - 0.125);
  for (int i = 0; i <= 20; ++i) {
    EXPECT_GE(flight.world.distance_m(from_m + i / 20.0 * (to_m - from_m), 5.0), least_m - 1e-9);
  }
  EXPECT_GE(flight.world.distance_m(to_m, 5.0), 0.5 - 0.125);
  // The vehicle's own rules lead it past a stationary neighbor; the planes between braking paths lead it past a flying
  // one.
  Neighbor neighbor;
  neighbor.position_local_m = from_m + 0.5 * (to_m - from_m) + Vector3(0.0, 0.0, 1.0);
  flight.neighbors.assign(1, neighbor);
  flight.tick();
  EXPECT_FALSE(flight.detour.straight_local_m());
  flight.neighbors[0].velocity_local_mps = {0.0, 0.0, 1.0};
  flight.tick();
  EXPECT_TRUE(flight.detour.straight_local_m());
  flight.neighbors.clear();
  // No detour is reported once an obstacle blocks it.
  const Vector3 way = (to_m - from_m).normalized();
  flight.world.occupy_box(from_m + 0.6 * way - Vector3(0.3, 0.3, 1.0), from_m + 0.6 * way + Vector3(0.3, 0.3, 1.0));
  flight.tick();
  EXPECT_FALSE(flight.detour.straight_local_m());
}

TEST(RblDetour, ReplansWhenAnObstacleAppearsAhead) {
  Flight flight(quick());
  flight.world.occupy_box({3.0, -1.5, 0.0}, {3.25, 4.0, 2.0});
  for (int i = 0; i < 300 && !flight.detour.on_path(); ++i) flight.tick();
  ASSERT_TRUE(flight.detour.on_path());
  EXPECT_LT(flight.next_m.y(), 0.0);
  const std::uint64_t plans = flight.detour.num_plans();
  flight.world.occupy_box({3.0, -6.0, 0.0}, {3.25, -1.5, 2.0});
  flight.run(60.0);
  EXPECT_LT(flight.left_m(), 0.1);
  EXPECT_GT(flight.detour.num_plans(), plans);
}

TEST(RblDetour, KeepsTheHeightOfPlanarFlight) {
  RblDetourConfig config = quick();
  config.climb_m = 5.0;
  Flight over(config);
  over.now.z_max_m = 6.0;
  over.world.occupy_box({3.0, -5.0, 0.0}, {3.25, 5.0, 2.0});
  over.held = true;
  for (int i = 0; i < 20; ++i) over.tick();
  const auto highest = [](const Flight& flight) {
    double z_m = 0.0;
    for (const Vector3& corner_m : flight.detour.corners_local_m()) z_m = std::max(z_m, corner_m.z());
    return z_m;
  };
  EXPECT_GT(highest(over), 2.1) << "over the wall";
  Flight planar(config);
  planar.now = over.now;
  planar.now.p_local_m = {0, 0, 1};
  planar.now.planar = true;
  planar.now.map = &over.world;
  planar.world = over.world;
  planar.held = true;
  for (int i = 0; i < 20; ++i) planar.tick();
  ASSERT_TRUE(planar.detour.on_path());
  EXPECT_NEAR(highest(planar), 1.0, 0.3);
}

TEST(RblDetour, IsSameFarFromOrigin) {
  RblDetourConfig config = quick();
  config.climb_m = 5.0;
  const auto corners_at = [&](double x_m) {
    Flight flight(config);
    const Vector3 shift_m(x_m, 0.0, 0.0);
    flight.now.z_max_m = 6.0;
    flight.now.p_local_m = shift_m + Vector3(0, 0, 1);
    flight.now.goal_local_m = shift_m + Vector3(6, 0, 4);  // near: the path leads up to its height
    flight.world.occupy_box(shift_m + Vector3(3.0, -2.0, 0.0), shift_m + Vector3(3.25, 2.0, 5.0));
    flight.held = true;
    for (int i = 0; i < 20; ++i) flight.tick();
    std::vector<Vector3> corners_m;
    for (const Vector3& corner_m : flight.detour.corners_local_m()) corners_m.push_back(corner_m - shift_m);
    return corners_m;
  };
  const std::vector<Vector3> here_m = corners_at(0.0), there_m = corners_at(40.0);
  ASSERT_GE(here_m.size(), 3U);
  ASSERT_EQ(there_m.size(), here_m.size());
  for (std::size_t i = 0; i < here_m.size(); ++i) EXPECT_LT((there_m[i] - here_m[i]).norm(), 1e-9);
  EXPECT_NEAR(here_m.back().z(), 4.0, 0.3);
}

TEST(RblDetour, AvoidsAStandingVehicleWherePossible) {
  Neighbor other;
  other.position_local_m = {4.0, 0.0, 1.0};
  Flight flight(quick());
  flight.held = true;
  flight.neighbors = {other};
  for (int i = 0; i < 20; ++i) flight.tick();
  ASSERT_GT(flight.detour.corners_local_m().size(), 2U);
  flight.neighbors.front().velocity_local_mps = {0.0, 1.0, 0.0};  // the neighbor moves on
  Flight open(quick());
  open.held = true;
  open.neighbors = flight.neighbors;
  for (int i = 0; i < 20; ++i) open.tick();
  EXPECT_EQ(open.detour.corners_local_m().size(), 2U);
  Flight only(quick());
  only.held = true;
  only.neighbors = {other};
  only.world.occupy_box({3.0, 1.0, 0.0}, {5.0, 9.0, 2.0});
  only.world.occupy_box({3.0, -9.0, 0.0}, {5.0, -1.0, 2.0});
  only.world.occupy_box({-9.0, 9.0, 0.0}, {10.0, 9.25, 2.0});
  only.world.occupy_box({-9.0, -9.25, 0.0}, {10.0, -9.0, 2.0});
  only.world.occupy_box({-9.25, -9.25, 0.0}, {-9.0, 9.25, 2.0});
  only.world.occupy_box({10.0, -9.25, 0.0}, {10.25, 9.25, 2.0});
  for (int i = 0; i < 20; ++i) only.tick();
  EXPECT_EQ(only.detour.corners_local_m().size(), 2U);
}

TEST(RblDetour, FallsBackToNarrowFlyablePassages) {
  RblDetourConfig config = quick();
  config.planner.clearance_m = 1.2;
  Flight flight(config);
  flight.held = true;
  flight.world.occupy_box({-2.0, 1.0, 0.0}, {10.0, 1.25, 2.0});
  flight.world.occupy_box({-2.0, -1.25, 0.0}, {10.0, -1.0, 2.0});
  for (int i = 0; i < 20; ++i) flight.tick();
  EXPECT_TRUE(flight.detour.on_path()) << flight.detour.note();
}

TEST(RblDetour, FailsWithoutPathAndRecoversLater) {
  Flight flight(quick());
  flight.held = true;
  CellListMap closed(0.25);
  closed.occupy_box({-1.5, -1.5, 0.0}, {1.5, -1.25, 2.0});
  closed.occupy_box({-1.5, 1.25, 0.0}, {1.5, 1.5, 2.0});
  closed.occupy_box({-1.5, -1.5, 0.0}, {-1.25, 1.5, 2.0});
  closed.occupy_box({1.25, -1.5, 0.0}, {1.5, 1.5, 2.0});
  flight.now.map = &closed;
  while (flight.detour.num_plans() < 2) flight.tick();
  EXPECT_FALSE(flight.detour.has_failed()) << "the detour fails only after several searches";
  for (int i = 0; i < 50; ++i) flight.tick();
  EXPECT_TRUE(flight.detour.has_failed());
  EXPECT_FALSE(flight.detour.on_path());
  EXPECT_NE(std::string(flight.detour.note()), "");
  EXPECT_EQ(flight.next_m, flight.now.goal_local_m);
  flight.now.map = &flight.world;
  for (int i = 0; i < 30; ++i) flight.tick();
  EXPECT_FALSE(flight.detour.has_failed());
  EXPECT_TRUE(flight.detour.on_path());
}

TEST(RblDetour, ViewsBlockedGoalFromBesideIt) {
  RblDetourConfig config = quick();
  config.climb_m = 2.0;
  config.retries = 3;
  Flight flight(config);
  CellListMap ghost(0.25), clear(0.25);
  ghost.occupy_box({7.75, -0.25, 0.75}, {8.25, 0.25, 1.25});
  flight.now.map = &ghost;
  flight.now.z_max_m = 5.0;
  flight.now.p_local_m = {8.0, 0.2, 2.5};  // above it, and does not see it
  flight.now.sees_goal_from_m = 4.0;
  flight.held = true;
  for (int i = 0; i < 30 && !flight.detour.on_path(); ++i) flight.tick();
  ASSERT_TRUE(flight.detour.on_path());
  const Vector3 end_m = flight.detour.corners_local_m().back();
  EXPECT_NEAR((end_m - flight.now.goal_local_m).head<2>().norm(), 4.0, 0.3) << "from where it sees it";
  EXPECT_NEAR(end_m.z(), 2.5, 0.3) << "at its own height";
  EXPECT_TRUE(flight.detour.is_looking());
  EXPECT_NE(std::string(flight.detour.note()).find("viewpoint"), std::string::npos);
  // The vehicle has arrived and sees the free goal.
  flight.now.p_local_m = end_m;
  flight.now.map = &clear;
  for (int i = 0; i < 3; ++i) flight.tick();
  EXPECT_EQ(flight.next_m, flight.now.goal_local_m);
  flight.held = false;
  flight.run(20.0);
  EXPECT_LT(flight.left_m(), 0.1);
  // A detour that stays blocked fails after the retries.
  Flight never(config);
  never.now = flight.now;
  never.now.map = &ghost;
  never.now.p_local_m = {8.0, 0.2, 2.5};
  for (int i = 0; i < 600 && !never.detour.has_failed(); ++i) never.tick();
  EXPECT_TRUE(never.detour.has_failed());
}

TEST(RblDetour, CountsAbandonedSearchesWithoutFailing) {
  RblDetourConfig config = quick();
  config.planner.max_expansions = 3;
  Flight flight(config);
  flight.held = true;
  add_u(flight.world);
  for (int i = 0; i < 100; ++i) flight.tick();
  EXPECT_GT(flight.detour.num_given_up(), 1U);
  EXPECT_EQ(flight.detour.num_given_up(), flight.detour.num_plans());
  EXPECT_FALSE(flight.detour.has_failed());
}

RblConfig by_lidar(double z_max_m) {
  RblConfig config;
  config.variant = RblConfig::Variant::k3dClipped;
  config.goal_m = {8, 0, 1};
  config.z_min_m = 0.5;
  config.z_max_m = z_max_m;
  config.cells.step_m = 0.35;
  config.neighbors.source = NeighborSourceConfig::Source::kNone;
  config.separation.enabled = false;
  config.lidar.enabled = true;
  config.detour = quick();
  return config;
}

/// A vehicle that reaches its goal of the tick before, as far as its speed allows.
double left_by_rbl_m(const RblConfig& config, GuidanceDriver& driver, const CellListMap& world, double* least_m) {
  for (int i = 0; i < 600 && driver.out.mission != MissionStatus::kDone; ++i) {
    driver.step();
    const Vector3 way_m = driver.out.goal.position_m - driver.p_m();
    const Vector3 step_m = way_m.norm() > 0.15 ? Vector3(0.15 * way_m.normalized()) : way_m;
    driver.put(driver.p_m() + step_m, driver.out.goal.yaw_rad);
    *least_m = std::min(*least_m, world.distance_m(driver.p_m(), 5.0));
  }
  return (config.goal_m - driver.p_m()).norm();
}

double left_by_rbl_m(const RblConfig& config, const Vector3& start_m, const CellListMap& world, double* least_m) {
  GuidanceDriver driver("rbl", config, start_m);
  driver.map = &world;
  return left_by_rbl_m(config, driver, world, least_m);
}

TEST(RblDetour, FreesAnRblVehicleFromU) {
  CellListMap world(0.25);
  add_u(world);
  double least_m = 5.0;
  RblConfig config = by_lidar(1.5);
  EXPECT_LT(left_by_rbl_m(config, {0, 0, 1}, world, &least_m), 0.3);
  config.detour.enabled = false;
  EXPECT_GT(left_by_rbl_m(config, {0, 0, 1}, world, &least_m), 3.5);
  EXPECT_GT(least_m, 0.4);
}

/// Walls all around, and a lid; open below 2 m.
CellListMap shaft() {
  CellListMap world(0.25);
  world.occupy_box({1.25, -1.5, 2.0}, {1.5, 1.5, 5.0});
  world.occupy_box({-1.5, -1.5, 2.0}, {-1.25, 1.5, 5.0});
  world.occupy_box({-1.5, 1.25, 2.0}, {1.5, 1.5, 5.0});
  world.occupy_box({-1.5, -1.5, 2.0}, {1.5, -1.25, 5.0});
  world.occupy_box({-1.5, -1.5, 5.0}, {1.5, 1.5, 5.25});
  return world;
}

TEST(RblDetour, DescendsShaftItCameUpThrough) {
  CellListMap world = shaft();
  RblConfig config = by_lidar(5.0);
  config.detour.climb_m = 3.0;
  GuidanceDriver driver("rbl", config, {0, 0, 1});
  driver.map = &world;
  for (int i = 0; i <= 30; ++i) {  // the vehicle is led up there
    driver.put({0, 0, 1.0 + 0.1 * i});
    driver.step();
  }
  double least_m = 5.0;
  EXPECT_LT(left_by_rbl_m(config, driver, world, &least_m), 0.3);
  EXPECT_GT(least_m, 0.4);
}

TEST(RblDetour, RefusesBlindDescentIntoUnseenSpace) {
  CellListMap world = shaft();
  RblConfig config = by_lidar(5.0);
  config.detour.climb_m = 3.0;
  GuidanceDriver driver("rbl", config, {0, 0, 4});
  driver.map = &world;
  double least_m = 5.0;
  EXPECT_GT(left_by_rbl_m(config, driver, world, &least_m), 5.0);
  EXPECT_GT(driver.p_m().z(), 3.0);
  EXPECT_GT(least_m, 0.4);
}

TEST(RblDetour, FliesStraightWithRoomForBoth) {
  Flight flight(quick());
  flight.held = true;
  flight.world.occupy_box({6.0, -2.0, 0.0}, {6.25, 2.0, 2.0});
  for (int i = 0; i < 60; ++i) flight.tick();
  ASSERT_TRUE(flight.detour.straight_local_m().has_value());
  const Vector3 way_m = *flight.detour.straight_local_m() - flight.now.p_local_m;
  const Vector3 beside = Vector3(-way_m.y(), way_m.x(), 0.0).normalized();
  for (const double aside_m : {0.9, 1.1}) {
    Neighbor other;
    other.position_local_m = flight.now.p_local_m + 0.5 * way_m + aside_m * beside;
    flight.neighbors = {other};
    flight.tick();
    EXPECT_EQ(flight.detour.straight_local_m().has_value(), aside_m > 1.0) << aside_m;
  }
}

}  // namespace
}  // namespace swiftlet
