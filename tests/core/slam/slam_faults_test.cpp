// SPDX-License-Identifier: BSD-3-Clause
// SLAM on stamps that disagree, without an IMU, and on input of wrong units or axes.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "core/slam/matching/innovation_monitor.hpp"
#include "core/slam/matching/local_slam.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/slam/slam.hpp"
#include "tests/core/slam/synthetic_room.hpp"

namespace swiftlet {
namespace {

using testing::SyntheticFlight;
using testing::SyntheticRoom;

constexpr TimeNs kFaultTick = 4'000'000, kFaultScanPeriod = 100'000'000;

const SyntheticRoom kFaultHall = SyntheticRoom::box({-8.3, -7.1, -0.2}, {9.4, 8.2, 5.7});

/// From rest around an ellipse; in between the vehicle speeds up and slows down, and turns to and fro.
Pose weaving_at(double t_s) {
  const double ramp = t_s < 0.0 ? 0.0 : t_s - (1.0 - std::exp(-t_s));
  const double angle = 0.4 * ramp + 0.3 * std::sin(0.8 * ramp);
  const Vector3 p(4.0 * std::cos(angle) - 4.0, 3.0 * std::sin(angle), 2.0 + 0.5 * std::sin(0.9 * ramp));
  return make_pose(
      p, rotation_by({0.0, 0.0, 0.5 * ramp + 0.3 * std::sin(ramp)}) * rotation_by({0.1 * std::sin(ramp), 0.0, 0.0}));
}

struct FaultyFlight {
  SyntheticFlight flight{kFaultHall, weaving_at};
  SlamConfig config;
  double duration_s = 15.0, from_s = 3.0;  // errors count from from_s on
  TimeNs imu_delay = 0;                    // stamps are late by it; deliveries too if positive
  double imu_pause_from_s = 1e9, imu_pause_to_s = 1e9;
  bool with_imu = true;
  Pose T_start = Pose::Identity();  // reported start, if not the true one
  bool start_given = false;
  std::function<void(ImuSample&)> change_sample = [](ImuSample&) {};
  std::function<void(Scan&)> change_scan = [](Scan&) {};

  double worst_m = 0.0, worst_rad = 0.0, final_m = 0.0;
  bool always_valid = true, valid = true;
  std::string faults, warnings;

  void fly() {
    AgentSetup setup;
    setup.T_local_body_start = start_given ? T_start : flight.at(0);
    const auto estimator = make_slam_estimator(config, setup);
    Outbox outbox(0);
    for (TimeNs t = kFaultTick; to_seconds(t) <= duration_s; t += kFaultTick) {
      Observation observation;
      observation.t = t;
      const double s = to_seconds(t);
      if (with_imu && !(s > imu_pause_from_s && s <= imu_pause_to_s)) {
        ImuSample sample = flight.imu(t - std::max<TimeNs>(imu_delay, 0));
        sample.t += imu_delay;
        change_sample(sample);
        observation.imu.push_back(sample);
      }
      if (t % kFaultScanPeriod == 0) {
        auto scan = std::make_shared<Scan>(*flight.scan(t));
        change_scan(*scan);
        observation.scans.push_back(std::move(scan));
      }
      const StateEstimate& e = estimator->update(observation, outbox);
      note(faults, estimator->fault());
      note(warnings, estimator->warning());
      valid = e.valid;
      if (s < from_s) continue;
      always_valid = always_valid && e.valid;
      const Pose T = flight.at(t);
      final_m = (e.T_local_body.translation() - T.translation()).norm();
      worst_m = std::max(worst_m, final_m);
      const Eigen::Quaterniond turn(Matrix3(T.linear().transpose() * e.T_local_body.linear()));
      worst_rad = std::max(worst_rad, rotation_vector_rad(turn).norm());
    }
  }

  static void note(std::string& all, const std::string& text) {
    if (!text.empty() && all.find(text) == std::string::npos) all += text + ";";
  }
};

TEST(SlamFaults, LearnsTimeOffsetOfTheImu) {
  for (const int delay_ms : {-40, -15, 15, 40}) {
    FaultyFlight faulty;
    faulty.imu_delay = delay_ms * 1'000'000;
    faulty.fly();
    EXPECT_TRUE(faulty.always_valid) << delay_ms << faulty.faults;
    EXPECT_LT(faulty.worst_m, 0.05) << delay_ms;
    EXPECT_LT(faulty.worst_rad, 0.02) << delay_ms;
    if (std::abs(delay_ms) < 20) continue;  // within its standard deviation: hardly observed in such a gentle flight
    EXPECT_NE(faulty.warnings.find(delay_ms > 0 ? "late" : "early"), std::string::npos) << delay_ms << faulty.warnings;
  }
}

TEST(SlamFaults, UsesTheGivenTimeOffset) {
  FaultyFlight faulty;
  faulty.imu_delay = 30'000'000;
  faulty.config.local.imu.time_offset_s = 0.03;
  faulty.config.local.imu.time_offset_sigma_s = 0.0;
  faulty.fly();
  EXPECT_LT(faulty.worst_m, 0.03);
  EXPECT_EQ(faulty.warnings, "");
}

TEST(SlamFaults, FollowsWithoutAnImu) {
  FaultyFlight faulty;
  faulty.config.imu = SlamConfig::Imu::kNone;
  faulty.with_imu = false;
  faulty.fly();
  EXPECT_TRUE(faulty.always_valid) << faulty.faults;
  EXPECT_LT(faulty.final_m, 0.15);
  EXPECT_LT(faulty.worst_m, 0.3);
  EXPECT_LT(faulty.worst_rad, 0.15);
}

TEST(SlamFaults, ContinuesByScansWhileImuPauses) {
  FaultyFlight faulty;
  faulty.imu_pause_from_s = 8.0;
  faulty.imu_pause_to_s = 9.0;
  faulty.fly();
  EXPECT_EQ(faulty.faults, "no IMU;");
  EXPECT_TRUE(faulty.valid);
  EXPECT_LT(faulty.final_m, 0.03);
  EXPECT_LT(faulty.worst_m, 0.4);
}

TEST(SlamFaults, LevelsItselfAfterStartInTurn) {
  FaultyFlight faulty;
  // Around a circle of 4 m at 2.5 m/s, tilted inward by 9 degrees.
  faulty.flight = SyntheticFlight(kFaultHall, [](double t_s) {
    const double angle = 0.62 * t_s;
    return make_pose({4.0 * std::cos(angle), 4.0 * std::sin(angle), 2.0},
                     rotation_by({0.0, 0.0, angle + 0.5 * M_PI}) * rotation_by({-9.0 * kRadPerDeg, 0.0, 0.0}));
  });
  faulty.start_given = true;
  faulty.T_start = make_pose({4.0, 0.0, 2.0}, rotation_by({0.0, 0.0, 0.5 * M_PI}));
  faulty.config.local.imu.start_velocity_sigma_mps = 5.0;
  faulty.config.local.imu.start_tilt_sigma_deg = 15.0;
  faulty.fly();
  EXPECT_TRUE(faulty.always_valid) << faulty.faults;
  EXPECT_LT(faulty.worst_rad, 2.0 * kRadPerDeg);
  EXPECT_LT(faulty.worst_m, 0.3);
}

TEST(SlamFaults, NamesWrongUnitsAndAxes) {
  struct Case {
    const char* named;
    std::function<void(ImuSample&)> change_sample;
    std::function<void(Scan&)> change_scan;
  };
  const auto same_sample = [](ImuSample&) {};
  const auto same_scan = [](Scan&) {};
  const Case cases[] = {
      {"negate it", [](ImuSample& s) { s.specific_force_body_mps2 *= -1.0; }, same_scan},
      {"if it is in g", [](ImuSample& s) { s.specific_force_body_mps2 /= 9.81; }, same_scan},
      {"in deg/s", [](ImuSample& s) { s.omega_body_radps *= 180.0 / M_PI; }, same_scan},
      {"not mm", same_sample,
       [](Scan& scan) {
         for (float& range_m : scan.range_m) range_m *= 1000.0F;
       }},
      {"not of their end", same_sample, [](Scan& scan) { scan.stamp += scan.duration; }},
  };
  for (const Case& wrong : cases) {
    FaultyFlight faulty;
    faulty.change_sample = wrong.change_sample;
    faulty.change_scan = wrong.change_scan;
    faulty.fly();
    EXPECT_NE(faulty.faults.find(wrong.named), std::string::npos) << wrong.named << ": " << faulty.faults;
    EXPECT_FALSE(faulty.valid) << wrong.named;
  }
}

TEST(SlamFaults, NamesATurnedLidar) {
  for (const double turn_rad : {0.5 * M_PI, M_PI}) {
    FaultyFlight faulty;
    faulty.flight = SyntheticFlight(kFaultHall, [](double t_s) {
      return weaving_at(t_s) *
             make_pose(Vector3::Zero(), rotation_by({0.3 * std::sin(2.0 * std::max(t_s, 0.0)), 0, 0}));
    });
    faulty.change_scan = [&](Scan& scan) {
      scan.T_body_lidar.linear() = rotation_by({0, 0, turn_rad}) * scan.T_body_lidar.linear();
    };
    faulty.fly();
    EXPECT_NE(faulty.faults.find("mounts of the LiDARs"), std::string::npos) << turn_rad << faulty.faults;
    EXPECT_FALSE(faulty.valid) << turn_rad;
  }
}

TEST(InnovationMonitor, ScalesNoiseUntilInnovationsAgree) {
  InnovationMonitor monitor;
  for (int i = 0; i < 100; ++i) monitor.add(6.0, 6);
  EXPECT_EQ(monitor.noise_factor(), 1.0) << "honest innovations change nothing";
  EXPECT_EQ(monitor.covariance_factor(), 1.0);
  // Innovations of an IMU that is 30 times noisier than assumed.
  for (int i = 0; i < 200; ++i) monitor.add(6.0 * 900.0 / monitor.noise_factor(), 6);
  EXPECT_GT(monitor.noise_factor(), 100.0);
  EXPECT_LT(monitor.noise_factor(), 900.0);
  EXPECT_TRUE(monitor.disagrees());
  for (int i = 0; i < 500; ++i) monitor.add(6.0, 6);
  EXPECT_EQ(monitor.noise_factor(), 1.0) << "the noise factor recovers";
}

TEST(InnovationMonitor, NoticesAccelerationsThatImuLacks) {
  InnovationMonitor monitor;
  const Vector3 gained_mps(0.04, -0.06, 0.0);  // per scan: 0.7 m/s^2
  for (int i = 0; i < 50; ++i) monitor.add_correction((i % 2 ? 3.0 : -3.0) * gained_mps);
  EXPECT_FALSE(monitor.contradicts()) << "noise";
  for (int i = 0; i < 10; ++i) monitor.add_correction(gained_mps);
  EXPECT_TRUE(monitor.contradicts());
  const auto add_scans = [&](double square) {
    for (int i = 0; i < 200; ++i) {
      monitor.add(6.0 * square, 6);
      monitor.add_correction(Vector3::Zero());
    }
  };
  add_scans(2.0);
  EXPECT_TRUE(monitor.contradicts()) << "the scans still disagree";
  add_scans(0.3);
  EXPECT_FALSE(monitor.contradicts()) << "a collision is forgotten";
}

}  // namespace
}  // namespace swiftlet
