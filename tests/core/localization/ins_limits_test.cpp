// SPDX-License-Identifier: BSD-3-Clause
// Inertial navigation: late measurements and validity.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/localization/ins.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/stage_tables/estimators.hpp"

namespace swiftlet {
namespace {

TEST(InsPast, ComparesWithTheNearestPastState) {
  // At 2 m/s: a delayed fix refers to the position at its time.
  const auto flying = [] {
    InsConfig config;
    config.start_velocity_sigma_mps = 10.0;
    InsFilter filter(config, Pose::Identity());
    filter.predict({1, Vector3::Zero(), {0, 0, kGravity_mps2}});
    GnssSample speed{1, Vector3::Constant(std::nan("")), {2, 0, 0}, Vector3::Ones(), Vector3::Constant(1e-4)};
    filter.update(speed);
    for (int i = 1; i <= 300; ++i) filter.predict({1 + i * 10'000'000LL, Vector3::Zero(), {0, 0, kGravity_mps2}});
    return filter;
  };
  const auto moved_m = [&](TimeNs t, double x_m) {
    InsFilter filter = flying();
    const double before_m = filter.state().p_m.x();
    filter.update(
        GnssSample{t, {x_m, 0, 0}, Vector3::Constant(std::nan("")), Vector3::Constant(1e-3), Vector3::Ones()});
    return filter.state().p_m.x() - before_m;
  };
  const TimeNs end = 1 + 300 * 10'000'000LL;
  EXPECT_NEAR(moved_m(end, 6.0), 0.0, 1e-3);
  EXPECT_NEAR(moved_m(end + kNsPerSecond, 6.0), 0.0, 1e-3) << "a future stamp counts as now";
  for (const int samples : {1, 2, 50, 100}) {
    const double then_m = 6.0 - 0.02 * samples;
    EXPECT_NEAR(moved_m(end - samples * 10'000'000LL, then_m), 0.0, 1e-3) << samples;
  }
  // A correction moves the past as well: the same late fix again changes nothing more.
  InsFilter filter = flying();
  const GnssSample late{
      end - 500'000'000, {5.5, 0, 0}, Vector3::Constant(std::nan("")), Vector3::Constant(1e-3), Vector3::Ones()};
  filter.update(late);
  const double once_m = filter.state().p_m.x();
  EXPECT_NEAR(once_m, 6.5, 0.02);
  filter.update(late);
  EXPECT_NEAR(filter.state().p_m.x(), once_m, 2e-3);
}

TEST(InsHeading, IsIgnoredWithNoseUp) {
  for (const double pitch_deg : {60.0, 89.0}) {
    InsFilter filter({}, make_pose(Vector3::Zero(), rotation_by({0, -pitch_deg * kRadPerDeg, 0})));
    filter.predict({1, Vector3::Zero(), {0, 0, kGravity_mps2}});
    const InsFilter::Covariance before = filter.covariance();
    filter.update(CompassSample{1, 0.02, 0.02});
    EXPECT_EQ(filter.covariance() == before, pitch_deg > 80.0) << pitch_deg;
  }
}

struct ScriptedIns {
  InsConfig config;
  AgentSetup setup;
  std::unique_ptr<StateEstimator> estimator;
  Outbox outbox;
  TimeNs t = 0;
  const StateEstimate& tick(const std::function<void(Observation&)>& change = {}, bool imu = true,
                            const Vector3& force = {0, 0, kGravity_mps2}) {
    if (!estimator) estimator = make_ins_estimator(config, setup);
    t += 4'000'000;
    Observation observation;
    observation.t = t;
    if (imu) observation.imu.push_back({t, {0, 0, 0.3}, force});
    if (change) change(observation);
    return estimator->update(observation, outbox);
  }
};

TEST(InsLimits, IsInvalidAfterAnImuGap) {
  ScriptedIns ins;
  for (int i = 0; i < 50; ++i) ins.tick({}, true, {5, 0, kGravity_mps2});
  const StateEstimate last = ins.tick();
  for (int i = 1; i <= 26; ++i) {
    const StateEstimate& e = ins.tick({}, false);
    EXPECT_EQ(e.valid, i <= 25) << i;
    EXPECT_LT((e.T_local_body.translation() - last.T_local_body.translation() - 0.004 * i * last.v_local_mps).norm(),
              1e-9);
    EXPECT_NEAR(yaw_of(e.T_local_body.linear()) - yaw_of(last.T_local_body.linear()), 0.3 * 0.004 * i, 1e-6);
  }
  EXPECT_STREQ(ins.estimator->fault(), "no IMU");
}

TEST(InsLimits, TooUncertainIsNotValid) {
  ScriptedIns ins;
  ins.config.position_sigma_max_m = 0.5;
  ins.config.start_velocity_sigma_mps = 1.0;
  ins.config.start_position_sigma_m = 0.1;
  double s = 0.0;
  while (ins.tick().valid) s = to_seconds(ins.t);
  EXPECT_STREQ(ins.estimator->fault(), "position too uncertain");
  EXPECT_NEAR(std::hypot(0.1, s), 0.5, 0.01);
}

TEST(InsLimits, UsesOnlyWhatItMay) {
  const auto uncertain_m = [](const std::function<void(InsConfig&)>& change) {
    ScriptedIns ins;
    ins.config.start_position_sigma_m = 2.0;
    change(ins.config);
    StateEstimate e;
    for (int i = 0; i < 5; ++i) {
      e = ins.tick([](Observation& o) {
        o.gnss.push_back({o.t, Vector3::Zero(), Vector3::Zero(), Vector3::Constant(0.1), Vector3::Constant(0.1)});
        o.altimeter.push_back({o.t, 0.0, 0.01});
        o.compass.push_back({o.t, 0.0, 0.001});
        o.odometry.push_back({o.t, Pose::Identity(), Vector3::Zero()});
      });
    }
    return Eigen::Vector2d(std::sqrt(e.covariance(0, 0)), std::sqrt(e.covariance(5, 5)));
  };
  const Eigen::Vector2d all = uncertain_m([](InsConfig&) {});
  EXPECT_LT(all.x(), 0.1);
  EXPECT_LT(all.y(), 0.001);
  EXPECT_GT(uncertain_m([](InsConfig& c) { c.use_gnss = false; }).x(), 1.9);
  EXPECT_GT(uncertain_m([](InsConfig& c) { c.use_compass = false; }).y(), 0.01);
}

}  // namespace
}  // namespace swiftlet
