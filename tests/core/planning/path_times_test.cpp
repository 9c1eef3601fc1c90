// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "swiftlet/core/planning/grid_search.hpp"
#include "swiftlet/core/planning/path_timing.hpp"
#include "tests/core/planning/box_space.hpp"

namespace swiftlet {
namespace {

bool anywhere(const Vector3&) { return true; }

// A straight path from rest to rest takes l / v + v / a, or 2 sqrt(l / a) when it is too short for the speed.
TEST(PathTimes, MatchTrapezoidOnStraightPaths) {
  const PathLimits limits{
      .speed_mps = 2.0, .vertical_speed_mps = 1.0, .acceleration_mps2 = 1.2, .vertical_acceleration_mps2 = 0.5};
  const auto duration_s = [&](const Vector3& to_m) {
    const auto path = time_path({{0, 0, 3}, Vector3(0, 0, 3) + to_m}, limits, anywhere);
    return path->interval_s * static_cast<double>(path->control_points_m.size() - 1);
  };
  EXPECT_NEAR(duration_s({30, 0, 0}), 30.0 / 2.0 + 2.0 / 1.2, 0.4);
  EXPECT_NEAR(duration_s({0, -24, 18}), 30.0 / (1.0 / 0.6) + (1.0 / 0.6) / (0.5 / 0.6), 0.4)
      << "the climb is the limit";
  EXPECT_NEAR(duration_s({0, 0, 20}), 20.0 / 1.0 + 1.0 / 0.5, 0.4);
  EXPECT_NEAR(duration_s({1.5, 0, 0}), 2.0 * std::sqrt(1.5 / 1.2), 0.4);
}

TEST(PathTimes, AreEqualInBothDirections) {
  const PathLimits limits{
      .speed_mps = 2.0, .vertical_speed_mps = 1.0, .acceleration_mps2 = 1.2, .vertical_acceleration_mps2 = 0.5};
  std::vector<Vector3> corners = {{0, 0, 3}, {6, 0, 3}, {6, 9, 5}, {-2, 9, 5}};
  const auto there = time_path(corners, limits, anywhere);
  std::reverse(corners.begin(), corners.end());
  const auto back = time_path(corners, limits, anywhere);
  EXPECT_NEAR(static_cast<double>(there->control_points_m.size()), static_cast<double>(back->control_points_m.size()),
              1.0);
  EXPECT_NEAR(std::abs(there->yaw_rad - 0.0), 0.0, 1e-12);
  EXPECT_NEAR(std::abs(back->yaw_rad), 0.0, 1e-12);
}

// Two paths lead around a square; the shorter one is taken, on either side.
TEST(PathTimes, TakeTheShorterWayAround) {
  for (const double shift_m : {-2.0, 2.0}) {
    const testing::BoxSpace floor(
        [&](const Vector3& p) { return std::abs(p.x()) < 3.0 && std::abs(p.y() - shift_m) < 4.0; }, 1);
    const PathResult path = find_path(floor, {-6.25, 0.25, 0.25}, {6.25, 0.25, 0.25});
    ASSERT_EQ(path.status, PathStatus::kFound);
    const double side = shift_m > 0.0 ? -1.0 : 1.0, around_m = 2.0 * std::hypot(3.25, 2.0 + 0.25 * side) + 6.0;
    EXPECT_LT(testing::length_m(path.corners_world_m), 1.1 * around_m);
    for (const Vector3& corner : path.corners_world_m) EXPECT_GE(corner.y() * side, -0.3);
  }
}

}  // namespace
}  // namespace swiftlet
