// SPDX-License-Identifier: BSD-3-Clause
// Reported odometry of another vehicle, interpolated between samples.
#include <gtest/gtest.h>

#include <cmath>

#include "core/localization/relative_filter.hpp"
#include "tests/core/localization/relative_support.hpp"

namespace swiftlet {
namespace {

OtherMotion motion_at(double t_s, const Vector3& p_m, const Vector3& v_mps, double yaw_rad, double rate_radps) {
  OtherMotion motion;
  motion.t = from_seconds(t_s);
  motion.p_other_local_m = p_m;
  motion.v_other_local_mps = v_mps;
  motion.yaw_rad = yaw_rad;
  motion.yaw_rate_radps = rate_radps;
  return motion;
}

TEST(RelativeOdometry, InterpolatesSamplesByTheirCubic) {
  // Cubics are exact, headings interpolate along the shorter arc, all else is linear.
  const auto place = [](double t) {
    return Vector3(1.0 + 2.0 * t - t * t + 0.3 * t * t * t, t * t, 4.0 - 0.5 * t * t * t);
  };
  const auto velocity = [](double t) { return Vector3(2.0 - 2.0 * t + 0.9 * t * t, 2.0 * t, -1.5 * t * t); };
  RelativeOdometry odometry;
  ASSERT_TRUE(odometry.push(motion_at(0.5, place(0.5), velocity(0.5), 3.0, 0.2)));
  ASSERT_TRUE(odometry.push(motion_at(1.3, place(1.3), velocity(1.3), -3.0, 0.6)));
  const double turned_rad = 2.0 * kPi - 6.0, path_m = (place(1.3) - place(0.5)).norm();
  for (int i = 0; i <= 8; ++i) {
    const double t_s = 0.5 + 0.1 * i, share = i / 8.0;
    const auto found = odometry.at(from_seconds(t_s), 2.0);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->t, from_seconds(t_s));
    EXPECT_LT((found->p_other_local_m - place(t_s)).norm(), 1e-9) << i;
    EXPECT_LT((found->v_other_local_mps - velocity(t_s)).norm(), 1e-9) << i;
    EXPECT_NEAR(std::remainder(found->yaw_rad - 3.0 - share * turned_rad, 2.0 * kPi), 0.0, 1e-9);
    EXPECT_NEAR(found->yaw_rate_radps, 0.2 + 0.4 * share, 1e-9);
    EXPECT_NEAR(found->flown.path_m, share * path_m, 1e-9);
    EXPECT_NEAR(found->flown.turn_rad, share * turned_rad, 1e-9);
    EXPECT_NEAR(found->flown.time_s, 0.8 * share, 1e-9);
  }
  EXPECT_FALSE(odometry.at(from_seconds(0.5) - 1, 2.0));
  EXPECT_FALSE(odometry.at(from_seconds(1.3) + 1, 2.0));
  EXPECT_TRUE(odometry.at(from_seconds(0.9), 0.81));
  EXPECT_FALSE(odometry.at(from_seconds(0.9), 0.79));
  EXPECT_TRUE(odometry.at(from_seconds(1.3), 0.1)) << "the sample itself lies in no gap";
}

TEST(RelativeOdometry, AccumulatesMotionAndKeeps64Samples) {
  RelativeOdometry odometry;
  EXPECT_TRUE(odometry.empty());
  EXPECT_FALSE(odometry.at(0, 10.0));
  double path_m = 0.0, turn_rad = 0.0;
  for (int i = 1; i <= 100; ++i) {
    const Vector3 p_m(0.1 * i, 0.2 * (i % 2), 0.0);
    if (i > 1) {
      path_m += std::hypot(0.1, 0.2);
      turn_rad += i % 2 == 0 ? 0.4 : 0.2;
    }
    const double yaw_rad = std::remainder(3.0 + 0.3 * i + (i % 2 == 0 ? 0.1 : 0.0), 2.0 * kPi);
    ASSERT_TRUE(odometry.push(motion_at(0.5 * i, p_m, Vector3::Zero(), yaw_rad, 0.0)));
    EXPECT_NEAR(odometry.newest().flown.path_m, path_m, 1e-9);
    EXPECT_NEAR(odometry.newest().flown.turn_rad, turn_rad, 1e-9);
    EXPECT_NEAR(odometry.newest().flown.time_s, 0.5 * (i - 1), 1e-9);
  }
  EXPECT_TRUE(odometry.at(from_seconds(0.5 * 37), 1.0));
  EXPECT_FALSE(odometry.at(from_seconds(0.5 * 37) - 1, 1.0));
  EXPECT_NEAR(odometry.at(from_seconds(30.25), 1.0)->flown.time_s, 29.75, 1e-9);
  EXPECT_FALSE(odometry.push(motion_at(50.0, Vector3::Zero(), Vector3::Zero(), 0.0, 0.0))) << "not newer";
  for (int k = 0; k < 4; ++k) {
    OtherMotion bad = motion_at(60.0, Vector3::Zero(), Vector3::Zero(), 0.0, 0.0);
    (k == 0   ? bad.p_other_local_m.x()
     : k == 1 ? bad.v_other_local_mps.y()
     : k == 2 ? bad.yaw_rad
              : bad.yaw_rate_radps) = std::nan("");
    EXPECT_FALSE(odometry.push(bad)) << k;
  }
}

TEST(RelativeOdometry, DriftsByDistanceTurnsAndTime) {
  const OdometryDrift drift({0.2, 0.3, 0.4, 2.0, 3.0, 4.0});
  const double deg2 = kRadPerDeg * kRadPerDeg;
  EXPECT_NEAR(drift.position_variance_m2({5.0, 0.0, 0.0}), 0.04 * 5.0, 1e-12);
  EXPECT_NEAR(drift.position_variance_m2({0.0, 4.0 * kPi, 0.0}), 0.09 * 2.0, 1e-12);
  EXPECT_NEAR(drift.position_variance_m2({0.0, 0.0, 7.0}), 0.16 * 7.0, 1e-12);
  EXPECT_NEAR(drift.yaw_variance_rad2({5.0, 2.0 * kPi, 7.0}), (4.0 * 5.0 + 9.0 + 16.0 * 7.0) * deg2, 1e-12);
}

}  // namespace
}  // namespace swiftlet
