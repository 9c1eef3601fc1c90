// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/slam/correction_blend.hpp"

#include <gtest/gtest.h>

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
  double step_m = 0.0, speed_mps = 0.0, acceleration_mps2 = 0.0, jerk_mps3 = 0.0;
};

/// Peaks of finite differences; a step in any derivative appears in the next one as a peak over the tick.
Peaks peaks_of(const std::vector<Vector3>& p) {
  Peaks peaks;
  const double dt_s = to_seconds(kBlendTick);
  for (std::size_t i = 3; i < p.size(); ++i) {
    peaks.step_m = std::max(peaks.step_m, (p[i] - p[i - 1]).norm());
    peaks.speed_mps = std::max(peaks.speed_mps, (p[i] - p[i - 1]).norm() / dt_s);
    peaks.acceleration_mps2 =
        std::max(peaks.acceleration_mps2, (p[i] - 2.0 * p[i - 1] + p[i - 2]).norm() / (dt_s * dt_s));
    peaks.jerk_mps3 =
        std::max(peaks.jerk_mps3, (p[i] - 3.0 * p[i - 1] + 3.0 * p[i - 2] - p[i - 3]).norm() / (dt_s * dt_s * dt_s));
  }
  return peaks;
}

TEST(CorrectionBlend, StepsSevenPercentInPrintedForm) {
  CorrectionBlend blend = blend_of(BlendForm::kPrinted);
  blend.head_for(0, shifted({1, 0, 0}), Vector3::Zero());
  EXPECT_NEAR(blend.advance(0).translation().x(), 1.0 - 1.0 / (1.0 + 1.5 * std::exp(-3.0)), 1e-12);
  EXPECT_NEAR(blend.advance(0).translation().x(), 0.069, 0.001);
  EXPECT_NEAR(blend.advance(3 * kNsPerSecond).translation().x(), 0.6, 1e-12);
  EXPECT_LT(blend.advance(7 * kNsPerSecond - 1).translation().x(), 0.989);
  EXPECT_EQ(blend.advance(7 * kNsPerSecond).translation().x(), 1.0) << "the rest comes at once as well";
}

TEST(CorrectionBlend, StepsOnePercentInReleasedForm) {
  CorrectionBlend blend = blend_of(BlendForm::kReleased);
  blend.head_for(0, shifted({1, 0, 0}), Vector3::Zero());
  EXPECT_NEAR(blend.advance(0).translation().x(), 1.0 / (1.0 + std::exp(4.5)), 1e-12);
  EXPECT_NEAR(blend.advance(0).translation().x(), 0.011, 0.0002);
  EXPECT_NEAR(blend.advance(3 * kNsPerSecond).translation().x(), 0.5, 1e-12);
  EXPECT_TRUE(!blend.is_done());
  EXPECT_EQ(blend.advance(7 * kNsPerSecond).translation().x(), 1.0);
  EXPECT_TRUE(blend.is_done());
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

TEST(CorrectionBlend, DocumentFormsExceedTheLimits) {
  for (const BlendForm form : {BlendForm::kPrinted, BlendForm::kReleased}) {
    CorrectionBlend blend = blend_of(form);
    std::vector<Vector3> places(4, Vector3::Zero());
    blend.head_for(0, shifted({1, 0, 0}), Vector3::Zero());
    for (const Vector3& p : shown(blend, 0, 8 * kNsPerSecond, Vector3::Zero())) places.push_back(p);
    const Peaks peaks = peaks_of(places);
    EXPECT_GT(peaks.speed_mps, 2.0) << "a step within one tick";
    EXPECT_GT(peaks.step_m, form == BlendForm::kPrinted ? 0.069 : 0.0109);
  }
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

TEST(CorrectionBlend, ContinuesPoseAndRateAtClosures) {
  CorrectionBlend blend = blend_of(BlendForm::kLimited);
  const Vector3 p_local_m(20, 10, 3);
  std::vector<Vector3> places(1, p_local_m);
  const auto fly_until = [&](TimeNs from, TimeNs to) {
    for (const Vector3& p : shown(blend, from + kBlendTick, to, p_local_m)) places.push_back(p);
  };
  // The second one comes amid the fastest part, the third turns around at once; the vehicle has moved meanwhile.
  blend.head_for(0, make_pose({1, 0, 0.2}, rotation_by({0, 0, 0.02})), p_local_m);
  fly_until(0, 4 * kNsPerSecond);
  blend.head_for(4 * kNsPerSecond, make_pose({1.4, 0.3, 0}, rotation_by({0, 0, 0.03})), p_local_m + Vector3(4, 4, 0));
  fly_until(4 * kNsPerSecond, 7 * kNsPerSecond);
  const Pose T = make_pose({-1, -0.5, 0}, rotation_by({0, 0, -0.01}));
  blend.head_for(7 * kNsPerSecond, T, p_local_m + Vector3(5, 5, 0));
  fly_until(7 * kNsPerSecond, 60 * kNsPerSecond);
  const Peaks peaks = peaks_of(places);
  EXPECT_LE(peaks.speed_mps, 0.2501);
  EXPECT_LE(peaks.acceleration_mps2, 0.102) << "a step of the rate would be 1 m/s^2 and more";
  EXPECT_TRUE(blend.is_done());
  EXPECT_LT((blend.advance(60 * kNsPerSecond).matrix() - T.matrix()).norm(), 1e-12);
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
  // Each correction waited until it could begin within the limits; none was lost.
  for (const Vector3& p : shown(blend, t + kBlendTick, t + 60 * kNsPerSecond, Vector3::Zero())) places.push_back(p);
  EXPECT_TRUE(blend.is_done());
  const double last = 1.7 * 60 * 60;
  const Vector3 target_m(0.8 * std::cos(last), 0.8 * std::sin(last), 0.3 * std::cos(2.0 * last));
  EXPECT_LT((places.back() - target_m).norm(), 1e-12);
  const Peaks peaks = peaks_of(places);
  EXPECT_LE(peaks.speed_mps, 0.2501);
  EXPECT_LE(peaks.acceleration_mps2, 0.1002);
}

/// Peak angular acceleration of the blended attitude by finite differences.
double peak_turn_radps2(CorrectionBlend& blend, TimeNs from, TimeNs to, Matrix3& R_shown, Vector3& omega_radps) {
  double peak_radps2 = 0.0;
  const double dt_s = to_seconds(kBlendTick);
  for (TimeNs t = from + kBlendTick; t <= to; t += kBlendTick) {
    const Matrix3 R = blend.advance(t).linear();
    const Vector3 now_radps = rotation_vector_rad(Eigen::Quaterniond(Matrix3(R * R_shown.transpose()))) / dt_s;
    peak_radps2 = std::max(peak_radps2, (now_radps - omega_radps).norm() / dt_s);
    R_shown = R;
    omega_radps = now_radps;
  }
  return peak_radps2;
}

TEST(CorrectionBlend, KeepsRateContinuousBetweenLargeTurns) {
  CorrectionBlendConfig config;
  config.lever_m = 1.0;
  CorrectionBlend blend(config);
  Matrix3 R = Matrix3::Identity();
  Vector3 omega_radps = Vector3::Zero();
  blend.head_for(0, make_pose(Vector3::Zero(), rotation_by({0.3, 0, 1.6})), Vector3::Zero());
  double peak_radps2 = peak_turn_radps2(blend, 0, 4 * kNsPerSecond, R, omega_radps);
  EXPECT_GT(omega_radps.norm(), 0.15);
  blend.head_for(4 * kNsPerSecond, make_pose(Vector3::Zero(), rotation_by({-0.9, 0.9, 0.4})), Vector3::Zero());
  peak_radps2 = std::max(peak_radps2, peak_turn_radps2(blend, 4 * kNsPerSecond, 60 * kNsPerSecond, R, omega_radps));
  EXPECT_TRUE(blend.is_done());
  EXPECT_LT(peak_radps2, 0.2) << "a step of a tenth of the rate would be 4 rad/s^2";
}

}  // namespace
}  // namespace swiftlet
