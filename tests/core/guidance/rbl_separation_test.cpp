// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_separation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "swiftlet/core/guidance/rbl.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/random.hpp"
#include "tests/core/guidance/guidance_driver.hpp"
#include "tests/core/planning/cell_list_map.hpp"
#include "tests/support/draws.hpp"

namespace swiftlet {
namespace {

using testing::Draws;

constexpr double kApart_m = 1.1;

Braking drawn_braking(Draws& draws, double place_m, double path_m) {
  const Vector3 p_m = draws.vector(place_m);
  return {p_m, p_m + draws.vector(path_m)};
}

double least_between(const Braking& a, const Braking& b) {
  double least_m = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= 200; ++i) {
    const Vector3 p_m = a.p_local_m + i / 200.0 * (a.stop_local_m - a.p_local_m);
    const Vector3 leg_m = b.stop_local_m - b.p_local_m;
    const double along = std::clamp((p_m - b.p_local_m).dot(leg_m) / std::max(1e-12, leg_m.squaredNorm()), 0.0, 1.0);
    least_m = std::min(least_m, (b.p_local_m + along * leg_m - p_m).norm());
  }
  return least_m;
}

/// Distance of a point beyond the plane of `self`.
double beyond_m(const HalfSpace& cut, const Braking& self, const Vector3& q_m) {
  return cut.normal_local.dot(q_m - self.p_local_m) - cut.offset_m;
}

TEST(RblSeparation, PredictsBrakingDistanceFromTheLimits) {
  const MotionLimits limits;  // 2 m/s^2 level, 1 m/s^2 vertical
  const Braking level = braking_of({1.0, 2.0, 3.0}, {4.0, 0.0, 0.0}, 0.3, limits);
  EXPECT_NEAR((level.stop_local_m - Vector3(1.0 + 0.3 * 4.0 + 16.0 / 4.0, 2.0, 3.0)).norm(), 0.0, 1e-12);
  const Braking down = braking_of({0.0, 0.0, 9.0}, {0.0, 0.0, -2.0}, 0.3, limits);
  EXPECT_NEAR((down.stop_local_m - Vector3(0.0, 0.0, 9.0 - 0.6 - 2.0)).norm(), 0.0, 1e-12);
  const Braking at_rest = braking_of({5.0, 5.0, 5.0}, Vector3::Zero(), 0.3, limits);
  EXPECT_EQ(at_rest.stop_local_m, at_rest.p_local_m);
}

TEST(RblSeparation, KeepsDistanceAndHalfTheRoom) {
  Draws draws("rbl-separation", 7);
  int num_with_room = 0;
  for (int i = 0; i < 2000; ++i) {
    const Braking a = drawn_braking(draws, 5.0, 2.0), b = drawn_braking(draws, 5.0, 2.0);
    const HalfSpace of_a = braking_cut(a, b, kApart_m, kApart_m, 0.0);
    const HalfSpace of_b = braking_cut(b, a, kApart_m, kApart_m, 0.0);
    const double least_m = least_between(a, b);
    if (least_m < 0.01) continue;  // the braking paths cross
    ASSERT_NEAR((of_a.normal_local + of_b.normal_local).norm(), 0.0, 1e-9);
    const double kept_m = beyond_m(of_b, b, a.p_local_m + of_a.offset_m * of_a.normal_local);
    ASSERT_GE(kept_m, kApart_m - 1e-9) << i;
    if (least_m < kApart_m + 0.02) continue;
    ++num_with_room;
    ASSERT_NEAR(kept_m, kApart_m, 1e-9) << i;
    // Half the room before the braking path remains, by brute force.
    const double farthest_m = std::max(beyond_m(of_a, a, a.p_local_m), beyond_m(of_a, a, a.stop_local_m));
    ASSERT_NEAR(farthest_m, -0.5 * (least_m - kApart_m), 0.01) << i;
  }
  EXPECT_GT(num_with_room, 1000);
}

TEST(RblSeparation, ReservesRoomForUncertaintyWithoutRetreating) {
  const Braking self{Vector3::Zero(), {0.5, 0.0, 0.0}};
  const Braking other{{4.0, 0.0, 0.0}, {4.0, 0.0, 0.0}};
  const auto offset_m = [&](double unsure_m) {
    return braking_cut(self, other, kApart_m, kApart_m, unsure_m).offset_m;
  };
  EXPECT_NEAR(offset_m(0.0), 0.5 + 0.5 * (3.5 - kApart_m), 1e-12);
  EXPECT_NEAR(offset_m(1.0), offset_m(0.0) - 0.5, 1e-12);
  EXPECT_NEAR(offset_m(100.0), 0.5, 1e-12);  // the present braking path stays allowed
  const Braking too_near{{1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
  EXPECT_LT(braking_cut(self, too_near, kApart_m, kApart_m, 0.0).offset_m, 0.5);
}

TEST(RblSeparation, KeepsMoreRoomAboveAndBelow) {
  const Braking self{Vector3::Zero(), Vector3::Zero()};
  const auto offset_m = [&](const Vector3& other_m) {
    return braking_cut(self, {other_m, other_m}, 1.0, 2.0, 0.0).offset_m;
  };
  EXPECT_NEAR(offset_m({3.0, 0.0, 0.0}), 1.0, 1e-12);  // half of 3 m less 1 m
  EXPECT_NEAR(offset_m({0.0, 0.0, 4.0}), 1.0, 1e-12);  // half of 4 m less 2 m
  EXPECT_NEAR(offset_m({0.0, 0.0, 2.0}), 0.0, 1e-12);
  const HalfSpace pledged = pledged_cut(Vector3::Zero(), {0.0, 0.0, 4.0}, Vector3::Zero(), 1.0, 2.0, 0.0, 0.4);
  EXPECT_NEAR(pledged.offset_m, 0.4 * 2.0, 1e-12);
}

TEST(RblSeparation, HandlesCoincidentPositions) {
  const Braking self{{1.0, 1.0, 1.0}, {1.0, 1.0, 1.0}};
  const HalfSpace cut = braking_cut(self, self, 1.0, 1.5, 0.0);
  EXPECT_NEAR(cut.normal_local.norm(), 1.0, 1e-12);
  EXPECT_LT(cut.offset_m, 0.0);
}

/// Two vehicles on a line fly towards each other as fast as their pledges allow. Each sees the other at intervals and
/// with latency. Both start and stop at once, so that only the pledge holds them. Returns the least room between them.
double least_room_m(double period_s, double latency_s, double share, double noise_m, double* last_room_m = nullptr) {
  const Random random(3, "rbl-separation.pledge");
  constexpr double kTick_s = 0.01, kSpeed_mps = 4.0;
  const int period = static_cast<int>(period_s / kTick_s), late = static_cast<int>(latency_s / kTick_s);
  std::vector<double> x_m[2] = {{0.0}, {30.0}};
  double own_seen_m[2] = {0.0, 30.0}, other_seen_m[2] = {30.0, 0.0}, least_m = 30.0;
  for (int k = 1; k < 6000; ++k) {
    const int then = k - 1 - late;
    for (int i = 0; i < 2 && then >= 0 && then % period == 0; ++i) {
      own_seen_m[i] = x_m[i][static_cast<std::size_t>(then)];
      other_seen_m[i] =
          x_m[1 - i][static_cast<std::size_t>(then)] +
          noise_m * random.uniform(-1.0, 1.0, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(k));
    }
    for (int i = 0; i < 2; ++i) {
      const double now_m = x_m[i].back();
      const HalfSpace cut =
          pledged_cut({own_seen_m[i], 0, 0}, {other_seen_m[i], 0, 0}, {now_m, 0, 0}, kApart_m, 1.5, noise_m, share);
      const double ahead_m = std::clamp(cut.offset_m, 0.0, kSpeed_mps * kTick_s);
      x_m[i].push_back(now_m + cut.normal_local.x() * ahead_m);
    }
    least_m = std::min(least_m, x_m[1].back() - x_m[0].back() - kApart_m);
  }
  if (last_room_m != nullptr) *last_room_m = x_m[1].back() - x_m[0].back() - kApart_m;
  return least_m;
}

TEST(RblSeparation, KeepsPledgedDistanceDespiteRareObservations) {
  for (const double period_s : {0.1, 0.5, 2.0}) {
    for (const double latency_s : {0.0, 0.05, 0.4}) {
      for (const double noise_m : {0.0, 0.5}) {
        double last_m = 0.0;
        EXPECT_GE(least_room_m(period_s, latency_s, 0.45, noise_m, &last_m), -1e-9) << period_s << ' ' << latency_s;
        EXPECT_LT(last_m, 0.1 + 3.0 * noise_m) << "they come together, though";
      }
    }
  }
  EXPECT_LT(least_room_m(2.0, 0.4, 0.9, 0.0), 0.0) << "with more than half they meet";
}

TEST(RblSeparation, DodgesToExactlyTheSafetyDistance) {
  const MotionLimits limits;
  Draws draws("rbl-separation", 7);
  int num_dodged = 0, num_level = 0;
  for (int i = 0; i < 20000; ++i) {
    const double vertical_m = i % 2 == 0 ? kApart_m : 1.5;
    const Braking self = drawn_braking(draws, 2.0, 1.0);
    const Vector3 other_m = draws.vector(6.0), v_mps = draws.vector(4.0);
    const auto cut = dodging_cut(self, other_m, v_mps, kApart_m, vertical_m, limits);
    const Vector3 scale(1.0, 1.0, kApart_m / vertical_m);
    const Vector3 ahead = scale.cwiseProduct(v_mps).normalized();
    const auto beside_m = [&](const Vector3& q_m) {
      const Vector3 r_m = scale.cwiseProduct(q_m - other_m);
      return (r_m - r_m.dot(ahead) * ahead).norm();
    };
    const bool comes = scale.cwiseProduct(self.stop_local_m - other_m).dot(ahead) > 0.0;
    ASSERT_EQ(cut.has_value(), comes && beside_m(self.stop_local_m) < kApart_m) << i;
    if (!cut) continue;
    ++num_dodged;
    num_level += cut->normal_local.z() == 0.0;
    ASSERT_NEAR(cut->normal_local.norm(), 1.0, 1e-12);
    // The displacement from the stopping point to the plane is perpendicular to the plane in the scaled space.
    const Vector3 out = -scale.cwiseInverse().cwiseProduct(scale.cwiseInverse().cwiseProduct(cut->normal_local));
    const double lacking_m = cut->normal_local.dot(self.stop_local_m - self.p_local_m) - cut->offset_m;
    ASSERT_GT(lacking_m, 0.0);
    const Vector3 q_m = self.stop_local_m + lacking_m / -out.dot(cut->normal_local) * out;
    ASSERT_NEAR(beside_m(q_m), kApart_m, 1e-6) << i;
  }
  EXPECT_GT(num_dodged, 100);
  EXPECT_GT(num_level, 50);
}

/// Direction in which a vehicle evades an intruder that flies east at 3 m/s, 5 m west of it.
Vector3 evasion(const Vector3& p_m, const Vector3* begun_local = nullptr, const MotionLimits& limits = {}) {
  const auto cut = dodging_cut({p_m, p_m}, {-5.0, 0.0, 0.0}, {3.0, 0.0, 0.0}, kApart_m, 1.5, limits, begun_local);
  return cut ? Vector3(-cut->normal_local) : Vector3(Vector3::Zero());
}

TEST(RblSeparation, DodgesRightOnCollisionCourse) {
  EXPECT_NEAR(evasion(Vector3::Zero()).y(), -1.0, 1e-12);  // the intruder's right is the south
  EXPECT_NEAR(evasion({0.0, 0.2, 0.0}).y(), 1.0, 1e-12);
  EXPECT_NEAR(evasion({0.0, -0.2, 0.0}).y(), -1.0, 1e-12);
}

TEST(RblSeparation, ContinuesDodgeUnlessOtherSideNearer) {
  const Vector3 begun_local(0.0, 1.0, 0.0);  // a dodge to the south
  EXPECT_NEAR(evasion({0.0, 0.2, 0.0}, &begun_local).y(), -1.0, 1e-12);
  EXPECT_NEAR(evasion({0.0, 1.0, 0.0}, &begun_local).y(), 1.0, 1e-12);
}

TEST(RblSeparation, DodgesLevelUnlessVerticallyFaster) {
  MotionLimits climbing;
  climbing.vertical_acceleration_mps2 = 20.0;
  EXPECT_EQ(evasion({0.0, 0.05, 0.3}).z(), 0.0);
  EXPECT_GT(evasion({0.0, 0.05, 0.3}, nullptr, climbing).z(), 0.5);
  EXPECT_GT(evasion({0.0, 0.05, 1.4}).z(), 0.5) << "almost high enough";
  EXPECT_LT(evasion({0.0, 0.05, -1.4}).z(), -0.5);
  const Vector3 p_m = Vector3::Zero();
  const auto falling = dodging_cut({p_m, p_m}, {0.0, 0.0, 4.0}, {0.0, 0.0, -2.0}, kApart_m, 1.5, MotionLimits{});
  ASSERT_TRUE(falling.has_value());
  EXPECT_EQ(falling->normal_local.z(), 0.0);
}

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
TEST(RblSeparation, LetsFastStraightIntrudersPass) {
  RblConfig config;
  config.goal_m = {0.0, 0.0, 5.0};
  for (const double speed_mps : {1.0, 2.0, 3.0, 4.0}) {
    for (const double side_m : {-0.6, -0.2, 0.0, 0.2, 0.6}) {
      for (const double above_m : {0.0, 0.4}) {
        testing::GuidanceDriver driver("rbl", config, config.goal_m);
        const double least_m = least_distance_m(driver, {-18.0, side_m, 5.0 + above_m}, {speed_mps, 0.0, 0.0}, 5.0,
                                                kApart_m / config.separation.vertical_m,
                                                [&](int, const Vector3& other_m) { driver.sees(2, other_m); });
        EXPECT_GT(least_m, 2.0 * config.cells.encumbrance_m) << speed_mps << " m/s, " << side_m << ", " << above_m;
      }
    }
  }
}

// An uncertain position shrinks the cell but does not delay the evasion.
TEST(RblSeparation, EvadesPoorlyObservedIntruder) {
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
TEST(RblSeparation, EvadesByLidarAwayFromWalls) {
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
TEST(RblSeparation, DescendsByLidarThroughObservedSpace) {
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

TEST(RblSeparation, LimitsClimbWhenLeavingThePlane) {
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

TEST(RblSeparation, LeavesPlaneByLidarWhereObserved) {
  RblConfig config;
  config.variant = RblConfig::Variant::k2d;
  config.goal_m = {0.0, 0.0, 5.0};
  config.ground_m = 4.4;
  config.lidar.enabled = true;
  testing::CellListMap open(0.25), roofed(0.25);
  roofed.occupy_box({-4.0, -4.0, 6.0}, {4.0, 4.0, 6.25});
  EXPECT_GT(highest_m(config, &open, true), 5.4);
  EXPECT_LE(highest_m(config, &roofed, true), 5.51);
  EXPECT_LE(highest_m(config, &open, false), 5.2) << "it was never farther away, and looks ahead only";
}

// There is no room to step aside, so the plane is left.
TEST(RblSeparation, ReturnsToPlaneAfterVerticalEvasion) {
  RblConfig config;
  config.variant = RblConfig::Variant::k2d;
  config.goal_m = {0.0, 0.0, 5.0};
  for (const double above_m : {0.0, 0.8}) {  // from a vehicle well above, it evades downwards
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
TEST(RblSeparation, StaysAtGoalAfterLosingNeighbor) {
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

TEST(RblSeparation, CapsLimitsKeepingVerticalProportions) {
  MotionLimits limits;
  limits.horizontal_acceleration_mps2 = 6.0;
  limits.vertical_acceleration_mps2 = 3.0;
  limits.horizontal_jerk_mps3 = 80.0;
  limits.vertical_jerk_mps3 = 40.0;
  RblSeparationConfig separation;
  separation.acceleration_mps2 = 2.0;
  separation.jerk_mps3 = 20.0;
  const MotionLimits cut = separation.within(limits);
  EXPECT_EQ(cut.horizontal_acceleration_mps2, 2.0);
  EXPECT_EQ(cut.vertical_acceleration_mps2, 1.0);
  EXPECT_EQ(cut.horizontal_jerk_mps3, 20.0);
  EXPECT_EQ(cut.vertical_jerk_mps3, 10.0);
  EXPECT_EQ(cut.horizontal_speed_mps, limits.horizontal_speed_mps);
  const MotionLimits slow{1.0, 1.0, 10.0, 1.0, 1.0, 10.0, 0.5, 1.0};
  EXPECT_EQ(separation.within(slow).horizontal_acceleration_mps2, 1.0);
  EXPECT_EQ(separation.within(slow).vertical_jerk_mps3, 10.0);
}

TEST(RblSeparation, LimitsSpeedInUnknownByBraking) {
  const double v_mps = speed_into_unknown_mps(15.0, 2.7, kApart_m, 2.0);
  const double way_m = v_mps * 2.7 + v_mps * v_mps / (2.0 * 2.0);
  EXPECT_NEAR(2.0 * way_m + kApart_m, 15.0, 1e-9);
  EXPECT_GT(speed_into_unknown_mps(15.0, 0.45, kApart_m, 2.0), 4.0);
  EXPECT_EQ(speed_into_unknown_mps(1.0, 0.45, kApart_m, 2.0), 0.0);
  EXPECT_GT(speed_into_unknown_mps(std::numeric_limits<double>::infinity(), 2.7, kApart_m, 2.0), 1e9);
}

}  // namespace
}  // namespace swiftlet
