// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/path_timing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

const PathLimits kLimits{
    .speed_mps = 3.0, .vertical_speed_mps = 1.0, .acceleration_mps2 = 1.2, .vertical_acceleration_mps2 = 0.7};

const PathLimits kSlowLimits{
    .speed_mps = 2.0, .vertical_speed_mps = 1.0, .acceleration_mps2 = 1.2, .vertical_acceleration_mps2 = 0.5};

bool anywhere(const Vector3&) { return true; }

// A straight path from rest to rest takes l / v + v / a, or 2 sqrt(l / a) when it is too short for the speed.
TEST(PathTiming, MatchesTrapezoidOnStraightPaths) {
  const auto duration_s = [&](const Vector3& to_m) {
    const auto path = time_path({{0, 0, 3}, Vector3(0, 0, 3) + to_m}, kSlowLimits, anywhere);
    return path->interval_s * static_cast<double>(path->control_points_m.size() - 1);
  };
  EXPECT_NEAR(duration_s({30, 0, 0}), 30.0 / 2.0 + 2.0 / 1.2, 0.4);
  EXPECT_NEAR(duration_s({0, -24, 18}), 30.0 / (1.0 / 0.6) + (1.0 / 0.6) / (0.5 / 0.6), 0.4)
      << "the climb is the limit";
  EXPECT_NEAR(duration_s({0, 0, 20}), 20.0 / 1.0 + 1.0 / 0.5, 0.4);
  EXPECT_NEAR(duration_s({1.5, 0, 0}), 2.0 * std::sqrt(1.5 / 1.2), 0.4);
}

TEST(PathTiming, IsEqualInBothDirections) {
  std::vector<Vector3> corners = {{0, 0, 3}, {6, 0, 3}, {6, 9, 5}, {-2, 9, 5}};
  const auto there = time_path(corners, kSlowLimits, anywhere);
  std::reverse(corners.begin(), corners.end());
  const auto back = time_path(corners, kSlowLimits, anywhere);
  EXPECT_NEAR(static_cast<double>(there->control_points_m.size()), static_cast<double>(back->control_points_m.size()),
              1.0);
}

TEST(PathTiming, LimitsSpeedAndAccelerationAroundCorners) {
  const auto path = time_path({{0, 0, 3}, {12, 0, 3}, {12, 12, 4}}, kLimits, anywhere);
  ASSERT_TRUE(path.has_value());
  EXPECT_DOUBLE_EQ(path->yaw_rad, 0.0);
  const UniformSpline spline = path->spline();
  double fastest = 0.0, hardest = 0.0, length_m = 0.0;
  Vector3 last = spline.at(0.0).p_m;
  for (double t_s = 0.0; t_s <= spline.duration_s(); t_s += 0.01) {
    const auto state = spline.at(t_s);
    fastest = std::max(fastest, state.v_mps.head<2>().norm());
    hardest = std::max(hardest, state.a_mps2.head<2>().norm());
    length_m += (state.p_m - last).norm();
    last = state.p_m;
  }
  EXPECT_LE(fastest, 3.0 * 1.02);
  EXPECT_GE(fastest, 2.5);
  // Simultaneous braking and turning, each within its limit.
  EXPECT_LE(hardest, 1.2 * 1.7);
  EXPECT_LT((spline.at(0.0).p_m - Vector3(0, 0, 3)).norm(), 1e-9);
  EXPECT_LT((spline.at(1e9).p_m - Vector3(12, 12, 4)).norm(), 1e-9);
  EXPECT_NEAR(length_m, 12.0 + std::hypot(12.0, 1.0), 1.0);  // the corner is rounded
}

TEST(PathTiming, KeepsTheVerticalSpeed) {
  const auto path = time_path({{0, 0, 3}, {1, 0, 15}}, kLimits, anywhere);
  ASSERT_TRUE(path.has_value());
  const UniformSpline spline = path->spline();
  for (double t_s = 0.0; t_s <= spline.duration_s(); t_s += 0.01) EXPECT_LE(spline.at(t_s).v_mps.z(), 1.0 * 1.02);
}

TEST(PathTiming, CutsCornersAccordingToAvailableRoom) {
  const Vector3 corner(12, 0, 3);
  const auto cut_m = [&](double room_m) {
    const auto has_room = [&](const Vector3& p) { return std::min(12.0 - p.x(), p.y()) < room_m; };
    const auto path = time_path({{0, 0, 3}, corner, {12, 12, 3}}, kLimits, has_room);
    if (!path) return std::nan("");
    double least_m = 1e9;
    for (const Vector3& p : path->control_points_m) least_m = std::min(least_m, (p - corner).norm());
    return least_m;
  };
  EXPECT_GT(cut_m(10.0), 1.5 * cut_m(0.2));
  EXPECT_TRUE(std::isnan(cut_m(0.01)));
}

TEST(PathTiming, IsIndependentOfPathSubdivision) {
  const std::vector<Vector3> corners = {{0, 0, 3}, {6, 0, 3}, {6, 6, 3}};
  std::vector<Vector3> short_legs = {corners[0]};
  for (int leg = 0; leg < 2; ++leg) {
    for (int i = 1; i <= 61; ++i) short_legs.push_back(corners[leg] + i / 61.0 * (corners[leg + 1] - corners[leg]));
  }
  const auto path = time_path(corners, kLimits, anywhere), same = time_path(short_legs, kLimits, anywhere);
  ASSERT_TRUE(path && same);
  EXPECT_NEAR(same->spline().duration_s(), path->spline().duration_s(), 0.2);
  for (double t_s = 0.0; t_s < path->spline().duration_s(); t_s += 0.1) {
    EXPECT_LT((same->spline().at(t_s).p_m - path->spline().at(t_s).p_m).norm(), 0.03) << t_s;
  }
}

}  // namespace
}  // namespace swiftlet
