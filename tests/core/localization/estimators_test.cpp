// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/stage_tables/estimators.hpp"

namespace swiftlet {
namespace {

Outbox outbox;  // estimators send nothing

constexpr TimeNs kTick = 4'000'000;

/// Circling at constant speed with the heading turning along: every quantity has a closed form.
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
  ImuSample imu(TimeNs t) const { return {t, {0.0, 0.0, rate}, {0.0, radius * rate * rate, kGravity_mps2}}; }
  AgentSetup setup() const {
    AgentSetup s;
    s.T_local_body_start = pose(0).T_world_body;
    return s;
  }
};

double distance(const StateEstimate& e, const PoseSample& s) {
  return (e.T_local_body.translation() - s.T_world_body.translation()).norm();
}

TEST(GroundTruthEstimator, ReportsThePoseOfItsTick) {
  const Circling circling;
  const auto estimator = make_estimator(Module(estimator_module_types(), "ground_truth"), circling.setup());
  for (TimeNs t = kTick; t < kNsPerSecond; t += kTick) {
    Observation observation;
    observation.t = t;
    observation.pose.push_back(circling.pose(t));
    const StateEstimate& e = estimator->update(observation, outbox);
    ASSERT_TRUE(e.valid);
    ASSERT_EQ(e.t, t);
    ASSERT_EQ(e.T_local_body.matrix(), circling.pose(t).T_world_body.matrix());
    ASSERT_EQ(e.v_local_mps, circling.pose(t).v_world_mps);
    ASSERT_EQ(e.omega_body_radps, circling.pose(t).omega_body_radps);
  }
}

TEST(GroundTruthEstimator, BridgesSparseDelayedPosesByImu) {
  const Circling circling;
  const auto estimator = make_estimator(Module(estimator_module_types(), "ground_truth"), circling.setup());
  for (TimeNs t = kTick; t < 10 * kNsPerSecond; t += kTick) {
    Observation observation;
    observation.t = t;
    observation.imu.push_back(circling.imu(t));
    // 10 Hz, 40 ms late.
    if (t % (25 * kTick) == 10 * kTick) observation.pose.push_back(circling.pose(t - 10 * kTick));
    const StateEstimate& e = estimator->update(observation, outbox);
    if (t < kNsPerSecond / 10) continue;
    ASSERT_TRUE(e.valid);
    ASSERT_LT(distance(e, circling.pose(t)), 1e-4);
    ASSERT_LT((e.v_local_mps - circling.pose(t).v_world_mps).norm(), 1e-3);
  }
}

TEST(GroundTruthEstimator, ExtrapolatesAtConstantVelocityWithoutImu) {
  const Circling circling;
  const auto estimator = make_estimator(Module(estimator_module_types(), "ground_truth"), circling.setup());
  for (TimeNs t = kTick; t < kNsPerSecond; t += kTick) {
    Observation observation;
    observation.t = t;
    if (t % (5 * kTick) == 0) observation.pose.push_back(circling.pose(t));
    const StateEstimate& e = estimator->update(observation, outbox);
    // Over at most 16 ms the circle leaves its tangent by a t^2 / 2.
    if (t <= 5 * kTick) continue;
    ASSERT_LE(distance(e, circling.pose(t)), 0.5 * 1.25 * 0.016 * 0.016 * 1.01);
  }
}

/// Setup with the start of the circle known to the given extent.
AgentSetup setup_of(const Circling& circling, StartKnown known) {
  AgentSetup setup = circling.setup();
  setup.start_known = known;
  if (known != StartKnown::kPose) setup.T_local_body_start.linear().setIdentity();
  if (known == StartKnown::kNothing) setup.T_local_body_start.translation().setZero();
  return setup;
}

TEST(GroundTruthEstimator, LearnsTheWorldFromFirstPose) {
  const Circling circling;
  const auto estimator =
      make_estimator(Module(estimator_module_types(), "ground_truth"), setup_of(circling, StartKnown::kNothing));
  Observation observation;
  const StateEstimate& e = estimator->update(observation, outbox);
  EXPECT_EQ(e.T_local_body.matrix(), Pose::Identity().matrix());
  EXPECT_EQ(e.correction_revision, 0U);
  for (TimeNs t = kTick; t < kNsPerSecond; t += kTick) {
    observation.t = t;
    observation.pose = {circling.pose(t)};
    estimator->update(observation, outbox);
    ASSERT_EQ(e.correction_revision, 1U);
    ASSERT_LT((e.T_world_body().translation() - circling.pose(t).T_world_body.translation()).norm(), 1e-9);
    ASSERT_LT((e.v_world_mps() - circling.pose(t).v_world_mps).norm(), 1e-9);
  }
  // The motion is ahead and to the left in the start frame.
  EXPECT_GT(e.T_local_body.translation().x(), 2.0);
  EXPECT_GT(e.T_local_body.translation().y(), 0.2);
}

TEST(OdometryEstimator, TakesUnknownHeadingFromTheCompass) {
  const Circling circling;
  for (const bool compass : {false, true}) {
    const auto estimator =
        make_estimator(Module(estimator_module_types(), "odometry"), setup_of(circling, StartKnown::kPosition));
    const StateEstimate* e = nullptr;
    for (TimeNs t = 0; t < kNsPerSecond; t += kTick) {
      Observation observation;
      observation.t = t;
      const PoseSample s = circling.pose(t);
      observation.odometry = {{t, s.T_world_body, s.v_world_mps}};
      if (compass) observation.compass = {{t, std::nan(""), 0.02}};
      if (compass && t >= 10 * kTick) observation.compass.push_back({t, yaw_of(s.T_world_body.linear()), 0.02});
      e = &estimator->update(observation, outbox);
      EXPECT_LE((e->T_local_body.translation() - circling.pose(0).T_world_body.translation()).norm(),
                1e-9 + 2.51 * to_seconds(t));
    }
    const PoseSample end = circling.pose(e->t);
    const double error_m = (e->T_world_body().translation() - end.T_world_body.translation()).norm();
    EXPECT_EQ(e->correction_revision, compass ? 1U : 0U);
    EXPECT_EQ(error_m < 1e-3, compass) << error_m << " m: without a compass its heading is arbitrary";
  }
}

TEST(InsEstimator, FindsStartHeadingFromLateCompass) {
  AgentSetup setup;
  setup.start_known = StartKnown::kNothing;
  const auto estimator = make_estimator(Module(estimator_module_types(), "ins"), setup);
  constexpr double kTurnRate_radps = 0.8, kCompass_rad = 2.0;
  const StateEstimate* e = nullptr;
  Observation observation;
  for (TimeNs t = kTick; t <= kNsPerSecond; t += kTick) {
    observation.clear();
    observation.t = t;
    observation.imu = {{t, kTurnRate_radps * Vector3::UnitZ(), kGravity_mps2 * Vector3::UnitZ()}};
    if (t == kNsPerSecond) observation.compass = {{t, kCompass_rad, 0.02}};
    e = &estimator->update(observation, outbox);
  }
  EXPECT_NEAR(yaw_of(e->T_world_body().linear()), kCompass_rad, 1e-6);
  EXPECT_NEAR(yaw_of(e->T_local_body.linear()), kTurnRate_radps, 0.01) << "local headings count from the start";
}

TEST(InsEstimator, FindsStartFromCompassAndGnss) {
  const Circling circling;
  const auto estimator =
      make_estimator(Module(estimator_module_types(), "ins"), setup_of(circling, StartKnown::kNothing));
  // The filter takes the vehicle to be at rest at the start: it stands for two seconds, then the circle begins slowly.
  const PoseSample start = circling.pose(0);
  Observation observation;
  const StateEstimate* e = nullptr;
  for (TimeNs t = kTick; t < 4 * kNsPerSecond; t += kTick) {
    observation.clear();
    observation.t = t;
    observation.imu = {{t, Vector3::Zero(), kGravity_mps2 * Vector3::UnitZ()}};
    if (t % (25 * kTick) == 0) {
      observation.gnss = {
          {t, start.T_world_body.translation(), Vector3::Zero(), Vector3::Constant(0.1), Vector3::Constant(0.05)}};
    }
    if (t >= kNsPerSecond && t % (10 * kTick) == 0) {
      observation.compass = {{t, yaw_of(start.T_world_body.linear()), 0.02}};
    }
    e = &estimator->update(observation, outbox);
    ASSERT_TRUE(t >= kNsPerSecond || e->correction_revision == 0) << "a position needs a heading";
    ASSERT_TRUE(e->valid) << estimator->fault();
  }
  EXPECT_EQ(e->correction_revision, 2U);
  EXPECT_LT(e->T_local_body.translation().norm(), 0.1) << "the local frame does not jump";
  EXPECT_LT((e->T_world_body().translation() - start.T_world_body.translation()).norm(), 0.1);
  EXPECT_NEAR(yaw_of(e->T_world_body().linear()), yaw_of(start.T_world_body.linear()), 0.02);
}

// A covariance that is the outer product of velocities stays one, so it rotates like the velocities.
TEST(FrameChange, RotatesValuesAndRestoresThem) {
  StateEstimate estimate;
  EXPECT_EQ(FrameChange::to_world(estimate).point({1, -0.0, 3}), Vector3(1, -0.0, 3));
  estimate.correct(make_pose({5, -3, 2}, Eigen::Quaterniond(Eigen::AngleAxisd(2.0, Vector3::UnitZ()))));
  estimate.correct(estimate.T_world_local);
  EXPECT_EQ(estimate.correction_revision, 1U) << "an equal correction is none";
  const FrameChange to_world = FrameChange::to_world(estimate), to_local = FrameChange::to_local(estimate);
  const Vector3 p_m(1, 2, 3), p_world_m = estimate.T_world_local * p_m;
  Track track;
  track.position_m = track.measured_m = p_m;
  track.velocity_mps = {4, 5, 6};
  track.acceleration_mps2 = {0.5, 1, 0};
  const auto state_of = [](const Track& t) {
    Eigen::Matrix<double, 9, 1> x;
    x << t.velocity_mps, t.velocity_mps, t.acceleration_mps2;
    return x;
  };
  track.covariance = state_of(track) * state_of(track).transpose();
  track.measured_covariance = track.velocity_mps * track.velocity_mps.transpose();
  const Track there = to_world.track(track);
  EXPECT_LT((there.position_m - p_world_m).norm() + (there.measured_m - p_world_m).norm(), 1e-12);
  EXPECT_LT((there.velocity_mps - estimate.T_world_local.linear() * track.velocity_mps).norm(), 1e-12);
  EXPECT_LT((there.covariance - state_of(there) * state_of(there).transpose()).norm(), 1e-10);
  EXPECT_LT((there.measured_covariance - there.velocity_mps * there.velocity_mps.transpose()).norm(), 1e-10);
  const Track back = to_local.track(there);
  EXPECT_LT((back.position_m - track.position_m).norm(), 1e-12);
  EXPECT_LT((back.velocity_mps - track.velocity_mps).norm(), 1e-12);
  EXPECT_LT((back.covariance - track.covariance).norm(), 1e-10);
  Detection detection;
  detection.position_m = p_m;
  detection.covariance = track.measured_covariance;
  EXPECT_LT((to_world.detection(detection).position_m - p_world_m).norm(), 1e-12);
  EXPECT_LT((to_world.detection(detection).covariance - there.measured_covariance).norm(), 1e-10);
  RelativeEstimate relative;
  relative.position_m = relative.report_position_m = p_m;
  relative.velocity_mps = track.velocity_mps;
  relative.yaw_rad = relative.report_yaw_rad = 3.0;
  const auto relative_state_of = [](const RelativeEstimate& e) {
    Eigen::Matrix<double, 7, 1> x;
    x << e.velocity_mps, e.velocity_mps, 1.0;
    return x;
  };
  relative.covariance = relative_state_of(relative) * relative_state_of(relative).transpose();
  const RelativeEstimate carried = to_world.relative(relative);
  EXPECT_LT((carried.position_m - p_world_m).norm() + (carried.report_position_m - p_world_m).norm(), 1e-12);
  EXPECT_LT((carried.velocity_mps - there.velocity_mps).norm(), 1e-12);
  EXPECT_NEAR(carried.yaw_rad, 5.0 - 2.0 * M_PI, 1e-12);
  EXPECT_NEAR(carried.report_yaw_rad, 5.0 - 2.0 * M_PI, 1e-12);
  EXPECT_LT((carried.covariance - relative_state_of(carried) * relative_state_of(carried).transpose()).norm(), 1e-10);
  Reference reference;
  reference.position_m = p_m;
  reference.velocity_mps = {1, 0, 0};
  reference.yaw_rad = 3.0;
  EXPECT_NEAR(to_world.reference(reference).yaw_rad, 5.0 - 2.0 * M_PI, 1e-12);
  EXPECT_NEAR(to_local.reference(to_world.reference(reference)).yaw_rad, 3.0, 1e-12);
  EXPECT_NEAR(to_world.height(1.0), 3.0, 1e-12);
  const Pose T = level_alignment(0.7, {1, 2, 3}, {-4, 5, 6});
  EXPECT_LT((T * Vector3(-4, 5, 6) - Vector3(1, 2, 3)).norm(), 1e-12);
  EXPECT_NEAR(yaw_of(T.linear()), 0.7, 1e-12);
}

TEST(OdometryEstimator, AlignsLocalFrameWithTheStart) {
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
    const StateEstimate& e = estimator->update(observation, outbox);
    ASSERT_TRUE(e.valid);
    ASSERT_LT(distance(e, circling.pose(t)), 1e-4) << to_seconds(t);
    ASSERT_LT((e.v_local_mps - circling.pose(t).v_world_mps).norm(), 1e-3);
    ASSERT_NEAR(e.omega_body_radps.z(), circling.rate, 1e-6);
  }
}

TEST(OdometryEstimator, FollowsTheDriftOfOdometry) {
  const Circling circling;
  const auto estimator = make_estimator(Module(estimator_module_types(), "odometry"), circling.setup());
  Observation observation;
  const PoseSample start = circling.pose(0);
  observation.odometry.push_back({0, start.T_world_body, start.v_world_mps});
  estimator->update(observation, outbox);
  observation.t = kTick;
  Pose drifted = circling.pose(kTick).T_world_body;
  drifted.translation() += Vector3(0.3, -0.2, 0.1);
  observation.odometry = {{kTick, drifted, start.v_world_mps}};
  const StateEstimate& e = estimator->update(observation, outbox);
  EXPECT_LT((e.T_local_body.translation() - drifted.translation()).norm(), 1e-12);
  EXPECT_GT(e.covariance(0, 0), 0.0);
}

TEST(OdometryEstimator, FindsTheBodyRateWithoutImu) {
  const Circling circling;
  const auto estimator = make_estimator(Module(estimator_module_types(), "odometry"), circling.setup());
  Observation observation;
  for (TimeNs t = 0; t < 100 * kTick; t += kTick) {
    observation.t = t;
    observation.odometry = {{t, circling.pose(t).T_world_body, circling.pose(t).v_world_mps}};
    estimator->update(observation, outbox);
  }
  EXPECT_NEAR(estimator->update(observation, outbox).omega_body_radps.z(), circling.rate, 1e-6);
}

}  // namespace
}  // namespace swiftlet
