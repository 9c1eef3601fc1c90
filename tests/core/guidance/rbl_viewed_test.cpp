// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/flocking/rbl_viewed.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/guidance/flocking/rbl_obstacles.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

constexpr double kReach_m = 7.0, kOwn_m = 0.5;

std::array<HalfSpace, 2> view_at(double yaw_rad) {
  return field_of_view(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ()).toRotationMatrix(), 20.0, 59.0);
}

TEST(RblViewed, ContainsItselfAndTheSensorWedge) {
  const testing::CellListMap empty(0.25);
  RblViewed viewed(kReach_m, kOwn_m);
  const Vector3 p_m(1.0, 2.0, 5.0);
  EXPECT_FALSE(viewed.contains(p_m, empty)) << "nothing is viewed before the first scan";
  viewed.look(p_m, 0.0, view_at(0.0));
  EXPECT_TRUE(viewed.contains(p_m - Vector3(0.0, 0.0, 0.49), empty));
  EXPECT_FALSE(viewed.contains(p_m - Vector3(0.0, 0.0, 0.51), empty));
  EXPECT_FALSE(viewed.contains(p_m - Vector3(0.6, 0.0, 0.0), empty)) << "behind it";
  EXPECT_TRUE(viewed.contains(p_m + Vector3(6.9, 0.0, 0.0), empty));
  EXPECT_FALSE(viewed.contains(p_m + Vector3(7.1, 0.0, 0.0), empty));
  for (const double up_deg : {-21.0, -19.0, 38.0, 40.0}) {
    const Vector3 q_m = p_m + 4.0 * Vector3(std::cos(up_deg * kRadPerDeg), 0.0, std::sin(up_deg * kRadPerDeg));
    EXPECT_EQ(viewed.contains(q_m, empty), up_deg > -20.0 && up_deg < 39.0) << up_deg;
  }
}

TEST(RblViewed, RemembersSpaceBelowSeenFromAfar) {
  const testing::CellListMap empty(0.25);
  RblViewed viewed(kReach_m, kOwn_m);
  const Vector3 below_m(6.0, 0.0, 3.4);
  for (double x_m = 0.0; x_m <= 6.0; x_m += 0.1) viewed.look({x_m, 0.0, 5.0}, 0.0, view_at(0.0));
  EXPECT_TRUE(viewed.contains(below_m, empty));
  EXPECT_FALSE(viewed.contains({0.5, 0.0, 3.4}, empty)) << "the point was below the field of view all the time";
  EXPECT_FALSE(viewed.contains({6.0, 0.0, 1.0}, empty));
}

TEST(RblViewed, ExcludesSpaceHiddenByObstacles) {
  testing::CellListMap map(0.25);
  map.occupy_box({3.0, -1.0, 4.0}, {3.25, 1.0, 6.0});
  RblViewed viewed(kReach_m, kOwn_m);
  viewed.look({0.0, 0.0, 5.0}, 0.0, view_at(0.0));
  EXPECT_TRUE(viewed.contains({2.5, 0.0, 5.0}, map));
  EXPECT_FALSE(viewed.contains({4.0, 0.0, 5.0}, map));
  viewed.look({2.0, 4.0, 5.0}, -1.1, view_at(-1.1));  // around its corner
  EXPECT_TRUE(viewed.contains({4.0, 0.0, 5.0}, map));
}

TEST(RblViewed, RemembersTheLastHundredMeters) {
  const testing::CellListMap empty(0.25);
  RblViewed viewed(kReach_m, kOwn_m);
  for (double x_m = 0.0; x_m <= 200.0; x_m += 0.5) viewed.look({x_m, 0.0, 5.0}, 0.0, view_at(0.0));
  EXPECT_TRUE(viewed.contains({199.0, 0.0, 5.0}, empty));
  EXPECT_TRUE(viewed.contains({101.0, 0.0, 5.0}, empty));
  EXPECT_FALSE(viewed.contains({50.0, 0.0, 5.0}, empty));
}

}  // namespace
}  // namespace swiftlet
