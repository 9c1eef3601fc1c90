// SPDX-License-Identifier: BSD-3-Clause
// Propagation of poses by an IMU, by odometry or without either: in closed form, and up to each bound.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/stages/estimators.hpp"

namespace swiftlet {
namespace {

TEST(CarriedOn, MatchesAxisAngleForTinyRotations) {
  for (const double angle : {1e-7, 3e-5, 9.9e-5, 1.01e-4, 3e-3, 0.7, 3.1}) {
    const Vector3 axis(0.6, -0.64, 0.48);
    const Eigen::Quaterniond q = rotation_by(angle * axis);
    EXPECT_NEAR(q.w(), std::cos(0.5 * angle), 1e-15) << angle;
    EXPECT_LT((q.vec() - std::sin(0.5 * angle) * axis).norm(), angle < 1e-4 ? 3e-14 : 1e-15) << angle;
  }
}

TEST(CarriedOn, RotatesForceHalfwayAndBodyFully) {
  NavState state;
  state.p_m = {1, 2, 3};
  state.v_mps = {0.5, -1.0, 2.0};
  state.q = rotation_by({0.1, 0.2, 0.3});
  const Vector3 omega(0.4, -0.3, 1.5), force(2.0, 1.0, 12.0);
  constexpr double kDt_s = 0.2;
  const Matrix3 R = state.q.toRotationMatrix(),
                half = Matrix3(Eigen::AngleAxisd(0.5 * kDt_s * omega.norm(), omega.normalized()));
  const Vector3 a = R * half * force - Vector3(0, 0, kStandardGravity_mps2);
  const Vector3 p = state.p_m + kDt_s * state.v_mps + 0.5 * kDt_s * kDt_s * a, v = state.v_mps + kDt_s * a;
  strapdown(state, omega, force, kDt_s);
  EXPECT_LT((state.p_m - p).norm() + (state.v_mps - v).norm(), 1e-12);
  EXPECT_LT((state.q.toRotationMatrix() - R * half * half).norm(), 1e-12);
  EXPECT_EQ(state.omega_body_radps, omega);
}

constexpr TimeNs kReckonTick = 10'000'000;

ImuSample pushed(int i, double a_mps2 = 0.0, double omega_radps = 0.0) {
  return {i * kReckonTick, {0, 0, omega_radps}, {a_mps2, 0, kStandardGravity_mps2}};
}

TEST(CarriedOn, ExtrapolatesFromTheLastSample) {
  DeadReckoning reckoning;
  NavState start;
  start.v_mps = {1, 0, 0};
  reckoning.restart(start);
  reckoning.push(pushed(1, 2.0));
  reckoning.push(pushed(2, 2.0));
  EXPECT_EQ(reckoning.latest(), 2 * kReckonTick);
  for (const int ms : {0, 5, 40}) {
    const double t_s = 0.02 + 0.001 * ms;
    const NavState now = reckoning.at(from_seconds(t_s));
    EXPECT_NEAR(now.v_mps.x(), 1.0 + 2.0 * t_s, 1e-12);
    EXPECT_NEAR(now.p_m.x(), t_s + t_s * t_s, 1e-12);
    EXPECT_EQ(now.t, from_seconds(t_s));
  }
  EXPECT_EQ(reckoning.at(kReckonTick).t, 2 * kReckonTick) << "it does not go back";
  // A sample that comes late, twice or is no number is none.
  reckoning.push(pushed(2, 100.0));
  reckoning.push(pushed(1, 100.0));
  ImuSample bad = pushed(3);
  bad.omega_body_radps.x() = std::nan("");
  reckoning.push(bad);
  bad = pushed(3);
  bad.specific_force_body_mps2.y() = std::nan("");
  reckoning.push(bad);
  EXPECT_NEAR(reckoning.at(3 * kReckonTick).v_mps.x(), 1.06, 1e-12);
}

TEST(CarriedOn, ExtrapolatesConstantMotionWithoutSamples) {
  DeadReckoning reckoning;
  NavState start;
  start.t = 1'000'000'000;
  start.p_m = {1, 2, 3};
  start.v_mps = {4, 0, -1};
  start.omega_body_radps = {0, 0, 0.6};
  reckoning.restart(start);
  const NavState now = reckoning.at(1'500'000'000);
  EXPECT_LT((now.p_m - Vector3(3, 2, 2.5)).norm(), 1e-12);
  EXPECT_NEAR(yaw_of(now.q.toRotationMatrix()), 0.3, 1e-12);
  EXPECT_EQ(now.v_mps, start.v_mps);
  EXPECT_EQ(reckoning.at(900'000'000).p_m, start.p_m);
}

TEST(CarriedOn, AppliesKeptSamplesAfterTheRestart) {
  DeadReckoning reckoning;
  reckoning.push(pushed(1));
  for (int i = 2; i <= 6; ++i) reckoning.keep(pushed(i, 3.0));
  NavState known;
  known.t = 3 * kReckonTick;
  reckoning.restart(known);
  EXPECT_NEAR(reckoning.at(6 * kReckonTick).v_mps.x(), 0.09, 1e-12);
}

// ---- estimators, up to their bounds

using Told = std::function<void(Observation&)>;

struct ToldEstimator {
  std::unique_ptr<StateEstimator> estimator;
  Outbox outbox;
  TimeNs t = 0;
  ToldEstimator(const char* type, const AgentSetup& setup = {})
      : estimator(make_estimator(Module(estimator_module_types(), type), setup)) {}
  const StateEstimate& at(TimeNs when, const Told& change = {}) {
    Observation observation;
    observation.t = t = when;
    if (change) change(observation);
    return estimator->update(observation, outbox);
  }
};

OdometrySample odometry_of(TimeNs t, const Pose& T, const Vector3& v_mps = Vector3::Zero()) { return {t, T, v_mps}; }

TEST(CarriedOn, HoldsPosesAndOdometryOnlyBriefly) {
  for (const char* type : {"ground_truth", "odometry"}) {
    ToldEstimator told(type);
    const TimeNs begin = 40'000'000;
    told.at(begin, [](Observation& o) {
      o.pose.push_back({o.t, Pose::Identity(), Vector3::Zero(), Vector3::Zero()});
      o.odometry.push_back(odometry_of(o.t, Pose::Identity()));
    });
    EXPECT_TRUE(told.at(begin + 500'000'000).valid) << type;
    EXPECT_STREQ(told.estimator->fault(), "");
    EXPECT_FALSE(told.at(begin + 500'000'001).valid) << type;
    EXPECT_STRNE(told.estimator->fault(), "");
  }
}

TEST(CarriedOn, GrowsOdometryUncertaintyWithDistance) {
  ToldEstimator told("odometry");
  double way_m = 0.0;
  Vector3 p_m = Vector3::Zero();
  told.at(4'000'000, [&](Observation& o) { o.odometry.push_back(odometry_of(o.t, Pose::Identity())); });
  for (int i = 2; i <= 30; ++i) {
    const Vector3 step_m(0.4, 0.3 * (i % 3 - 1), 0.0);
    p_m += step_m;
    way_m += step_m.norm();
    const StateEstimate& e = told.at(i * 4'000'000, [&](Observation& o) {
      o.odometry.push_back(odometry_of(o.t, make_pose(p_m, Eigen::Quaterniond::Identity())));
    });
    Matrix6 expected = Matrix6::Zero();
    expected.diagonal().head<3>().setConstant(std::pow(0.01 * way_m, 2));
    expected(5, 5) = std::pow(0.02 * kRadPerDeg * way_m, 2);
    ASSERT_LT((e.covariance - expected).norm(), 1e-12) << i;
  }
}

TEST(CarriedOn, RejectsBadOdometryAndUnwrapsTurns) {
  ToldEstimator told("odometry");
  const auto turned = [](double yaw_rad) {
    return make_pose({1, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ())));
  };
  told.at(100'000'000, [&](Observation& o) { o.odometry.push_back(odometry_of(o.t, turned(3.0))); });
  const StateEstimate& e =
      told.at(200'000'000, [&](Observation& o) { o.odometry.push_back(odometry_of(o.t, turned(-3.0))); });
  EXPECT_NEAR(e.omega_body_radps.z(), (2.0 * kPi - 6.0) / 0.1, 1e-6);
  const Vector3 before_m = e.T_local_body.translation();
  told.at(200'000'000, [&](Observation& o) {
    OdometrySample old = odometry_of(150'000'000, make_pose({50, 0, 0}, Eigen::Quaterniond::Identity()));
    OdometrySample bad = odometry_of(300'000'000, make_pose({std::nan(""), 0, 0}, Eigen::Quaterniond::Identity()));
    o.odometry = {old, bad};
  });
  EXPECT_LT((e.T_local_body.translation() - before_m).norm(), 1e-9);
}

TEST(CarriedOn, TakesHeadingFromFirstValidCompass) {
  AgentSetup setup;
  setup.start_known = StartKnown::kPosition;
  setup.T_local_body_start = make_pose({4, 5, 6}, rotation_by({0, 0, 0.4}));
  ToldEstimator told("odometry", setup);
  const StateEstimate& e = told.at(4'000'000, [](Observation& o) {
    o.odometry.push_back(odometry_of(o.t, make_pose({9, 9, 9}, rotation_by({0, 0, -2.0}))));
    o.compass = {{o.t, std::nan(""), 0.1}, {o.t, 1.5, 0.1}, {o.t, 2.5, 0.1}};
  });
  EXPECT_EQ(e.correction_revision, 1U);
  EXPECT_NEAR(yaw_of(e.T_local_body.linear()), 0.4, 1e-9) << "laid onto the start";
  EXPECT_NEAR(yaw_of(e.T_world_body().linear()), 1.5, 1e-9);
  EXPECT_LT((e.T_world_body().translation() - Vector3(4, 5, 6)).norm(), 1e-9);
}

TEST(CarriedOn, AlignsUnknownStartByExternalPose) {
  AgentSetup setup;
  setup.start_known = StartKnown::kNothing;
  setup.T_local_body_start = make_pose({1, 1, 0}, rotation_by({0, 0, 0.3}));
  ToldEstimator told("ground_truth", setup);
  const Pose T = make_pose({10, 20, 30}, rotation_by({0, 0, 2.0}));
  const StateEstimate& e = told.at(4'000'000, [&](Observation& o) {
    o.pose.push_back({o.t, T, {1, 0, 0}, Vector3::Zero()});
  });
  EXPECT_LT((e.T_local_body.matrix() - setup.T_local_body_start.matrix()).norm(), 1e-9);
  EXPECT_LT((e.T_world_body().matrix() - T.matrix()).norm(), 1e-9);
  EXPECT_LT((e.v_world_mps() - Vector3(1, 0, 0)).norm(), 1e-9);
  // An older pose is passed over.
  told.at(4'000'000, [&](Observation& o) {
    o.pose.push_back({3'000'000, Pose::Identity(), Vector3::Zero(), Vector3::Zero()});
  });
  EXPECT_LT((e.T_world_body().matrix() - T.matrix()).norm(), 1e-9);
}

// ---- from frame to frame

TEST(CarriedOn, RotatesTracksAndDetectionsWithFrame) {
  StateEstimate estimate;
  estimate.correct(make_pose({5, -3, 2}, rotation_by({0, 0, 2.0})));
  const FrameChange change = FrameChange::to_world(estimate);
  const Matrix3 R = estimate.T_world_local.linear();
  Track track;
  track.position_m = {1, 2, 3};
  track.velocity_mps = {4, 5, 6};
  track.acceleration_mps2 = {0.5, 1, 0};
  track.measured_m = {7, 8, 9};
  track.measured_covariance = Vector3(1, 2, 3).asDiagonal();
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j < 9; ++j) track.covariance(i, j) = 1.0 / (1.0 + i + j);
  }
  const Track there = change.track(track);
  EXPECT_LT((there.velocity_mps - R * track.velocity_mps).norm(), 1e-12);
  EXPECT_LT((there.acceleration_mps2 - R * track.acceleration_mps2).norm(), 1e-12);
  EXPECT_LT((there.measured_m - estimate.T_world_local * track.measured_m).norm(), 1e-12);
  EXPECT_LT((there.measured_covariance - R * track.measured_covariance * R.transpose()).norm(), 1e-12);
  for (int i = 0; i < 9; i += 3) {
    for (int j = 0; j < 9; j += 3) {
      const Matrix3 part = track.covariance.block<3, 3>(i, j);
      EXPECT_LT((Matrix3(there.covariance.block<3, 3>(i, j)) - R * part * R.transpose()).norm(), 1e-12);
    }
  }
  Detection detection;
  detection.position_m = {1, 0, 0};
  detection.covariance = Vector3(3, 2, 1).asDiagonal();
  EXPECT_LT((change.detection(detection).position_m - estimate.T_world_local * detection.position_m).norm(), 1e-12);
  EXPECT_LT((change.detection(detection).covariance - R * detection.covariance * R.transpose()).norm(), 1e-12);
  RelativeEstimate relative;
  relative.position_m = {1, 2, 3};
  relative.velocity_mps = {1, 0, 2};
  relative.yaw_rad = 3.0;
  relative.heard_position_m = {3, 2, 1};
  relative.heard_yaw_rad = 0.5;
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 7; ++j) relative.covariance(i, j) = 1.0 / (1.0 + i + j);
  }
  const RelativeEstimate carried = change.relative(relative);
  EXPECT_LT((carried.position_m - estimate.T_world_local * relative.position_m).norm(), 1e-12);
  EXPECT_LT((carried.velocity_mps - R * relative.velocity_mps).norm(), 1e-12);
  EXPECT_NEAR(carried.yaw_rad, 5.0 - 2.0 * kPi, 1e-12);
  EXPECT_LT((carried.heard_position_m - estimate.T_world_local * relative.heard_position_m).norm(), 1e-12);
  EXPECT_NEAR(carried.heard_yaw_rad, 2.5, 1e-12);
  for (int i = 0; i < 6; i += 3) {
    const Matrix3 part = relative.covariance.block<3, 3>(i, i);
    EXPECT_LT((Matrix3(carried.covariance.block<3, 3>(i, i)) - R * part * R.transpose()).norm(), 1e-12);
    const Vector3 with_yaw = relative.covariance.block<3, 1>(i, 6);
    EXPECT_LT((Vector3(carried.covariance.block<3, 1>(i, 6)) - R * with_yaw).norm(), 1e-12);
  }
  EXPECT_NEAR(carried.covariance(6, 6), relative.covariance(6, 6), 1e-12);
  Overlay overlay;
  overlay.positions = {{1, 2, 3}};
  change.carry(overlay);
  EXPECT_LT((overlay.positions[0].cast<double>() - estimate.T_world_local * Vector3(1, 2, 3)).norm(), 1e-5);
  // A level alignment takes one point onto the other.
  const Pose T = level_alignment(0.7, {1, 2, 3}, {-4, 5, 6});
  EXPECT_LT((T * Vector3(-4, 5, 6) - Vector3(1, 2, 3)).norm(), 1e-12);
  EXPECT_NEAR(yaw_of(T.linear()), 0.7, 1e-12);
}

// ---- clouds

StateEstimate on_way(TimeNs t) {
  StateEstimate estimate;
  estimate.t = t;
  estimate.valid = true;
  estimate.T_local_body = make_pose({3.0 * to_seconds(t), 0, 0}, rotation_by({0, 0, to_seconds(t)}));
  return estimate;
}

TEST(CarriedOn, KeepsOuterReturnsFollowingExternalPoses) {
  CloudRegistrar registrar(0.5);
  registrar.push(on_way(0));
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 2;
  beams->cols = 3;
  beams->column_offset_s = {0.0F, 0.05F, 0.1F};
  auto scan = std::make_shared<Scan>();
  scan->stamp = 1'000'000'000;
  scan->duration = 100'000'000;
  scan->T_body_lidar = make_pose({0.1, 0, 0}, Eigen::Quaterniond::Identity());
  for (int i = 0; i < 6; ++i) {
    beams->directions_lidar.push_back(Eigen::Vector3f::UnitX());
    beams->origins_lidar.push_back(Eigen::Vector3f::Zero());
    scan->range_m.push_back(i == 1 ? 0.399F : i == 4 ? 0.401F : 5.0F);
  }
  scan->beams = beams;
  for (const TimeNs t : {1'000'000'000LL, 1'040'000'000LL, 1'080'000'000LL, 1'200'000'000LL}) {
    scan->external_poses.push_back({t, on_way(t).T_local_body});
  }
  LocalCloud cloud;
  ASSERT_TRUE(registrar.make(scan, cloud));
  EXPECT_EQ(cloud.beam, (std::vector<std::uint32_t>{0, 2, 3, 4, 5}));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto beam = static_cast<int>(cloud.beam[i]);
    const TimeNs fired = scan->time_of(beam);
    const Vector3 expected = on_way(fired).T_local_body * scan->T_body_lidar * scan->point_lidar(beam).cast<double>();
    EXPECT_LT((cloud.points_local_m[i].cast<double>() - expected).norm(), 2e-3) << i;
  }
  EXPECT_EQ(cloud.reflectivity_of(0), 0.0F);
}

TEST(CarriedOn, ReusesReleasedClouds) {
  CloudRegistrar registrar(0.5);
  auto beams = std::make_shared<BeamTable>();
  beams->rows = beams->cols = 1;
  beams->directions_lidar = {Eigen::Vector3f::UnitX()};
  beams->origins_lidar = {Eigen::Vector3f::Zero()};
  beams->column_offset_s = {0.0F};
  const auto scan = [&] {
    auto made = std::make_shared<Scan>();
    made->beams = beams;
    made->range_m = {3.0F};
    return made;
  };
  LocalCloudPool pool;
  EXPECT_EQ(pool.make(scan(), registrar), nullptr) << "no pose is known";
  registrar.push(on_way(0));
  auto first = pool.make(scan(), registrar);
  auto second = pool.make(scan(), registrar);
  EXPECT_NE(first, second);
  const LocalCloud* used = first.get();
  const std::weak_ptr<const Scan> its_scan = first->scan;
  first.reset();
  const auto third = pool.make(scan(), registrar);
  EXPECT_EQ(third.get(), used);
  EXPECT_TRUE(its_scan.expired()) << "the sensor has its memory back";
  EXPECT_EQ(second->size(), 1U) << "who is held stays";
}

}  // namespace
}  // namespace swiftlet
