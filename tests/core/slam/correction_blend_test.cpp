// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/graph/correction_blend.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"

namespace swiftlet {
namespace {

constexpr TimeNs kBlendTick = 4'000'000;

Pose shifted(const Vector3& by_m) { return make_pose(by_m, Eigen::Quaterniond::Identity()); }

double turned_rad(const Pose& T) { return rotation_vector_rad(Eigen::Quaterniond(Matrix3(T.linear()))).norm(); }

CorrectionBlend blend_of(BlendForm form) {
  CorrectionBlendConfig config;
  config.form = form;
  return CorrectionBlend(config);
}

/// World position of a point of the local frame at every tick, as seen by control.
std::vector<Vector3> shown(CorrectionBlend& blend, TimeNs from, TimeNs to, const Vector3& p_local_m) {
  std::vector<Vector3> places;
  for (TimeNs t = from; t <= to; t += kBlendTick) places.push_back(blend.advance(t) * p_local_m);
  return places;
}

struct Peaks {
  double speed_mps = 0.0, acceleration_mps2 = 0.0, jerk_mps3 = 0.0;
};

/// Peaks of finite differences; a step in any derivative appears in the next one as a peak over the tick.
Peaks peaks_of(const std::vector<Vector3>& p) {
  Peaks peaks;
  const double dt_s = to_seconds(kBlendTick);
  for (std::size_t i = 3; i < p.size(); ++i) {
    peaks.speed_mps = std::max(peaks.speed_mps, (p[i] - p[i - 1]).norm() / dt_s);
    peaks.acceleration_mps2 =
        std::max(peaks.acceleration_mps2, (p[i] - 2.0 * p[i - 1] + p[i - 2]).norm() / (dt_s * dt_s));
    peaks.jerk_mps3 =
        std::max(peaks.jerk_mps3, (p[i] - 3.0 * p[i - 1] + 3.0 * p[i - 2] - p[i - 3]).norm() / (dt_s * dt_s * dt_s));
  }
  return peaks;
}

// The printed form steps by 7 % at once, the released one by 1 %. Both complete the blend after 7 s.
TEST(CorrectionBlend, DocumentFormsFollowTheirEquations) {
  for (const BlendForm form : {BlendForm::kPrinted, BlendForm::kReleased}) {
    const bool printed = form == BlendForm::kPrinted;
    CorrectionBlend blend = blend_of(form);
    blend.head_for(0, shifted({1, 0, 0}), Vector3::Zero());
    const double step_m = printed ? 1.0 - 1.0 / (1.0 + 1.5 * std::exp(-3.0)) : 1.0 / (1.0 + std::exp(4.5));
    EXPECT_NEAR(blend.advance(0).translation().x(), step_m, 1e-12);
    EXPECT_NEAR(blend.advance(3 * kNsPerSecond).translation().x(), printed ? 0.6 : 0.5, 1e-12);
    EXPECT_FALSE(blend.is_done());
    EXPECT_EQ(blend.advance(7 * kNsPerSecond).translation().x(), 1.0);
    EXPECT_TRUE(blend.is_done());
  }
}

TEST(CorrectionBlend, DocumentFormsTurnAlongShortestArc) {
  CorrectionBlend blend = blend_of(BlendForm::kReleased);
  const Pose T = make_pose({1, 2, 3}, rotation_by({0, 0, 0.8}));
  blend.head_for(0, T, {100, 0, 0});
  const Pose half = blend.advance(3 * kNsPerSecond);
  EXPECT_NEAR(turned_rad(half), 0.4, 1e-12);
  EXPECT_LT((half.translation() - Vector3(0.5, 1.0, 1.5)).norm(), 1e-12);
}

TEST(CorrectionBlend, DocumentFormsRestartFromShownPose) {
  CorrectionBlend blend = blend_of(BlendForm::kReleased);
  blend.head_for(0, shifted({1, 0, 0}), Vector3::Zero());
  const double before_m = blend.advance(4 * kNsPerSecond).translation().x();
  blend.head_for(4 * kNsPerSecond, shifted({0, 0, 0}), Vector3::Zero());
  EXPECT_NEAR(blend.advance(4 * kNsPerSecond).translation().x(), before_m * (1.0 - 1.0 / (1.0 + std::exp(4.5))), 1e-12);
}

TEST(CorrectionBlend, BlendsOneMeterSmoothlyWithinLimits) {
  CorrectionBlend blend = blend_of(BlendForm::kLimited);
  const Vector3 p_local_m(30, -20, 5);
  blend.advance(0);
  blend.head_for(0, shifted({0.6, 0, 0.8}), p_local_m);
  EXPECT_EQ(blend.advance(0).matrix(), Pose::Identity().matrix()) << "nothing at once";
  const Peaks peaks = peaks_of(shown(blend, 0, 12 * kNsPerSecond, p_local_m));
  EXPECT_LE(peaks.speed_mps, 0.25);
  EXPECT_GT(peaks.speed_mps, 0.24) << "no slower than it has to be";
  EXPECT_LE(peaks.acceleration_mps2, 0.1001);
  EXPECT_LE(peaks.jerk_mps3, 0.1501);
  EXPECT_TRUE(blend.is_done());
  EXPECT_EQ(blend.advance(12 * kNsPerSecond).matrix(), shifted({0.6, 0, 0.8}).matrix());
}

TEST(CorrectionBlend, TurnsWithinLimitsNearTheVehicle) {
  CorrectionBlendConfig config;
  CorrectionBlend blend(config);
  const Vector3 p_local_m(80, 60, 5);
  const Pose T = make_pose({-3, 2, 0.5}, rotation_by({0.004, -0.003, 0.05}));
  blend.head_for(0, T, p_local_m);
  for (const Vector3& off : {Vector3(0, 0, 0), Vector3(6, 8, 0), Vector3(0, -10, 0)}) {
    CorrectionBlend again = blend;
    const Peaks peaks = peaks_of(shown(again, 0, 150 * kNsPerSecond, p_local_m + off));
    EXPECT_LE(peaks.speed_mps, 0.2501);
    EXPECT_LE(peaks.acceleration_mps2, 0.101);
    EXPECT_TRUE(again.is_done());
    EXPECT_EQ(again.advance(150 * kNsPerSecond).matrix(), T.matrix());
  }
}

TEST(CorrectionBlend, KeepsLimitsUnderManyClosures) {
  CorrectionBlend blend = blend_of(BlendForm::kLimited);
  std::vector<Vector3> places(1, Vector3::Zero());
  TimeNs t = 0;
  for (int i = 1; i <= 60; ++i) {
    const double a = 1.7 * i * i;
    blend.head_for(t, shifted({0.8 * std::cos(a), 0.8 * std::sin(a), 0.3 * std::cos(2.0 * a)}), Vector3::Zero());
    const TimeNs until = t + kBlendTick * (40 + (i * 379) % 1700);
    for (const Vector3& p : shown(blend, t + kBlendTick, until, Vector3::Zero())) places.push_back(p);
    t += kBlendTick * static_cast<TimeNs>(40 + (i * 379) % 1700);
  }
  for (const Vector3& p : shown(blend, t + kBlendTick, t + 60 * kNsPerSecond, Vector3::Zero())) places.push_back(p);
  EXPECT_TRUE(blend.is_done());
  const double last = 1.7 * 60 * 60;
  const Vector3 target_m(0.8 * std::cos(last), 0.8 * std::sin(last), 0.3 * std::cos(2.0 * last));
  EXPECT_LT((places.back() - target_m).norm(), 1e-12);
  const Peaks peaks = peaks_of(places);
  EXPECT_LE(peaks.speed_mps, 0.2501);
  EXPECT_LE(peaks.acceleration_mps2, 0.1002);
  EXPECT_LE(peaks.jerk_mps3, 0.1502);
}

TEST(CorrectionBlend, KeepsRateAndAccelerationContinuous) {
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
      t += kBlendTick;
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
  for (const auto& of_point : places) EXPECT_LT(peaks_of(of_point).jerk_mps3, 0.25);
}

/// Time until the blend is done, to a tenth of a millisecond.
double time_to_done_s(CorrectionBlend blend, double most_s) {
  double low_s = 0.0, high_s = most_s;
  while (high_s - low_s > 1e-4) {
    const double middle_s = 0.5 * (low_s + high_s);
    CorrectionBlend tried = blend;
    tried.advance(from_seconds(middle_s));
    (tried.is_done() ? high_s : low_s) = middle_s;
  }
  return high_s;
}

// From rest to rest over a distance of 1 in 1 s: peaks of 1.875, 10 / sqrt 3 and 60. The jerk's limit is 0.15 m/s^3.
double closed_form_s(const CorrectionBlendConfig& limits, double distance_m) {
  return std::max({1.875 * distance_m / limits.speed_max_mps,
                   std::sqrt(10.0 / std::sqrt(3.0) * distance_m / limits.acceleration_max_mps2),
                   std::cbrt(60.0 * distance_m / 0.15)});
}

TEST(CorrectionBlend, TakesTightestLimitsTimeFromRest) {
  const Vector3 p_local_m(5, -7, 2);
  for (int tightest = 0; tightest < 3; ++tightest) {
    CorrectionBlendConfig limits;
    limits.speed_max_mps = tightest == 0 ? 0.1 : 10.0;
    limits.acceleration_max_mps2 = tightest == 1 ? 0.05 : 10.0;
    limits.lever_m = 4.0;
    for (const double turn_rad : {0.0, 0.1}) {
      CorrectionBlend blend(limits);
      // The vehicle moves by u, for any rotation about it.
      const Vector3 u_m(0.3, -0.4, 1.2);
      Pose T = make_pose(Vector3::Zero(), rotation_by({0, 0, turn_rad}));
      T.translation() = p_local_m + u_m - T.linear() * p_local_m;
      blend.head_for(0, T, p_local_m);
      const double expected_s = closed_form_s(limits, u_m.norm() + limits.lever_m * turn_rad);
      const double s = time_to_done_s(blend, 3.0 * expected_s);
      EXPECT_GE(s, expected_s) << tightest << " " << turn_rad;
      EXPECT_LE(s, 1.005 * expected_s) << tightest << " " << turn_rad;
    }
  }
}

}  // namespace
}  // namespace swiftlet
