// SPDX-License-Identifier: BSD-3-Clause
// The limited form of the blend: how long it takes and how smooth it is.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/slam/correction_blend.hpp"

namespace swiftlet {
namespace {

constexpr TimeNs kCourseMs = 1'000'000;

/// When it is shown in full, to a tenth of a millisecond.
double whole_after_s(CorrectionBlend blend, double most_s) {
  double low_s = 0.0, high_s = most_s;
  while (high_s - low_s > 1e-4) {
    const double middle_s = 0.5 * (low_s + high_s);
    CorrectionBlend tried = blend;
    tried.advance(from_seconds(middle_s));
    (tried.is_done() ? high_s : low_s) = middle_s;
  }
  return high_s;
}

// From rest to rest over a distance of 1 in 1 s: peaks of 1.875, 10 / sqrt 3 and 60.
double closed_form_s(const CorrectionBlendConfig& limits, double way_m) {
  return std::max({1.875 * way_m / limits.speed_max_mps,
                   std::sqrt(10.0 / std::sqrt(3.0) * way_m / limits.acceleration_max_mps2),
                   std::cbrt(60.0 * way_m / limits.jerk_max_mps3)});
}

TEST(BlendCourse, TakesTightestLimitsTimeFromRest) {
  const Vector3 p_local_m(5, -7, 2);
  for (int tightest = 0; tightest < 3; ++tightest) {
    CorrectionBlendConfig limits;
    limits.speed_max_mps = tightest == 0 ? 0.1 : 10.0;
    limits.acceleration_max_mps2 = tightest == 1 ? 0.05 : 10.0;
    limits.jerk_max_mps3 = tightest == 2 ? 0.02 : 10.0;
    limits.lever_m = 4.0;
    for (const double turn_rad : {0.0, 0.1}) {
      CorrectionBlend blend(limits);
      // The vehicle's place moves by u, whatever the turn about it.
      const Vector3 u_m(0.3, -0.4, 1.2);
      Pose T = make_pose(Vector3::Zero(), rotation_by({0, 0, turn_rad}));
      T.translation() = p_local_m + u_m - T.linear() * p_local_m;
      blend.head_for(0, T, p_local_m);
      const double expected_s = closed_form_s(limits, u_m.norm() + limits.lever_m * turn_rad);
      const double s = whole_after_s(blend, 3.0 * expected_s);
      EXPECT_GE(s, expected_s) << tightest << " " << turn_rad;
      EXPECT_LE(s, 1.005 * expected_s) << tightest << " " << turn_rad;
    }
  }
}

TEST(BlendCourse, NothingNewTakesAMillisecond) {
  CorrectionBlend blend{CorrectionBlendConfig()};
  blend.head_for(0, Pose::Identity(), Vector3::Zero());
  EXPECT_FALSE(blend.is_done());
  const double s = whole_after_s(blend, 0.1);
  EXPECT_GT(s, 0.9e-3);
  EXPECT_LT(s, 1.2e-3);
}

/// The third derivative of what is shown of points near the vehicle, by differences.
double jerk_of(const std::vector<Vector3>& p, double dt_s) {
  double most = 0.0;
  for (std::size_t i = 3; i < p.size(); ++i) {
    most = std::max(most, (p[i] - 3.0 * p[i - 1] + 3.0 * p[i - 2] - p[i - 3]).norm() / (dt_s * dt_s * dt_s));
  }
  return most;
}

TEST(BlendCourse, KeepsRateAndAccelerationContinuous) {
  CorrectionBlendConfig limits;
  limits.lever_m = 3.0;
  CorrectionBlend blend(limits);
  const Vector3 pivots_m[] = {{20, 10, 3}, {22, 11, 3}, {21, 12, 2}, {22, 10, 3}};
  const Pose targets[] = {make_pose({1.0, 0.0, 0.2}, rotation_by({0.02, -0.01, 0.25})),
                          make_pose({-3.0, 4.0, 0.3}, rotation_by({-0.03, 0.02, 0.1})),
                          make_pose({0.5, -2.0, 0.0}, rotation_by({0.0, 0.05, 0.3})),
                          make_pose({2.0, 1.0, -0.2}, rotation_by({0.01, 0.0, -0.05}))};
  std::vector<std::vector<Vector3>> places(3);
  TimeNs t = 0;
  const auto fly_for = [&](double s) {
    for (const TimeNs end = t + from_seconds(s); t < end;) {
      t += 4 * kCourseMs;
      const Pose T = blend.advance(t);
      for (int k = 0; k < 3; ++k) places[k].push_back(T * Vector3(pivots_m[0] + Vector3::Unit(k)));
    }
  };
  for (int i = 0; i < 4; ++i) {
    blend.head_for(t, targets[i], pivots_m[i]);
    fly_for(i == 3 ? 60.0 : 4.0 + 1.5 * i);
  }
  EXPECT_TRUE(blend.is_done());
  EXPECT_LT((blend.advance(t).matrix() - targets[3].matrix()).norm(), 1e-12);
  // A step of the acceleration by 0.003 m/s^2 would be a jerk of 0.75 m/s^3 more within a tick.
  for (const auto& of_point : places) EXPECT_LT(jerk_of(of_point, 4e-3), 0.25);
}

TEST(BlendCourse, ManyTargetsNeverStepTheAcceleration) {
  CorrectionBlend blend{CorrectionBlendConfig()};
  std::vector<Vector3> places;
  TimeNs t = 0;
  for (int i = 1; i <= 40; ++i) {
    const double a = 2.3 * i * i;
    blend.head_for(t, make_pose({std::cos(a), std::sin(a), 0.2 * std::cos(3.0 * a)}, Eigen::Quaterniond::Identity()),
                   Vector3::Zero());
    for (const TimeNs end = t + from_seconds(0.3 + 0.13 * (i * 7 % 40)); t < end;) {
      t += 10 * kCourseMs;
      places.push_back(blend.advance(t).translation());
    }
  }
  EXPECT_LT(jerk_of(places, 1e-2), 0.1502);
}

}  // namespace
}  // namespace swiftlet
