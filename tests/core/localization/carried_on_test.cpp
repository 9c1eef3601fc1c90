// SPDX-License-Identifier: BSD-3-Clause
// Propagation of poses by an IMU, by odometry or without either.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/stage_tables/estimators.hpp"

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
  const Vector3 a = R * half * force - Vector3(0, 0, kGravity_mps2);
  const Vector3 p = state.p_m + kDt_s * state.v_mps + 0.5 * kDt_s * kDt_s * a, v = state.v_mps + kDt_s * a;
  strapdown(state, omega, force, kDt_s);
  EXPECT_LT((state.p_m - p).norm() + (state.v_mps - v).norm(), 1e-12);
  EXPECT_LT((state.q.toRotationMatrix() - R * half * half).norm(), 1e-12);
  EXPECT_EQ(state.omega_body_radps, omega);
}

constexpr TimeNs kReckonTick = 10'000'000;

ImuSample pushed(int i, double a_mps2 = 0.0, double omega_radps = 0.0) {
  return {i * kReckonTick, {0, 0, omega_radps}, {a_mps2, 0, kGravity_mps2}};
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
  EXPECT_EQ(reckoning.at(kReckonTick).t, 2 * kReckonTick) << "never back";
  // Late, repeated and non-finite samples are ignored.
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

using Change = std::function<void(Observation&)>;

struct ScriptedEstimator {
  std::unique_ptr<StateEstimator> estimator;
  Outbox outbox;
  TimeNs t = 0;
  ScriptedEstimator(const char* type, const AgentSetup& setup = {})
      : estimator(make_estimator(Module(estimator_module_types(), type), setup)) {}
  const StateEstimate& at(TimeNs when, const Change& change = {}) {
    Observation observation;
    observation.t = t = when;
    if (change) change(observation);
    return estimator->update(observation, outbox);
  }
};

OdometrySample odometry_of(TimeNs t, const Pose& T, const Vector3& v_mps = Vector3::Zero()) { return {t, T, v_mps}; }

TEST(CarriedOn, IsInvalidWhileMeasurementsAreMissing) {
  for (const char* type : {"ground_truth", "odometry"}) {
    ScriptedEstimator run(type);
    const auto measure = [](double x_m) {
      return [x_m](Observation& o) {
        const Pose T = make_pose({x_m, 0, 0}, Eigen::Quaterniond::Identity());
        o.pose.push_back({o.t, T, Vector3::Zero(), Vector3::Zero()});
        o.odometry.push_back(odometry_of(o.t, T));
      };
    };
    const TimeNs begin = 40'000'000;
    EXPECT_TRUE(run.at(begin, measure(0.0)).valid) << type;
    EXPECT_TRUE(run.at(begin + 400'000'000).valid) << type;
    EXPECT_STREQ(run.estimator->fault(), "");
    EXPECT_FALSE(run.at(begin + 600'000'000).valid) << type;
    EXPECT_STRNE(run.estimator->fault(), "");
    EXPECT_FALSE(run.at(begin + 604'000'000, measure(std::nan(""))).valid) << type << ": not finite";
    EXPECT_TRUE(run.at(begin + 608'000'000, measure(0.0)).valid) << type;
  }
}

TEST(CarriedOn, GrowsOdometryUncertaintyWithDistance) {
  ScriptedEstimator run("odometry");
  double path_m = 0.0, last_rate = 0.0, last_yaw_rate = 0.0;
  Vector3 p_m = Vector3::Zero();
  run.at(4'000'000, [&](Observation& o) { o.odometry.push_back(odometry_of(o.t, Pose::Identity())); });
  for (int i = 2; i <= 30; ++i) {
    const Vector3 step_m(0.4, 0.3 * (i % 3 - 1), 0.0);
    p_m += step_m;
    path_m += step_m.norm();
    const StateEstimate& e = run.at(i * 4'000'000, [&](Observation& o) {
      o.odometry.push_back(odometry_of(o.t, make_pose(p_m, Eigen::Quaterniond::Identity())));
    });
    const double rate = std::sqrt(e.covariance(0, 0)) / path_m, yaw_rate = std::sqrt(e.covariance(5, 5)) / path_m;
    ASSERT_NEAR(rate, i == 2 ? rate : last_rate, 1e-12) << i;
    ASSERT_NEAR(yaw_rate, i == 2 ? yaw_rate : last_yaw_rate, 1e-12) << i;
    last_rate = rate;
    last_yaw_rate = yaw_rate;
  }
  EXPECT_GT(std::min(last_rate, last_yaw_rate), 0.0);
}

TEST(CarriedOn, RejectsBadOdometryAndUnwrapsTurns) {
  ScriptedEstimator run("odometry");
  const auto turned = [](double yaw_rad) {
    return make_pose({1, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ())));
  };
  run.at(100'000'000, [&](Observation& o) { o.odometry.push_back(odometry_of(o.t, turned(3.0))); });
  const StateEstimate& e =
      run.at(200'000'000, [&](Observation& o) { o.odometry.push_back(odometry_of(o.t, turned(-3.0))); });
  EXPECT_NEAR(e.omega_body_radps.z(), (2.0 * kPi - 6.0) / 0.1, 1e-6);
  const Vector3 before_m = e.T_local_body.translation();
  run.at(200'000'000, [&](Observation& o) {
    OdometrySample old = odometry_of(150'000'000, make_pose({50, 0, 0}, Eigen::Quaterniond::Identity()));
    OdometrySample bad = odometry_of(300'000'000, make_pose({std::nan(""), 0, 0}, Eigen::Quaterniond::Identity()));
    o.odometry = {old, bad};
  });
  EXPECT_LT((e.T_local_body.translation() - before_m).norm(), 1e-9);
}

StateEstimate on_way(TimeNs t) {
  StateEstimate estimate;
  estimate.t = t;
  estimate.valid = true;
  estimate.T_local_body = make_pose({3.0 * to_seconds(t), 0, 0}, rotation_by({0, 0, to_seconds(t)}));
  return estimate;
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
  EXPECT_EQ(pool.make(scan(), registrar), nullptr) << "no pose yet";
  registrar.push(on_way(0));
  auto first = pool.make(scan(), registrar);
  auto second = pool.make(scan(), registrar);
  EXPECT_NE(first, second);
  const LocalCloud* used = first.get();
  const std::weak_ptr<const Scan> its_scan = first->scan;
  first.reset();
  const auto third = pool.make(scan(), registrar);
  EXPECT_EQ(third.get(), used);
  EXPECT_TRUE(its_scan.expired()) << "its memory is free";
  EXPECT_EQ(second->size(), 1U) << "a cloud in use stays";
}

}  // namespace
}  // namespace swiftlet
