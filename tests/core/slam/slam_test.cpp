// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/slam/slam.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/slam/slam_to_now.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/slam/saved_map.hpp"
#include "tests/core/slam/synthetic_room.hpp"

namespace swiftlet {
namespace {

using testing::SyntheticFlight;
using testing::SyntheticRoom;

constexpr TimeNs kTick = 4'000'000, kScanPeriod = 100'000'000;

const SyntheticRoom kHall = SyntheticRoom::box({-8.3, -7.1, -0.2}, {9.4, 8.2, 5.7});

/// From rest: around an ellipse with bobbing and a turning heading.
Pose loop_at(double t_s) {
  const double ramp = t_s < 0.0 ? 0.0 : t_s - (1.0 - std::exp(-t_s));  // speed rises from 0 to 1
  const double angle = 0.4 * ramp;
  const Vector3 p(4.0 * std::cos(angle) - 4.0, 3.0 * std::sin(angle), 2.0 + 0.5 * std::sin(0.9 * ramp));
  return make_pose(
      p, rotation_by({0.0, 0.0, 0.5 * ramp}) * rotation_by({0.1 * std::sin(ramp), 0.1 * std::sin(0.7 * ramp), 0.0}));
}

struct Result {
  double worst_m = 0.0, worst_rad = 0.0, worst_mps = 0.0, final_m = 0.0, largest_step_m = 0.0;
  double mean_nees = 0.0;
  bool always_valid = true;
  std::string warnings, fault;
  std::vector<Counter> counters;
  StateEstimate last;
};

struct Course {
  double duration_s = 20.0;
  double from_s = 2.0;  // errors count from here
  double blind_from_s = 1e9, blind_for_s = 1.0;
  SlamConfig config;
  AgentSetup setup;
};

Result fly(SyntheticFlight& flight, Course course) {
  course.setup.T_local_body_start = flight.at(0);
  const auto estimator = make_slam_estimator(course.config, course.setup);
  Outbox outbox(0);
  Result result;
  int num_nees = 0;
  Vector3 last_off_m = Vector3::Zero();
  for (TimeNs t = kTick; to_seconds(t) <= course.duration_s; t += kTick) {
    Observation observation;
    observation.t = t;
    observation.imu.push_back(flight.imu(t));
    const double s = to_seconds(t);
    const bool blind = s > course.blind_from_s && s <= course.blind_from_s + course.blind_for_s;
    if (t % kScanPeriod == 0 && !blind) observation.scans.push_back(flight.scan(t));
    const StateEstimate& e = estimator->update(observation, outbox);
    const std::string warning = estimator->warning();
    if (!warning.empty() && result.warnings.find(warning) == std::string::npos) result.warnings += warning + ";";
    result.fault = estimator->fault();
    result.always_valid = result.always_valid && e.valid;
    if (!e.valid) break;
    const Pose T = flight.at(t);
    const Vector3 off_m = e.T_local_body.translation() - T.translation();
    const Vector3 turn = rotation_vector_rad(Eigen::Quaterniond(T.linear().transpose() * e.T_local_body.linear()));
    result.final_m = off_m.norm();
    result.last = e;
    if (s < course.from_s) {
      last_off_m = off_m;
      continue;
    }
    result.worst_m = std::max(result.worst_m, off_m.norm());
    result.worst_rad = std::max(result.worst_rad, turn.norm());
    result.worst_mps = std::max(result.worst_mps, (e.v_local_mps - flight.velocity_mps(t)).norm());
    result.largest_step_m = std::max(result.largest_step_m, (off_m - last_off_m).norm());
    last_off_m = off_m;
    Eigen::Matrix<double, 6, 1> error;
    error << off_m, turn;
    result.mean_nees += error.dot(e.covariance.ldlt().solve(error));
    ++num_nees;
  }
  if (num_nees > 0) result.mean_nees /= num_nees;
  estimator->append_counters(result.counters);
  return result;
}

SyntheticFlight biased_flight(SyntheticFlight::PoseAt at, unsigned seed = 1) {
  SyntheticFlight flight(kHall, std::move(at), seed);
  flight.gyro_bias_radps = {0.008, -0.006, 0.009};
  flight.accel_bias_mps2 = {0.15, -0.2, 0.1};
  return flight;
}

TEST(Slam, FollowsAFlightDespiteImuBias) {
  SyntheticFlight flight = biased_flight(loop_at);
  const Result result = fly(flight, {});
  EXPECT_TRUE(result.always_valid) << result.fault;
  EXPECT_EQ(result.warnings, "");
  EXPECT_LT(result.worst_m, 0.015);
  EXPECT_LT(result.worst_rad, 0.003);
  EXPECT_LT(result.worst_mps, 0.06);
  EXPECT_LT(result.largest_step_m, 0.007) << "a scan moves the pose by millimeters: control sees no jump";
}

TEST(Slam, MatchesDelayedScansAtOwnTime) {
  for (const double latency_s : {0.15, 0.5}) {
    SyntheticFlight flight = biased_flight(loop_at);
    Course course;
    course.from_s = 4.0;
    course.config.latency_s = latency_s;
    const Result result = fly(flight, course);
    EXPECT_TRUE(result.always_valid) << result.fault;
    EXPECT_EQ(result.warnings, "") << "a scan in progress is not missing";
    EXPECT_LT(result.worst_m, 0.025) << latency_s;
    EXPECT_LT(result.worst_rad, 0.005) << latency_s;
    EXPECT_LT(result.worst_mps, 0.08) << latency_s;
  }
}

TEST(Slam, LatencyOnlyDelaysScans) {
  // Equal scans and IMU samples, so equal maps and states, reported later.
  constexpr TimeNs kLate = 200'000'000;
  LocalSlamConfig config;
  SyntheticFlight flight = biased_flight(loop_at);
  SlamToNow prompt(config, 0.0, flight.at(0), 0.3), late(config, to_seconds(kLate), flight.at(0), 0.3);
  std::vector<Pose> prompt_poses, late_poses;
  for (TimeNs t = kTick; to_seconds(t) <= 3.0; t += kTick) {
    const ImuSample sample = flight.imu(t);
    const auto scan = t % kScanPeriod == 0 ? flight.scan(t) : nullptr;
    for (SlamToNow* slam : {&prompt, &late}) {
      slam->add(sample);
      if (scan != nullptr) slam->add(t, scan);
      while (slam->match_next(t))
        (slam == &prompt ? prompt_poses : late_poses).push_back(slam->at_scan().inserted_at().T);
    }
  }
  ASSERT_EQ(prompt_poses.size(), late_poses.size() + 2);
  for (std::size_t i = 0; i < late_poses.size(); ++i) EXPECT_EQ(prompt_poses[i].matrix(), late_poses[i].matrix()) << i;
}

TEST(Slam, SkipsScansOlderThanItsSamples) {
  SyntheticFlight flight = biased_flight(loop_at);
  SlamToNow slam(LocalSlamConfig{}, 1e6, flight.at(0), 0.3);
  constexpr auto kSamples = static_cast<TimeNs>(SlamToNow::kMaxSamples);
  slam.add(0, flight.scan(kScanPeriod));
  for (TimeNs i = 1; i <= 2 * kSamples; ++i) slam.add({i * 1'000'000, Vector3::Zero(), {0, 0, 9.80665}});
  EXPECT_EQ(slam.now().state().nav.t, 2 * kSamples * 1'000'000);
  EXPECT_EQ(slam.at_scan().filter().state().nav.t, kSamples * 1'000'000) << "the oldest samples are applied";
  EXPECT_FALSE(slam.match_next(2 * kSamples * 1'000'000));
}

TEST(Slam, ItsCovarianceIsHonest) {
  double nees = 0.0;
  constexpr int kFlights = 4;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    SyntheticFlight flight = biased_flight(loop_at, seed);
    Course course;
    course.duration_s = 12.0;
    nees += fly(flight, course).mean_nees / kFlights;
  }
  // Six degrees of freedom. A smooth room is easier than the worlds in which the parameters were tuned.
  EXPECT_GT(nees, 0.3);
  EXPECT_LT(nees, 9.0);
}

TEST(Slam, ReportsAndSurvivesSecondWithoutLidar) {
  SyntheticFlight flight = biased_flight(loop_at);
  Course course;
  course.blind_from_s = 8.0;
  const Result result = fly(flight, course);
  EXPECT_TRUE(result.always_valid) << result.fault;
  EXPECT_LT(result.worst_m, 0.08);
  EXPECT_LT(result.final_m, 0.015);
  EXPECT_EQ(result.warnings, "SLAM: dead reckoning by the IMU alone;");
}

TEST(Slam, CountsUnrecognizedScansAndNamesSetting) {
  SyntheticFlight flight = biased_flight(loop_at);
  Course course;
  course.duration_s = 4.0;
  EXPECT_EQ(fly(flight, course).counters.at(0).count, 0U);
  course.config.local.known_share_min = 1.0;
  const Counter counter = fly(flight, course).counters.at(0);
  EXPECT_EQ(counter.setting, "local.known_share_min");
  EXPECT_GT(counter.count, 10U);
  EXPECT_LE(counter.count, counter.of);
}

TEST(Slam, IgnoresEmptyScansWhenCountingUnrecognized) {
  SyntheticFlight flight = biased_flight(loop_at);
  Course course;
  course.duration_s = 4.0;
  course.blind_from_s = 2.0;
  course.blind_for_s = 1.0;
  const Counter counter = fly(flight, course).counters.at(0);
  EXPECT_EQ(counter.count, 0U);
  EXPECT_GT(counter.of, 0U);
}

TEST(Slam, FollowsThreeRadiansPerSecondTurns) {
  SyntheticFlight flight = biased_flight([](double t_s) {
    const double turn = t_s < 1.0 ? 0.0 : 3.0 * (t_s - 1.0 - 0.5 * (1.0 - std::exp(-2.0 * (t_s - 1.0))));
    return make_pose({0.0, 0.0, 2.0}, rotation_by({0.0, 0.0, turn}));
  });
  Course course;
  course.duration_s = 10.0;
  const Result result = fly(flight, course);
  EXPECT_TRUE(result.always_valid) << result.fault;
  EXPECT_LT(result.worst_m, 0.02);
  EXPECT_LT(result.worst_rad, 0.006);
}

TEST(Slam, StartsInFlightAtUnknownSpeed) {
  SyntheticFlight flight = biased_flight([](double t_s) {
    return make_pose({-5.0 + 2.0 * t_s, 1.0 - 0.5 * t_s, 2.0}, rotation_by({0.0, 0.0, 0.2 * t_s}));
  });
  Course course;
  course.duration_s = 6.0;
  course.config.local.imu.start_velocity_sigma_mps = 3.0;
  course.from_s = 2.2;
  const Result result = fly(flight, course);
  EXPECT_TRUE(result.always_valid) << result.fault;
  EXPECT_LT(result.worst_mps, 0.06);
  EXPECT_LT(result.worst_m, 0.03);
}

TEST(Slam, NeedsFewStemsOverOpenGround) {
  SyntheticRoom field;
  field.walls.push_back({Vector3::UnitZ(), -2.0});
  for (const auto& [x_m, y_m] : {std::pair{5.0, 2.0},
                                 {0.0, 8.0},
                                 {-6.0, 9.0},
                                 {-11.0, 6.0},
                                 {-13.0, -1.0},
                                 {-10.0, -7.0},
                                 {-3.0, -9.0},
                                 {4.0, -6.0}})
    field.stems.push_back({x_m, y_m, 0.3, 8.0});
  SyntheticFlight flight(field, loop_at);
  Course course;
  course.duration_s = 12.0;
  const Result result = fly(flight, course);
  EXPECT_TRUE(result.always_valid) << result.fault;
  EXPECT_EQ(result.warnings, "");
  EXPECT_LT(result.worst_m, 0.08);
  EXPECT_LT(result.worst_rad, 0.01);
  course.config.local.matching.standing_points = 1000000;
  SyntheticFlight again(field, loop_at);
  EXPECT_EQ(fly(again, course).warnings, "SLAM is degenerate: the scans do not constrain every direction;")
      << "planes alone";
}

TEST(Slam, ReportsOpenDirectionInAnAisle) {
  // The columns of beams make upright lines on its walls, which look like stems. But no beam passes beside them.
  SyntheticRoom aisle = kHall;
  aisle.walls.erase(aisle.walls.begin(), aisle.walls.begin() + 2);
  SyntheticFlight flight(aisle, [](double t_s) {
    const double path_m = t_s < 1.0 ? 0.0 : 0.8 * (t_s - 1.0 - (1.0 - std::exp(-(t_s - 1.0))));
    return make_pose({path_m, 0.2, 2.0}, Eigen::Quaterniond::Identity());
  });
  Course course;
  course.duration_s = 8.0;
  course.config.position_sigma_max_m = 50.0;
  const Result result = fly(flight, course);
  EXPECT_EQ(result.warnings, "SLAM is degenerate: the scans do not constrain every direction;");
  const StateEstimate& e = result.last;
  EXPECT_GT(e.covariance(0, 0), 25.0 * e.covariance(1, 1)) << "along the aisle";
  const double along_m = std::abs(e.T_local_body.translation().x() - flight.at(e.t).translation().x());
  EXPECT_LT(along_m, 4.0 * std::sqrt(e.covariance(0, 0)));
}

TEST(Slam, CoastsThenGivesUpWithoutReturns) {
  SyntheticFlight flight(SyntheticRoom{}, [](double) { return make_pose({0, 0, 2}, Eigen::Quaterniond::Identity()); });
  Course course;
  course.duration_s = 6.0;
  const Result result = fly(flight, course);
  EXPECT_FALSE(result.always_valid);
  EXPECT_EQ(result.warnings, "SLAM: dead reckoning by the IMU alone;");
}

TEST(Slam, LearnsPoseFromCompassAndGnss) {
  AgentSetup setup;
  setup.start_known = StartKnown::kNothing;
  const auto estimator = make_slam_estimator(SlamConfig{}, setup);
  Outbox outbox(0);
  Observation observation;
  observation.t = kTick;
  observation.imu.push_back({kTick, Vector3::Zero(), {0, 0, 9.81}});
  observation.gnss.push_back({kTick, {1, 1, 1}});
  EXPECT_EQ(estimator->update(observation, outbox).correction_revision, 0U) << "a position needs a heading";
  observation.t = 2 * kTick;
  observation.imu[0].t = 2 * kTick;
  observation.gnss[0] = {2 * kTick, {30, -20, 5}};
  observation.compass.push_back({2 * kTick, 1.0, 0.01});
  const StateEstimate& e = estimator->update(observation, outbox);
  EXPECT_EQ(e.correction_revision, 2U);
  EXPECT_LT((e.T_world_body().translation() - Vector3(30, -20, 5)).norm(), 1e-3);
  EXPECT_NEAR(yaw_of(e.T_world_body().linear()), 1.0, 1e-9);
}

// A map without points, in which relocalization is impossible.
TEST(Slam, RelocalizesInMapUnlessStartKnown) {
  using Search = StateEstimator::Search;
  auto map = std::make_shared<SavedMap>();
  map->graph.add_pose(Pose::Identity());
  map->submaps.push_back({});
  for (const StartKnown known : {StartKnown::kPose, StartKnown::kPosition, StartKnown::kNothing}) {
    for (const bool gnss : {false, true}) {
      SlamConfig config;
      config.global.enabled = true;
      config.global.loaded_map = map;
      SyntheticFlight flight = biased_flight([](double) {
        return make_pose({0, 0, 2}, Eigen::Quaterniond::Identity());
      });
      AgentSetup setup;
      setup.start_known = known;
      setup.T_local_body_start = flight.at(0);
      const auto estimator = make_slam_estimator(config, setup);
      Outbox outbox(0);
      std::vector<Search> searches;
      for (TimeNs t = kTick; t <= 25 * kNsPerSecond; t += kTick) {
        Observation observation;
        observation.t = t;
        observation.imu.push_back(flight.imu(t));
        if (t % kScanPeriod == 0) observation.scans.push_back(flight.scan(t));
        if (gnss && t % kScanPeriod == 0) {
          observation.compass.push_back({t, 0.0, 0.01});
          observation.gnss.push_back({t, {30, -20, 5}});
        }
        estimator->update(observation, outbox);
        if (searches.empty() || searches.back() != estimator->search()) searches.push_back(estimator->search());
      }
      const Search in_the_end = gnss ? Search::kNone : Search::kFailed;
      if (known == StartKnown::kPose)
        EXPECT_EQ(searches, std::vector<Search>{Search::kNone});
      else
        EXPECT_EQ(searches, (std::vector<Search>{Search::kActive, in_the_end})) << static_cast<int>(known) << gnss;
    }
  }
}

TEST(Slam, UsesOnlyTheNamedLidars) {
  SyntheticFlight flight = biased_flight(loop_at);
  Course course;
  course.duration_s = 1.0;
  course.config.lidars = {"another"};
  EXPECT_EQ(fly(flight, course).warnings, "SLAM: dead reckoning by the IMU alone;");
  course.config.lidars = {"another", "lidar"};
  SyntheticFlight again = biased_flight(loop_at);
  EXPECT_EQ(fly(again, course).warnings, "");
}

TEST(Slam, TakesPositionFromFirstFiniteFix) {
  AgentSetup setup;
  setup.start_known = StartKnown::kNothing;
  const auto estimator = make_slam_estimator(SlamConfig{}, setup);
  Outbox outbox(0);
  auto place_after_fix_m = [&, i = 0](const Vector3& fix_m) mutable {
    Observation observation;
    observation.t = ++i * kTick;
    observation.imu.push_back({observation.t, Vector3::Zero(), {0, 0, 9.81}});
    observation.compass.push_back({observation.t, 1.0, 0.01});
    observation.gnss.push_back({observation.t, fix_m});
    return Vector3(estimator->update(observation, outbox).T_world_body().translation());
  };
  EXPECT_TRUE(place_after_fix_m({std::nan(""), 0, 0}).allFinite());
  EXPECT_LT((place_after_fix_m({30, -20, 5}) - Vector3(30, -20, 5)).norm(), 1e-3);
  EXPECT_LT((place_after_fix_m({31, -20, 5}) - Vector3(30, -20, 5)).norm(), 1e-3) << "later ones do not move the frame";
}

}  // namespace
}  // namespace swiftlet
