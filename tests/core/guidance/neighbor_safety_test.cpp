// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/separation/neighbor_safety.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "swiftlet/core/guidance/flocking.hpp"
#include "swiftlet/core/guidance/navigate.hpp"
#include "swiftlet/core/guidance/orca.hpp"
#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/guidance/waypoints.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "tests/core/guidance/guidance_driver.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

/// An intruder on a straight course past a vehicle that follows its goals. `look` adds the measurements of each tick.
/// Returns the least distance, with heights scaled.
template <class Look>
double least_distance_m(testing::GuidanceDriver& driver, Vector3 other_m, const Vector3& v_mps, double end_x_m,
                        double height_scale, const Look& look) {
  double least_m = std::numeric_limits<double>::infinity();
  for (int i = 0; other_m.x() < end_x_m; ++i) {
    other_m += driver.dt_s * v_mps;
    look(i, other_m);
    driver.step();
    driver.follow();
    const Vector3 apart_m = other_m - driver.p_m();
    least_m = std::min(least_m, Vector3(apart_m.x(), apart_m.y(), height_scale * apart_m.z()).norm());
  }
  return least_m;
}

// A vehicle backing straight off would be caught.
TEST(NeighborSafety, LetsFastStraightIntrudersPass) {
  RblConfig config;
  config.goal_m = {0.0, 0.0, 5.0};
  for (const double speed_mps : {1.0, 2.0, 3.0, 4.0}) {
    for (const double side_m : {-0.6, -0.2, 0.0, 0.2, 0.6}) {
      for (const double above_m : {0.0, 0.4}) {
        testing::GuidanceDriver driver("rbl", config, config.goal_m);
        const double least_m =
            least_distance_m(driver, {-18.0, side_m, 5.0 + above_m}, {speed_mps, 0.0, 0.0}, 5.0,
                             config.separation.distance_m(config.cells.encumbrance_m) / config.separation.vertical_m,
                             [&](int, const Vector3& other_m) { driver.sees(2, other_m); });
        EXPECT_GT(least_m, 2.0 * config.cells.encumbrance_m) << speed_mps << " m/s, " << side_m << ", " << above_m;
      }
    }
  }
}

// An uncertain position shrinks the cell but does not delay the evasion.
TEST(NeighborSafety, EvadesPoorlyObservedIntruder) {
  RblConfig config;
  config.variant = RblConfig::Variant::k2d;
  config.goal_m = {0.0, 0.0, 5.0};
  for (const double side_m : {-0.4, -0.1, 0.1, 0.4}) {
    testing::GuidanceDriver driver("rbl", config, config.goal_m);
    // Once a second, until samples are lost, with the range to 0.1 m.
    const auto look = [&](int i, const Vector3& other_m) {
      const Vector3 to_m = other_m - driver.p_m();
      if (i % 10 != 0 || other_m.x() >= -7.0) return;
      driver.sees(2, other_m, 0.01 * to_m * to_m.transpose() + 1e-4 * Matrix3::Identity());
    };
    const double least_m = least_distance_m(driver, {-14.0, side_m, 5.0}, {4.0, 0.0, 0.0}, 5.0, 1.0, look);
    EXPECT_GT(least_m, 2.0 * config.cells.encumbrance_m) << side_m;
  }
}

/// An intruder of 3 m/s approaches from any side beside the vehicle's goal; with LiDAR the vehicle also avoids
/// obstacles of the map.
struct ByLidar {
  RblConfig config;
  testing::CellListMap world{0.25};
  double from_deg = 0.0;
  double least_m = std::numeric_limits<double>::infinity(), nearest_wall_m = 5.0;

  void fly() {
    testing::GuidanceDriver driver("rbl", config, config.goal_m);
    driver.map = &world;
    const Vector3 ahead(std::cos(from_deg * kRadPerDeg), std::sin(from_deg * kRadPerDeg), 0.0);
    Vector3 other_m = config.goal_m + 18.0 * ahead + Vector3(0.05, 0.1, 0.0);
    for (int i = 0; i < 80; ++i) {
      other_m -= driver.dt_s * 3.0 * ahead;
      driver.sees(2, other_m);
      driver.step();
      driver.follow(driver.out.goal.yaw_rad);
      least_m = std::min(least_m, (other_m - driver.p_m()).norm());
      nearest_wall_m = std::min(nearest_wall_m, world.distance_m(driver.p_m(), 5.0));
    }
  }
};

// Turning towards the flight direction and waiting for a view of it would take too long to evade. The evasion is
// urgent: three times as far as its centroid, but not into a wall.
TEST(NeighborSafety, EvadesByLidarAwayFromWalls) {
  for (const bool walled : {false, true}) {
    for (const double from_deg : {0.0, 60.0, 90.0, 120.0, 180.0, 250.0}) {
      if (walled && (from_deg == 0.0 || from_deg == 250.0)) continue;  // through a wall
      ByLidar flight;
      flight.config.goal_m = {0.0, 0.0, 5.0};
      flight.config.lidar.enabled = true;
      if (walled) flight.world.occupy_box({-6.0, -1.75, 2.0}, {6.0, -1.5, 8.0});
      if (walled) flight.world.occupy_box({1.5, -1.75, 2.0}, {1.75, 4.0, 8.0});
      flight.from_deg = from_deg;
      flight.fly();
      EXPECT_GT(flight.nearest_wall_m, 0.45) << from_deg;
      EXPECT_GT(flight.least_m, walled ? 0.81 : 2.0 * flight.config.cells.encumbrance_m) << from_deg;
    }
  }
}

// A goal straight below never comes into view. The vehicle descends slowly through space that it saw before.
TEST(NeighborSafety, DescendsByLidarThroughObservedSpace) {
  for (const bool looked : {true, false}) {
    RblConfig config;
    config.goal_m = {8.0, 0.0, 4.0};
    config.lidar.enabled = true;
    config.detour.enabled = false;
    testing::GuidanceDriver driver("rbl", config, {8.0, 0.0, 5.5});
    const testing::CellListMap open(0.25);
    driver.map = &open;
    for (int i = 0; looked && i < 80; ++i) {
      driver.put({0.1 * i, 0.0, 5.5});
      driver.step();
    }
    driver.put({8.0, 0.0, 5.5});
    for (int i = 0; i < 200; ++i) {
      driver.step();
      driver.follow(driver.out.goal.yaw_rad);
    }
    EXPECT_EQ((driver.p_m() - config.goal_m).norm() < 0.2, looked) << driver.p_m().transpose();
  }
}

/// Largest height of a vehicle without room beside it, in a plane, when another vehicle flies through its place from
/// below.
double highest_m(const RblConfig& config, const OccupancyView* map, bool flies_in) {
  testing::GuidanceDriver driver("rbl", config, config.goal_m);
  driver.map = map;
  // The vehicle may have come from there, looking ahead.
  for (int i = 0; flies_in && i < 60; ++i) {
    driver.put(config.goal_m - Vector3(0.1 * (60 - i), 0.0, 0.0));
    driver.step();
  }
  driver.put(config.goal_m);
  Vector3 other_m = config.goal_m + Vector3(-18.0, 0.0, -0.2);
  double highest_m = 0.0;
  while (other_m.x() < 18.0) {
    other_m.x() += driver.dt_s * 3.0;
    driver.sees(2, other_m);
    driver.sees(3, config.goal_m + Vector3(0.0, 1.15, 0.0));
    driver.sees(4, config.goal_m - Vector3(0.0, 1.15, 0.0));
    driver.step();
    driver.follow();
    highest_m = std::max(highest_m, driver.p_m().z());
  }
  return highest_m;
}

TEST(NeighborSafety, LimitsClimbWhenLeavingThePlane) {
  RblConfig config;
  config.variant = RblConfig::Variant::k2d;
  config.goal_m = {0.0, 0.0, 5.0};
  EXPECT_GT(highest_m(config, nullptr, false), 5.6);
  config.z_max_m = 5.3;
  config.ground_m = 4.4;  // below there is no room at all
  EXPECT_LE(highest_m(config, nullptr, false), 5.31);
  config.z_max_m = 4.0;  // below the wanted goal
  EXPECT_LE(highest_m(config, nullptr, false), 5.01);
}

TEST(NeighborSafety, LeavesPlaneByLidarWhereObserved) {
  RblConfig config;
  config.variant = RblConfig::Variant::k2d;
  config.goal_m = {0.0, 0.0, 5.0};
  config.ground_m = 4.4;
  config.lidar.enabled = true;
  testing::CellListMap open(0.25), roofed(0.25);
  roofed.occupy_box({-4.0, -4.0, 6.0}, {4.0, 4.0, 6.25});
  EXPECT_GT(highest_m(config, &open, true), 5.4);
  EXPECT_LE(highest_m(config, &roofed, true), 5.51);
  EXPECT_LE(highest_m(config, &open, false), 5.2) << "the vehicle has not observed the space above its goal";
}

// Without room to evade sideways, the vehicle leaves its plane.
TEST(NeighborSafety, ReturnsToPlaneAfterVerticalEvasion) {
  RblConfig config;
  config.variant = RblConfig::Variant::k2d;
  config.goal_m = {0.0, 0.0, 5.0};
  for (const double above_m : {0.0, 0.8}) {  // the vehicle evades a neighbor above it downwards
    testing::GuidanceDriver driver("rbl", config, config.goal_m);
    Vector3 other_m(-18.0, 0.0, 5.0 + above_m);
    double least_m = std::numeric_limits<double>::infinity(), farthest_m = 0.0, beside_m = 0.0;
    while (other_m.x() < 18.0) {
      other_m.x() += driver.dt_s * 3.0;
      driver.sees(2, other_m);
      driver.sees(3, {0.0, 1.15, 5.0});
      driver.sees(4, {0.0, -1.15, 5.0});
      driver.step();
      driver.follow();
      least_m = std::min(least_m, (other_m - driver.p_m()).norm());
      const double rise_m = driver.p_m().z() - 5.0;
      if (std::abs(rise_m) > std::abs(farthest_m)) farthest_m = rise_m;
      beside_m = std::max(beside_m, std::abs(driver.p_m().y()));
    }
    EXPECT_GT(least_m, 2.0 * config.cells.encumbrance_m) << above_m;
    EXPECT_LT(beside_m, 0.3) << above_m;
    EXPECT_GT(above_m > 0.0 ? -farthest_m : farthest_m, 0.3) << above_m;
    EXPECT_NEAR(driver.p_m().z(), 5.0, 0.1) << above_m;
  }
}

// The position of the neighbor is unknown by now. A cell that ended at the vehicle itself would drive it away
// indefinitely.
TEST(NeighborSafety, StaysAtGoalAfterLosingNeighbor) {
  RblConfig config;
  config.goal_m = {0.0, 0.0, 5.0};
  testing::GuidanceDriver driver("rbl", config, config.goal_m);
  NeighborView view;
  view.range_max_m = 10.0;
  view.cones.push_back({Vector3::UnitX(), -1.0});
  driver.setup.neighbor_views = {view};
  driver.make("rbl", config);
  Vector3 other_m(4.0, 0.0, 5.0);
  double farthest_m = 0.0;
  for (int i = 0; i < 900; ++i) {
    if (other_m.x() < 60.0) other_m.x() += 1.0 * driver.dt_s;
    if ((other_m - driver.p_m()).norm() < view.range_max_m) driver.sees(2, other_m);
    driver.step();
    driver.follow(driver.out.goal.yaw_rad);
    farthest_m = std::max(farthest_m, (driver.p_m() - config.goal_m).norm());
  }
  EXPECT_LT(farthest_m, 0.5);
}

/// Two vehicles fly to places on the far side of each other and see each other at `rate_hz`. Returns the least
/// distance.
template <class Config>
double least_distance_head_on_m(const char* type, const Config& of_first, const Config& of_second, double rate_hz) {
  const Vector3 start_m[2] = {{-10.0, 0.0, 5.0}, {10.0, 0.3, 5.0}};
  testing::GuidanceDriver first(type, of_first, start_m[0]), second(type, of_second, start_m[1]);
  testing::CellListMap open(0.25);
  first.map = second.map = &open;
  double least_m = std::numeric_limits<double>::infinity();
  const int period = static_cast<int>(std::lround(1.0 / (rate_hz * first.dt_s)));
  for (int i = 0; i < 300; ++i) {
    if (i % period == 0) {
      first.sees(2, second.p_m());
      second.sees(1, first.p_m());
    }
    for (testing::GuidanceDriver* driver : {&first, &second}) {
      driver->step();
      if (driver->out.goal_is_feasible) {
        driver->follow();
      } else {
        driver->approach();
      }
    }
    least_m = std::min(least_m, (first.p_m() - second.p_m()).norm());
  }
  return least_m;
}

template <class Config, class Aim>
void expect_apart_head_on(const char* type, const Aim& aim, bool collides_without) {
  for (const double rate_hz : {10.0, 1.0}) {
    for (const bool separated : {true, false}) {
      Config first, second;
      aim(first, Vector3(10.0, 0.0, 5.0));
      aim(second, Vector3(-10.0, 0.3, 5.0));
      first.separation.enabled = second.separation.enabled = separated;
      const double least_m = least_distance_head_on_m(type, first, second, rate_hz);
      if (separated) EXPECT_GT(least_m, 1.0) << type << ", " << rate_hz << " Hz";
      if (!separated && collides_without) EXPECT_LT(least_m, 0.8) << type;
    }
  }
}

TEST(KeptApart, KeepsDistanceUnderAnyGuidance) {
  const auto to_waypoint = [](WaypointsConfig& c, const Vector3& p_m) { c.waypoints_m = {p_m}; };
  expect_apart_head_on<WaypointsConfig>("waypoints", to_waypoint, true);
  const auto to_goals = [](NavigateConfig& c, const Vector3& p_m) { c.goals_m = {p_m}; };
  expect_apart_head_on<NavigateConfig>("navigate", to_goals, true);
  const auto to_goal = [](auto& c, const Vector3& p_m) { c.goal_m = p_m; };
  expect_apart_head_on<OrcaConfig>("orca", to_goal, false);
  expect_apart_head_on<PacnavConfig>("pacnav", to_goal, false);
}

TEST(KeptApart, ReachesGoalsAsTheGuidanceAlone) {
  for (const bool separated : {false, true}) {
    WaypointsConfig config;
    config.waypoints_m = {{5.0, 0.0, 5.0}, {5.0, 5.0, 5.0}};
    config.separation.enabled = separated;
    testing::GuidanceDriver driver("waypoints", config, {0.0, 0.0, 5.0});
    for (int i = 0; i < 300 && driver.out.mission != MissionStatus::kDone; ++i) {
      driver.sees(2, {0.0, 20.0, 5.0});
      driver.step();
      if (separated) {
        driver.follow();
      } else {
        driver.approach();
      }
    }
    EXPECT_EQ(driver.out.mission, MissionStatus::kDone) << separated;
    EXPECT_LT((driver.p_m() - config.waypoints_m.back()).norm(), 0.6) << separated;
  }
}

TEST(KeptApart, EvadesIntruderWhileHoldingPosition) {
  WaypointsConfig config;
  config.waypoints_m = {{0.0, 0.0, 5.0}};
  config.separation.enabled = true;
  for (const double speed_mps : {1.0, 2.0, 3.0}) {
    testing::GuidanceDriver driver("waypoints", config, config.waypoints_m.front());
    const double least_m = least_distance_m(driver, {-18.0, 0.2, 5.0}, {speed_mps, 0.0, 0.0}, 5.0, 1.1 / 1.5,
                                            [&](int, const Vector3& other_m) { driver.sees(2, other_m); });
    EXPECT_GT(least_m, 1.0) << speed_mps;
  }
}

}  // namespace
}  // namespace swiftlet
