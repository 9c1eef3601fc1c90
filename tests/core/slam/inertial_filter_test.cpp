// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/inertial_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/localization/rotation.hpp"

namespace swiftlet {
namespace {

using Filter = InertialFilter;

Filter::State some_state() {
  Filter::State state;
  state.nav.p_m = {1, -2, 3};
  state.nav.v_mps = {2, 0.5, -1};
  state.nav.q = rotation_by({0.2, -0.4, 1.1});
  state.accel_bias_body_mps2 = {0.1, -0.2, 0.05};
  state.gyro_bias_body_radps = {0.01, -0.02, 0.005};
  state.tilt_local = {0.05, -0.08};
  state.time_offset_s = 0.01;
  return state;
}

/// The error that turns one state into another.
Filter::Error between(const Filter::State& from, const Filter::State& to) {
  Filter::Error d;
  d.segment<3>(Filter::kP) = to.nav.p_m - from.nav.p_m;
  d.segment<3>(Filter::kV) = to.nav.v_mps - from.nav.v_mps;
  d.segment<3>(Filter::kTheta) = rotation_vector_rad(from.nav.q.conjugate() * to.nav.q);
  d.segment<3>(Filter::kAccelBias) = to.accel_bias_body_mps2 - from.accel_bias_body_mps2;
  d.segment<3>(Filter::kGyroBias) = to.gyro_bias_body_radps - from.gyro_bias_body_radps;
  d.segment<2>(Filter::kTilt) = to.tilt_local - from.tilt_local;
  d(Filter::kTimeOffset) = to.time_offset_s - from.time_offset_s;
  return d;
}

TEST(InertialFilter, TransitionIsDerivativeOfMotion) {
  const Vector3 measured_omega(0.7, -1.2, 2.0), measured_force(1.0, -2.0, 11.0);
  constexpr double kDt_s = 0.004, kStep = 1e-5;
  const auto advanced = [&](const Filter::State& s) {
    return Filter::advanced(s, measured_omega - s.gyro_bias_body_radps, measured_force - s.accel_bias_body_mps2, kDt_s);
  };
  const Filter::State state = some_state();
  const Filter::Covariance F = Filter::transition(state, measured_omega - state.gyro_bias_body_radps,
                                                  measured_force - state.accel_bias_body_mps2, kDt_s);
  for (int i = 0; i < Filter::kStates; ++i) {
    const Filter::Error d = kStep * Filter::Error::Unit(i);
    const Filter::Error numeric =
        between(advanced(state.changed_by(-d)), advanced(state.changed_by(d))) / (2.0 * kStep);
    // The neglected terms are of second order in dt (of third in position).
    EXPECT_LT((F.col(i) - numeric).norm(), 5e-4) << "column " << i;
    EXPECT_LT((F.col(i) - numeric).segment<3>(Filter::kP).norm(), 1e-6) << "column " << i;
  }
}

TEST(InertialFilter, StaysAtRestUnderTiltedGravity) {
  Filter::State state;
  state.tilt_local = {0.1, -0.05};
  const Vector3 force = -state.gravity_local_mps2();
  EXPECT_NEAR(force.norm(), kGravity_mps2, 1e-12);
  for (int i = 0; i < 250; ++i) state = Filter::advanced(state, Vector3::Zero(), force, 0.004);
  EXPECT_LT(state.nav.p_m.norm() + state.nav.v_mps.norm(), 1e-12);
}

/// A filter that has flown for a while, so that all its states depend on each other.
Filter flown_filter() {
  Filter filter({}, make_pose({1, 2, 3}, rotation_by({0, 0, 0.5})));
  for (int i = 0; i <= 100; ++i) {
    filter.predict({i * 4'000'000, {0.1, 0.3, -0.2}, {0.5, 0.2, 9.9}});
  }
  return filter;
}

TEST(InertialFilter, UpdatesAsKalmanFilter) {
  Filter filter = flown_filter();
  const Filter::State prior = filter.state();
  const Filter::Covariance P = filter.covariance();
  // A pose measured with a covariance, off by some millimeters: linear, so that one step is exact.
  PoseEvidence evidence;
  Matrix6 R = Matrix6::Zero();
  R.diagonal() << 1e-4, 2e-4, 3e-4, 1e-5, 2e-5, 1e-5;
  Eigen::Matrix<double, 6, 1> measured;
  measured << 0.003, -0.002, 0.001, 2e-4, -1e-4, 3e-4;
  evidence.information = R.inverse();
  const auto at = [&](const Pose& T_local_body) {
    PoseEvidence e = evidence;
    Eigen::Matrix<double, 6, 1> off;
    off << T_local_body.translation() - prior.nav.p_m,
        rotation_vector_rad(prior.nav.q.conjugate() * Eigen::Quaterniond(T_local_body.linear()));
    e.gradient = evidence.information * (off - measured);
    return e;
  };
  filter.update(at, 5);

  Eigen::Matrix<double, 6, Filter::kStates> H = Eigen::Matrix<double, 6, Filter::kStates>::Zero();
  H.block<3, 3>(0, Filter::kP).setIdentity();
  H.block<3, 3>(3, Filter::kTheta).setIdentity();
  const Eigen::Matrix<double, Filter::kStates, 6> K = P * H.transpose() * (H * P * H.transpose() + R).inverse();
  const Filter::Error expected = K * measured;
  EXPECT_LT((between(prior, filter.state()) - expected).norm(), 1e-6);
  const Filter::Covariance P_expected = (Filter::Covariance::Identity() - K * H) * P;
  EXPECT_LT((filter.covariance() - P_expected).norm(), 1e-9);
}

// A scan that lies ahead along the motion is explained by the time offset, if its pose is certain.
TEST(InertialFilter, LearnsTimeOffsetFromMotion) {
  Filter filter({}, Pose::Identity());
  filter.predict({4'000'000, Vector3::Zero(), {0, 0, 9.81}});
  Eigen::Matrix<double, 6, 1> twist, moved;
  twist << 3.0, 0.0, 0.0, 0.0, 0.0, 0.5;
  moved = 0.02 * twist;
  filter.set_scan_motion(twist);
  const Matrix6 information = 1e8 * Matrix6::Identity();
  filter.update(
      [&](const Pose& T) {
        Eigen::Matrix<double, 6, 1> off;
        off << T.translation(), rotation_vector_rad(Eigen::Quaterniond(T.linear()));
        return PoseEvidence{information, information * (off - moved)};
      },
      5);
  EXPECT_NEAR(filter.state().time_offset_s, 0.02, 1e-4);
  EXPECT_LT(filter.state().nav.p_m.norm(), 1e-3);
  EXPECT_LT(filter.time_offset_sigma_s(), 1e-3);
  EXPECT_NEAR(filter.innovation_sq(), 1.0, 0.1) << "one sigma of the prior's 20 ms";
}

TEST(InertialFilter, CoastsWithoutSamplesAndRestoresBias) {
  Filter filter = flown_filter();
  Filter::State before = filter.state();
  const Matrix3 bias_covariance = filter.covariance().block<3, 3>(Filter::kGyroBias, Filter::kGyroBias);
  filter.predict_to(1'400'000'000);
  EXPECT_TRUE(filter.is_coasting());
  EXPECT_LT((filter.state().nav.v_mps - before.nav.v_mps).norm(), 1e-12);
  EXPECT_LT((filter.state().nav.p_m - before.nav.p_m - before.nav.v_mps).norm(), 1e-9);
  EXPECT_LT((filter.state().nav.omega_body_radps - before.nav.omega_body_radps).norm(), 1e-12);
  EXPECT_GT(std::sqrt(filter.covariance()(Filter::kV, Filter::kV)), 1.0);
  filter.predict({1'404'000'000, {0.1, 0.3, -0.2}, {0, 0, 9.81}});
  EXPECT_FALSE(filter.is_coasting());
  EXPECT_EQ(filter.state().gyro_bias_body_radps, before.gyro_bias_body_radps);
  const Matrix3 after = filter.covariance().block<3, 3>(Filter::kGyroBias, Filter::kGyroBias);
  EXPECT_LT((after - bias_covariance).norm(), 1e-8);
}

TEST(InertialFilter, LevelingMakesGravityVertical) {
  Filter filter = flown_filter();
  Filter::State state = filter.state();
  filter.level();
  EXPECT_LT(filter.state().gravity_local_mps2().head<2>().norm(), 1e-12);
  const auto force_body_mps2 = [](const Filter::State& s) {
    return Vector3(s.nav.q.conjugate() * s.gravity_local_mps2());
  };
  EXPECT_LT((force_body_mps2(filter.state()) - force_body_mps2(state)).norm(), 1e-9)
      << "leveling keeps gravity in body axes";
}

TEST(InertialFilter, EvidenceThatIsEmptyChangesNothing) {
  Filter filter = flown_filter();
  const Filter::State prior = filter.state();
  const Filter::Covariance P = filter.covariance();
  filter.update([](const Pose&) { return PoseEvidence(); }, 5);
  EXPECT_LT(between(prior, filter.state()).norm(), 1e-12);
  EXPECT_LT((filter.covariance() - P).norm(), 1e-12);
}

TEST(InertialFilter, WithoutScansGrowsPoseUncertainty) {
  Filter filter = flown_filter();
  const double before_m = std::sqrt(filter.pose_covariance().diagonal().head<3>().maxCoeff());
  for (int i = 101; i <= 350; ++i) filter.predict({i * 4'000'000, {0, 0, 0}, {0, 0, 9.81}});
  // A second under an unknown bias of 0.196 m/s^2: 0.1 m, plus the speed of the start.
  EXPECT_GT(std::sqrt(filter.pose_covariance().diagonal().head<3>().maxCoeff()), before_m + 0.1);
  EXPECT_TRUE(filter.is_sound());
}

TEST(InertialFilter, LosesVelocityAndAttitudeAfterGap) {
  const auto spread_after = [](TimeNs gap) {
    Filter filter = flown_filter();
    filter.predict({400'000'000 + gap, {0, 0, 0}, {0, 0, 9.81}});
    return Eigen::Vector2d(std::sqrt(filter.covariance()(Filter::kP, Filter::kP)),
                           std::sqrt(filter.covariance()(Filter::kTheta, Filter::kTheta)));
  };
  const Eigen::Vector2d bridged = spread_after(100'000'000), gap = spread_after(400'000'000);
  EXPECT_LT(bridged.y(), 0.05);
  // In 0.4 s a rotation of 0.4 rad and an offset of 0.16 m are possible.
  EXPECT_GT(gap.x(), 0.16);
  EXPECT_GT(gap.y(), 0.4);
  EXPECT_LT(gap.y(), 0.5);
}

TEST(InertialFilter, IgnoresNonFiniteOrStaleSamples) {
  Filter filter = flown_filter();
  const Vector3 p_m = filter.state().nav.p_m;
  filter.predict({500'000'000, {std::nan(""), 0, 0}, {0, 0, 9.81}});
  filter.predict({100'000'000, {0, 0, 0}, {0, 0, 9.81}});
  EXPECT_EQ(filter.state().nav.p_m, p_m);
}

// The difference of the covariances of two filters that differ in one noise is the effect of that noise: white noise of
// the accelerometer, integrated once and twice.
TEST(InertialFilter, IntegratesAccelerometerNoise) {
  constexpr double kNoise = 0.5, kDuration_s = 2.0;
  const auto after_flight = [](double accel_noise_mps2_sqrt_hz) {
    InertialConfig config;
    config.accel_noise_mps2_sqrt_hz = accel_noise_mps2_sqrt_hz;
    Filter filter(config, Pose::Identity());
    for (int i = 0; i <= 20; ++i) filter.predict({i * 100'000'000, {0, 0, 0}, {0, 0, 9.81}});
    return filter.covariance();
  };
  const Filter::Covariance added = after_flight(kNoise) - after_flight(0.0);
  const double q = kNoise * kNoise;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(added(Filter::kP + axis, Filter::kP + axis) / (q * std::pow(kDuration_s, 3) / 3.0), 1.0, 5e-3);
    EXPECT_NEAR(added(Filter::kP + axis, Filter::kV + axis) / (q * std::pow(kDuration_s, 2) / 2.0), 1.0, 1e-9);
    EXPECT_NEAR(added(Filter::kV + axis, Filter::kP + axis) / (q * std::pow(kDuration_s, 2) / 2.0), 1.0, 1e-9);
    EXPECT_NEAR(added(Filter::kV + axis, Filter::kV + axis) / (q * kDuration_s), 1.0, 1e-9);
  }
}

TEST(InertialFilter, WithoutTiltMatchesStrapdown) {
  Filter::State state = some_state();
  state.tilt_local.setZero();
  NavState nav = state.nav;
  const Vector3 omega(0.7, -1.2, 2.0), force(1.0, -2.0, 11.0);
  const NavState before = nav;
  strapdown(nav, omega, force, 0.02);
  const Filter::State next = Filter::advanced(state, omega, force, 0.02);
  EXPECT_LT((next.nav.p_m - nav.p_m).norm() + (next.nav.v_mps - nav.v_mps).norm(), 1e-14);
  EXPECT_LT(next.nav.q.angularDistance(nav.q), 1e-12);
  EXPECT_EQ(next.nav.omega_body_radps, omega);
  EXPECT_GT((next.nav.p_m - before.p_m).norm(), 0.01);
}

TEST(InertialFilter, LimitsTheTiltOfGravity) {
  Filter::Error d = Filter::Error::Zero();
  d.segment<2>(Filter::kTilt) << 30.0, 40.0;
  const Filter::State steep = Filter::State().changed_by(d);
  EXPECT_LT(steep.tilt_local.norm(), 1.0);
  EXPECT_NEAR(steep.gravity_local_mps2().norm(), kGravity_mps2, 1e-12);
  EXPECT_LT(steep.gravity_local_mps2().z(), 0.0);
}

TEST(InertialFilter, FirstSampleOnlySetsTime) {
  Filter filter({}, make_pose({1, 2, 3}, Eigen::Quaterniond::Identity()));
  const Filter::Covariance P = filter.covariance();
  filter.predict_to(1'000'000'000);
  EXPECT_EQ(filter.state().nav.t, 0) << "nothing is known of its motion yet";
  filter.predict({5'000'000'000, {0, 0, 1}, {3, 0, 9.81}});
  EXPECT_EQ(filter.state().nav.t, 5'000'000'000);
  EXPECT_EQ(filter.state().nav.p_m, Vector3(1, 2, 3));
  EXPECT_EQ(filter.covariance(), P);
  // Later steps use the last sample.
  Filter other = filter;
  filter.predict_to(5'010'000'000);
  other.predict({5'010'000'000, {0, 0, 1}, {3, 0, 9.81}});
  EXPECT_EQ(filter.state().nav.t, other.state().nav.t);
  EXPECT_EQ(filter.state().nav.p_m, other.state().nav.p_m);
  EXPECT_EQ(filter.covariance(), other.covariance());
  EXPECT_GT(filter.state().nav.v_mps.x(), 0.02);
  filter.predict_to(5'005'000'000);
  EXPECT_EQ(filter.state().nav.t, other.state().nav.t) << "never back";
}

// The difference of two filters that differ in one noise is the effect of that noise.
TEST(InertialFilter, GrowsOtherNoisesWithTime) {
  constexpr double kDt_s = 0.05;
  const auto after = [](double gyro, double accel_walk, double gyro_walk) {
    InertialConfig config;
    config.gyro_noise_radps_sqrt_hz = gyro;
    config.accel_walk_mps3_sqrt_hz = accel_walk;
    config.gyro_walk_radps2_sqrt_hz = gyro_walk;
    Filter filter(config, Pose::Identity());
    filter.predict({1, Vector3::Zero(), {0, 0, 9.81}});
    filter.predict({1 + from_seconds(kDt_s), Vector3::Zero(), {0, 0, 9.81}});
    return filter.covariance();
  };
  const Filter::Covariance none = after(0, 0, 0);
  const auto expect_added = [&](const Filter::Covariance& noisy, int first, double variance) {
    Filter::Error expected = Filter::Error::Zero();
    expected.segment<3>(first).setConstant(variance);
    EXPECT_LT((noisy - none - Filter::Covariance(expected.asDiagonal())).norm(), 1e-12) << first;
  };
  expect_added(after(0.2, 0, 0), Filter::kTheta, 0.04 * kDt_s);
  expect_added(after(0, 0.3, 0), Filter::kAccelBias, 0.09 * kDt_s);
  expect_added(after(0, 0, 0.1), Filter::kGyroBias, 0.01 * kDt_s);
}

TEST(InertialFilter, RestartDoublesSigmaWithinPrior) {
  const Filter learned = flown_filter();
  InertialConfig unknown;  // hardly anything is known before
  unknown.start_accel_bias_sigma_mps2 = unknown.start_gyro_bias_sigma_radps = unknown.start_velocity_sigma_mps = 1e3;
  unknown.start_tilt_sigma_deg = 60.0;
  unknown.time_offset_sigma_s = 1e3;
  Filter again(unknown, make_pose({1, 2, 3}, rotation_by({0, 0, 0.5})));
  again.begin_with(learned, {0.4, -0.3, 0.2});
  EXPECT_EQ(again.state().nav.v_mps, Vector3(0.4, -0.3, 0.2));
  EXPECT_EQ(again.state().nav.p_m, Vector3(1, 2, 3));
  EXPECT_EQ(again.state().accel_bias_body_mps2, learned.state().accel_bias_body_mps2);
  EXPECT_EQ(again.state().gyro_bias_body_radps, learned.state().gyro_bias_body_radps);
  EXPECT_EQ(again.state().tilt_local, learned.state().tilt_local);
  for (int i = Filter::kAccelBias; i < Filter::kStates; ++i) {
    EXPECT_NEAR(again.covariance()(i, i) / learned.covariance()(i, i), 4.0, 1e-3) << i;
  }
  EXPECT_TRUE(again.pose_covariance().isZero());
  // What was known before is not forgotten.
  Filter known({}, Pose::Identity());
  const Filter::Covariance before = known.covariance();
  known.begin_with(learned, {0.4, -0.3, 0.2});
  for (int i = Filter::kV; i < Filter::kStates; ++i)
    EXPECT_LE(known.covariance()(i, i), before(i, i) * (1.0 + 1e-12)) << i;
}

TEST(InertialFilter, OffsetAndPredictionWidenThePose) {
  InertialConfig config;
  config.time_offset_sigma_s = 0.02;
  config.start_velocity_sigma_mps = 0.1;
  const Filter learned(config, Pose::Identity());
  Filter moving(config, Pose::Identity());
  moving.begin_with(learned, {2.0, 0.0, 0.0});
  const auto sigma_m = [&](double dt_s, int axis) { return std::sqrt(moving.pose_covariance_after(dt_s)(axis, axis)); };
  EXPECT_NEAR(sigma_m(0.0, 0), 0.04, 1e-12) << "2 m/s for 0.02 s";
  EXPECT_NEAR(sigma_m(0.0, 1), 0.0, 1e-12);
  EXPECT_GT(sigma_m(0.1, 1), 0.1 * 0.1);
  EXPECT_GT(sigma_m(0.2, 1) - sigma_m(0.1, 1), sigma_m(0.1, 1)) << "unknown accelerations add up";
}

TEST(InertialFilter, PoseIsExactAtMapOrigin) {
  Filter filter = flown_filter();
  const Filter::Covariance P = filter.covariance();
  filter.anchor_pose();
  for (int i = 0; i < Filter::kStates; ++i) {
    for (int j = 0; j < Filter::kStates; ++j) {
      const auto of_pose = [](int k) { return k < 3 || (k >= 6 && k < 9); };
      EXPECT_EQ(filter.covariance()(i, j), of_pose(i) || of_pose(j) ? 0.0 : P(i, j));
    }
  }
}

TEST(InertialFilter, IsSoundWhileStateIsFinite) {
  EXPECT_TRUE(flown_filter().is_sound());
  Filter lost = flown_filter();
  lost.update(
      [](const Pose&) {
        PoseEvidence evidence;
        evidence.information.setConstant(std::nan(""));
        return evidence;
      },
      5);
  EXPECT_TRUE(lost.is_sound()) << "evidence that is no number is none";
  InertialConfig config;
  config.accel_noise_mps2_sqrt_hz = 1e200;
  Filter broken(config, Pose::Identity());
  for (int i = 0; i < 3; ++i) broken.predict({i * 4'000'000, Vector3::Zero(), {0, 0, 9.81}});
  EXPECT_FALSE(broken.is_sound());
}

}  // namespace
}  // namespace swiftlet
