// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "core/localization/dead_reckoning.hpp"
#include "core/stages/estimators.hpp"

namespace swiftlet {
namespace {

constexpr TimeNs kTick = 4'000'000;

/// Circling at constant speed and turning with it: every quantity has a closed form.
struct Circling {
  double radius = 5.0, rate = 0.5;
  PoseSample pose(TimeNs t) const {
    const double angle = rate * to_seconds(t);
    PoseSample s;
    s.t = t;
    s.T_world_body = make_pose({radius * std::cos(angle), radius * std::sin(angle), 3.0},
                               Eigen::Quaterniond(Eigen::AngleAxisd(angle + M_PI / 2, Vector3::UnitZ())));
    s.v_world_mps = radius * rate * Vector3(-std::sin(angle), std::cos(angle), 0.0);
    s.omega_body_radps = {0.0, 0.0, rate};
    return s;
  }
  /// Body x along the velocity, y to the center.
  ImuSample imu(TimeNs t) const { return {t, {0.0, 0.0, rate}, {0.0, radius * rate * rate, kStandardGravity_mps2}}; }
  AgentSetup setup() const {
    AgentSetup s;
    s.T_world_body_start = pose(0).T_world_body;
    return s;
  }
};

double distance(const StateEstimate& e, const PoseSample& s) {
  return (e.T_world_body.translation() - s.T_world_body.translation()).norm();
}

TEST(GroundTruthEstimator, TellsThePoseOfThisTickAsItIs) {
  const Circling circling;
  const auto estimator = make_estimator(Module(estimator_module_types(), "ground_truth"), circling.setup());
  for (TimeNs t = kTick; t < kNsPerSecond; t += kTick) {
    Observation observation;
    observation.t = t;
    observation.pose.push_back(circling.pose(t));
    const StateEstimate& e = estimator->update(observation);
    ASSERT_TRUE(e.valid);
    ASSERT_EQ(e.t, t);
    ASSERT_EQ(e.T_world_body.matrix(), circling.pose(t).T_world_body.matrix());
    ASSERT_EQ(e.v_world_mps, circling.pose(t).v_world_mps);
    ASSERT_EQ(e.omega_body_radps, circling.pose(t).omega_body_radps);
  }
}

TEST(GroundTruthEstimator, BridgesSlowAndLatePosesByTheImu) {
  const Circling circling;
  const auto estimator = make_estimator(Module(estimator_module_types(), "ground_truth"), circling.setup());
  for (TimeNs t = kTick; t < 10 * kNsPerSecond; t += kTick) {
    Observation observation;
    observation.t = t;
    observation.imu.push_back(circling.imu(t));
    // 10 Hz, 40 ms late.
    if (t % (25 * kTick) == 10 * kTick) observation.pose.push_back(circling.pose(t - 10 * kTick));
    const StateEstimate& e = estimator->update(observation);
    if (t < kNsPerSecond / 10) continue;
    ASSERT_TRUE(e.valid);
    ASSERT_LT(distance(e, circling.pose(t)), 1e-4);
    ASSERT_LT((e.v_world_mps - circling.pose(t).v_world_mps).norm(), 1e-3);
  }
}

TEST(GroundTruthEstimator, WithoutAnImuGoesOnAtConstantVelocity) {
  const Circling circling;
  const auto estimator = make_estimator(Module(estimator_module_types(), "ground_truth"), circling.setup());
  for (TimeNs t = kTick; t < kNsPerSecond; t += kTick) {
    Observation observation;
    observation.t = t;
    if (t % (5 * kTick) == 0) observation.pose.push_back(circling.pose(t));
    const StateEstimate& e = estimator->update(observation);
    // Over at most 16 ms the circle leaves its tangent by a t^2 / 2.
    if (t <= 5 * kTick) continue;
    ASSERT_LE(distance(e, circling.pose(t)), 0.5 * 1.25 * 0.016 * 0.016 * 1.01);
  }
}

TEST(GroundTruthEstimator, IsValidFromTheStartUntilThePosesStop) {
  const Circling circling;
  const auto estimator = make_estimator(Module(estimator_module_types(), "ground_truth"), circling.setup());
  Observation observation;
  observation.t = kTick;
  EXPECT_TRUE(estimator->update(observation).valid) << "the start pose is known";
  observation.t = 400'000'000;
  EXPECT_TRUE(estimator->update(observation).valid);
  observation.t = 600'000'000;
  EXPECT_FALSE(estimator->update(observation).valid);
  EXPECT_STRNE(estimator->fault(), "");
  observation.t = 604'000'000;
  PoseSample broken = circling.pose(observation.t);
  broken.T_world_body.translation().x() = std::nan("");
  observation.pose.push_back(broken);
  EXPECT_FALSE(estimator->update(observation).valid) << "a pose that is not a number is none";
  observation.pose = {circling.pose(observation.t)};
  EXPECT_TRUE(estimator->update(observation).valid);
}

TEST(OdometryEstimator, LaysTheLocalFrameOntoTheStartAndFollowsIt) {
  const Circling circling;
  const auto estimator = make_estimator(Module(estimator_module_types(), "odometry"), circling.setup());
  const Pose T_local_world =
      make_pose({100.0, -50.0, 20.0}, Eigen::Quaterniond(Eigen::AngleAxisd(2.5, Vector3::UnitZ())));
  for (TimeNs t = 0; t < 10 * kNsPerSecond; t += kTick) {
    Observation observation;
    observation.t = t;
    observation.imu.push_back(circling.imu(t));
    if (t % (8 * kTick) == 0) {
      const PoseSample s = circling.pose(t);
      observation.odometry.push_back({t, T_local_world * s.T_world_body, T_local_world.linear() * s.v_world_mps});
    }
    const StateEstimate& e = estimator->update(observation);
    ASSERT_TRUE(e.valid);
    ASSERT_LT(distance(e, circling.pose(t)), 1e-4) << to_seconds(t);
    ASSERT_LT((e.v_world_mps - circling.pose(t).v_world_mps).norm(), 1e-3);
    ASSERT_NEAR(e.omega_body_radps.z(), circling.rate, 1e-6);
  }
}

TEST(OdometryEstimator, ItsDriftIsTheEstimatesDrift) {
  const Circling circling;
  const auto estimator = make_estimator(Module(estimator_module_types(), "odometry"), circling.setup());
  Observation observation;
  const PoseSample start = circling.pose(0);
  observation.odometry.push_back({0, start.T_world_body, start.v_world_mps});
  estimator->update(observation);
  observation.t = kTick;
  Pose drifted = circling.pose(kTick).T_world_body;
  drifted.translation() += Vector3(0.3, -0.2, 0.1);
  observation.odometry = {{kTick, drifted, start.v_world_mps}};
  const StateEstimate& e = estimator->update(observation);
  EXPECT_LT((e.T_world_body.translation() - drifted.translation()).norm(), 1e-12);
  EXPECT_GT(e.covariance(0, 0), 0.0);
}

TEST(OdometryEstimator, WithoutAnImuFindsTheBodyRateFromTheAttitudes) {
  const Circling circling;
  const auto estimator = make_estimator(Module(estimator_module_types(), "odometry"), circling.setup());
  Observation observation;
  for (TimeNs t = 0; t < 100 * kTick; t += kTick) {
    observation.t = t;
    observation.odometry = {{t, circling.pose(t).T_world_body, circling.pose(t).v_world_mps}};
    estimator->update(observation);
  }
  EXPECT_NEAR(estimator->update(observation).omega_body_radps.z(), circling.rate, 1e-6);
}

TEST(DeadReckoning, FreeFallIsHalfGTSquared) {
  DeadReckoning reckoning;
  for (int i = 1; i <= 200; ++i) reckoning.push({i * 5'000'000LL, Vector3::Zero(), Vector3::Zero()});
  EXPECT_NEAR(reckoning.at(kNsPerSecond).p_m.z(), -0.5 * kStandardGravity_mps2, 1e-9);
  EXPECT_NEAR(reckoning.at(kNsPerSecond).v_mps.z(), -kStandardGravity_mps2, 1e-9);
}

TEST(DeadReckoning, ALatePoseGivesWhatATimelyOneWouldHaveGiven) {
  const Circling circling;
  DeadReckoning timely, late;
  const PoseSample s = circling.pose(20 * kTick);
  const NavState known{s.t, s.T_world_body.translation(), s.v_world_mps, Eigen::Quaterniond(s.T_world_body.linear()),
                       s.omega_body_radps};
  for (int i = 1; i <= 100; ++i) {
    timely.push(circling.imu(i * kTick));
    late.push(circling.imu(i * kTick));
    if (i == 20) timely.restart(known);
  }
  late.restart(known);
  EXPECT_EQ(late.at(100 * kTick).p_m, timely.at(100 * kTick).p_m);
  EXPECT_EQ(late.at(100 * kTick).v_mps, timely.at(100 * kTick).v_mps);
}

TEST(DeadReckoning, RotationsByAVectorAndBackAreIdentity) {
  for (const double size : {1e-9, 1e-5, 0.01, 1.0, 3.0}) {
    const Vector3 angle = size * Vector3(0.6, -0.64, 0.48);
    const Eigen::Quaterniond q = rotation_by(angle);
    EXPECT_NEAR(q.norm(), 1.0, 1e-15);
    EXPECT_NEAR(q.angularDistance(Eigen::Quaterniond(Eigen::AngleAxisd(size, angle / size))), 0.0, 1e-8);
    EXPECT_NEAR((q * rotation_by(-angle)).w(), 1.0, 1e-15);
  }
}

}  // namespace
}  // namespace swiftlet
