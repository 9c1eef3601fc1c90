// SPDX-License-Identifier: BSD-3-Clause
// Times at which a SLAM estimate gets a warning or becomes invalid, and how far it is propagated.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <tuple>

#include "core/slam/slam_to_now.hpp"
#include "swiftlet/core/base/gravity.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/slam/slam.hpp"
#include "tests/core/slam/synthetic_room.hpp"

namespace swiftlet {
namespace {

constexpr TimeNs kSlamTick = 4'000'000;
const Vector3 kAtRest(0, 0, kGravity_mps2);

/// An estimator with prescribed input, tick by tick.
struct ScriptedSlam {
  SlamConfig config;
  AgentSetup setup;
  std::unique_ptr<StateEstimator> estimator;
  Outbox outbox{0};
  TimeNs t = 0;

  const StateEstimate& tick(const std::function<void(Observation&)>& change = {}, bool imu = true,
                            const Vector3& force = kAtRest, const Vector3& omega = Vector3::Zero()) {
    if (!estimator) estimator = make_slam_estimator(config, setup);
    t += kSlamTick;
    Observation observation;
    observation.t = t;
    if (imu) observation.imu.push_back({t, omega, force});
    if (change) change(observation);
    return estimator->update(observation, outbox);
  }
  /// Time until a warning or fault is reported [s]; the first tick is at 4 ms.
  double until_s(const std::string& report, bool fault, double most_s, bool imu = true) {
    while (to_seconds(t) < most_s) {
      tick({}, imu);
      if (report == (fault ? estimator->fault() : estimator->warning())) return to_seconds(t - kSlamTick);
    }
    return most_s;
  }
};

TEST(SlamLimits, WarnsThenGivesUpWithoutScans) {
  for (const auto& [latency_s, warn_after_s, timeout_s] : {std::tuple{0.03, 0.35, 3.0}, {0.2, 0.1, 0.5}}) {
    ScriptedSlam slam;
    slam.config.latency_s = latency_s;
    slam.config.warn_after_s = warn_after_s;
    slam.config.lidar_timeout_s = timeout_s;
    EXPECT_NEAR(slam.until_s("SLAM: dead reckoning by the IMU alone", false, 5.0), latency_s + warn_after_s, 0.0041);
    EXPECT_NEAR(slam.until_s("SLAM is lost: no scan fits", true, 5.0), latency_s + timeout_s, 0.0041);
  }
}

TEST(SlamLimits, IsInvalidAfterAnImuGap) {
  ScriptedSlam slam;
  slam.tick();
  const double s = slam.until_s("no IMU", true, 2.0, false);
  EXPECT_NEAR(s, 0.104, 1e-9);
  EXPECT_FALSE(slam.tick({}, false).valid);
  EXPECT_TRUE(slam.tick().valid) << "after the gap";
  EXPECT_STREQ(slam.estimator->fault(), "");
  const StateEstimate& e = slam.tick([](Observation& o) { o.imu[0].omega_body_radps.x() = std::nan(""); });
  EXPECT_TRUE(e.valid) << "a single non-finite sample is skipped";
}

TEST(SlamLimits, TooUncertainIsNotValid) {
  // An unknown velocity of 0.1 m/s, a bias of 0.2 m/s^2 and a tilt of half a degree.
  ScriptedSlam slam;
  slam.config.position_sigma_max_m = 0.12;
  const double s = slam.until_s("position too uncertain", true, 3.0);
  const double a_mps2 = std::hypot(0.196, kGravity_mps2 * 0.5 * M_PI / 180.0);
  const double expected_m = std::hypot(0.1 * s, 0.5 * a_mps2 * s * s);
  EXPECT_NEAR(expected_m, 0.12, 0.01) << s;
}

TEST(SlamLimits, ExtrapolatesBrieflyPastTheLastSample) {
  ScriptedSlam slam;
  slam.setup.T_local_body_start = make_pose({1, 2, 3}, Eigen::Quaterniond::Identity());
  slam.tick();
  for (int i = 0; i < 50; ++i) slam.tick({}, true, {5.0, 0, kGravity_mps2}, {0, 0, 0.2});
  const StateEstimate last = slam.tick();
  const Vector3 v = last.v_local_mps;
  EXPECT_GT(v.norm(), 0.9);
  slam.tick({}, false);
  const StateEstimate ahead = slam.tick({}, false);
  EXPECT_LT((ahead.T_local_body.translation() - last.T_local_body.translation() - 0.008 * v).norm(), 1e-9);
  EXPECT_EQ(ahead.v_local_mps, v);
  slam.t += 20 * kNsPerSecond;
  const StateEstimate late = slam.tick({}, false);
  EXPECT_LT((late.T_local_body.translation() - last.T_local_body.translation() - 0.1 * v).norm(), 1e-9);
  // Rotation continues as well.
  ScriptedSlam turning;
  for (int i = 0; i < 3; ++i) turning.tick({}, true, kAtRest, {0, 0, 0.5});
  const double yaw_rad = yaw_of(turning.tick({}, true, kAtRest, {0, 0, 0.5}).T_local_body.linear());
  turning.tick({}, false);
  EXPECT_NEAR(yaw_of(turning.tick({}, false).T_local_body.linear()) - yaw_rad, 0.5 * 0.008, 1e-9);
}

TEST(SlamLimits, TakesWorldHeadingFromTheCompass) {
  ScriptedSlam slam;
  slam.setup.start_known = StartKnown::kPosition;
  slam.setup.T_local_body_start = make_pose({7, 8, 9}, rotation_by({0, 0, 0.4}));
  slam.tick();
  slam.tick([](Observation& o) { o.compass.push_back({o.t, std::nan(""), 0.01}); });
  const StateEstimate& e = slam.tick([](Observation& o) {
    o.compass.push_back({o.t, -1.1, 0.01});
    o.compass.push_back({o.t, 2.0, 0.01});
    o.gnss.push_back({o.t, {100, 0, 0}});
  });
  EXPECT_EQ(e.correction_revision, 1U) << "only the first finite heading; the position is known";
  EXPECT_NEAR(yaw_of(e.T_world_body().linear()), -1.1, 1e-6);
  EXPECT_LT((e.T_world_body().translation() - Vector3(7, 8, 9)).norm(), 1e-3) << "turned about the start";
  EXPECT_EQ(slam.tick([](Observation& o) { o.compass.push_back({o.t, 0.5, 0.01}); }).correction_revision, 1U);
}

TEST(SlamLimits, MatchesAScanAfterItsLatency) {
  testing::SyntheticFlight flight(testing::SyntheticRoom::box({-5, -5, -1}, {6, 5, 3}), [](double) {
    return make_pose({0, 0, 1}, Eigen::Quaterniond::Identity());
  });
  constexpr TimeNs kScan = 100'000'000;
  for (const double latency_s : {0.0, 0.03}) {
    SlamToNow slam(LocalSlamConfig{}, latency_s, flight.at(0), 0.3);
    for (TimeNs t = kSlamTick; t <= kScan; t += kSlamTick) slam.add(flight.imu(t));
    slam.add(kScan, flight.scan(kScan));
    slam.add(kScan, flight.scan(kScan));
    const TimeNs due = kScan + from_seconds(latency_s);
    for (TimeNs t = kScan + kSlamTick; t < due; t += kSlamTick) slam.add(flight.imu(t));
    EXPECT_FALSE(slam.match_next(due - 1));
    const auto matched = slam.match_next(due);
    ASSERT_TRUE(matched);
    EXPECT_EQ(matched->arrived, kScan);
    EXPECT_TRUE(matched->outcome.used);
    EXPECT_TRUE(slam.match_next(due)) << "both";
    EXPECT_FALSE(slam.match_next(due));
    EXPECT_EQ(slam.now().state().nav.t, latency_s > 0.0 ? kScan + 7 * kSlamTick : kScan);
  }
}

}  // namespace
}  // namespace swiftlet
