// SPDX-License-Identifier: BSD-3-Clause
// Local SLAM as in the document: updates of the filter and of the map, and reported figures.
#include "core/slam/matching/grid_matcher.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/slam/matching/local_slam.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "tests/core/slam/random_poses.hpp"
#include "tests/core/slam/synthetic_room.hpp"

namespace swiftlet {
namespace {

using testing::SyntheticFlight;
using testing::SyntheticRoom;

constexpr TimeNs kGridImuTick = 4'000'000, kGridLidarTick = 100'000'000;

const SyntheticRoom kWorkshop = SyntheticRoom::box({-6.3, -5.1, -0.2}, {7.4, 6.2, 4.7});

Pose at_rest(double) { return make_pose({0, 0, 1.5}, Eigen::Quaterniond::Identity()); }

struct GridFlight {
  SyntheticFlight flight;
  LocalSlam slam;
  std::vector<ScanOutcome> outcomes;
  std::vector<double> off_m;

  GridFlight(const SyntheticRoom& room, SyntheticFlight::PoseAt at, const GridMatchingConfig& config = {},
             double velocity_sigma_mps = 0.1)
      : flight(room, std::move(at)), slam(slam_of(config, velocity_sigma_mps)) {}

  LocalSlam slam_of(const GridMatchingConfig& config, double velocity_sigma_mps) {
    LocalSlamConfig local;
    local.start_scans = 0;
    local.imu.start_velocity_sigma_mps = velocity_sigma_mps;
    return {local, flight.at(0), 0.3, std::make_unique<GridMatcher>(config)};
  }
  void fly(int num_scans) {
    for (TimeNs t = kGridImuTick; static_cast<int>(outcomes.size()) < num_scans; t += kGridImuTick) {
      slam.add(flight.imu(t));
      if (t % kGridLidarTick != 0) continue;
      outcomes.push_back(slam.add(flight.scan(t)));
      off_m.push_back((slam.filter().T_local_body().translation() - flight.at(t).translation()).norm());
    }
  }
  std::vector<int> inserted() const {
    std::vector<int> inserted;
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      if (outcomes[i].inserted) inserted.push_back(static_cast<int>(i) + 1);
    }
    return inserted;
  }
};

TEST(GridMatcher, InsertsRestingScansEveryHalfSecond) {
  GridMatchingConfig config;
  config.insert_after_m = config.insert_after_deg = 10.0;
  GridFlight rest(kWorkshop, at_rest, config);
  rest.fly(18);
  EXPECT_EQ(rest.inserted(), (std::vector<int>{1, 6, 11, 16}));
  for (const ScanOutcome& outcome : rest.outcomes) EXPECT_TRUE(outcome.used);
}

TEST(GridMatcher, MatchesScansToOlderSubmap) {
  // Two scans of where the vehicle is make the older one; both take a third of where it is not.
  GridMatchingConfig config;
  config.submaps.scans = 2;
  config.cost.low_weight = 0.01;
  GridMatcher matcher(config);
  SyntheticFlight flight(kWorkshop, at_rest);
  const auto take = [&] {
    MotionHistory motion;
    motion.push(0, flight.at(0).translation(), Eigen::Quaterniond::Identity());
    std::vector<Eigen::Vector3f> returns_body_m;
    undistort(*flight.scan(kGridLidarTick), motion, 0, 0.3, 100.0, returns_body_m);
    matcher.take(returns_body_m, false);
  };
  const Pose T_beside = make_pose(flight.at(0).translation() + Vector3(0.3, 0.3, 0), Eigen::Quaterniond::Identity());
  for (const Pose& T : {flight.at(0), flight.at(0), T_beside}) {
    take();
    matcher.insert(T);
  }
  ASSERT_EQ(matcher.submaps().num_active(), 2);
  EXPECT_EQ(matcher.submaps().older().num_scans, 3);
  EXPECT_EQ(matcher.submaps().newer().num_scans, 1);
  // Between both: the newer submap would draw it further away.
  InertialFilter filter({},
                        make_pose(flight.at(0).translation() + Vector3(0.08, 0.08, 0), Eigen::Quaterniond::Identity()));
  filter.predict(flight.imu(kGridImuTick));
  take();
  matcher.match(filter, {});
  EXPECT_LT((filter.T_local_body().translation() - flight.at(0).translation()).head<2>().norm(), 0.07);
}

Pose circling(double t_s) {
  const double ramp_s = t_s < 1.0 ? 0.5 * t_s * t_s : t_s - 0.5, angle = 0.5 * ramp_s;
  return make_pose({2.5 * std::cos(angle) - 2.5, 2.5 * std::sin(angle), 1.5 + 0.3 * std::sin(0.7 * ramp_s)},
                   rotation_by({0, 0, angle}) * rotation_by({0.05 * std::sin(ramp_s), 0, 0}));
}

TEST(GridMatcher, TracksPathThroughRoom) {
  GridFlight flight(kWorkshop, circling);
  flight.flight.gyro_bias_radps = {0.004, -0.003, 0.005};
  flight.flight.accel_bias_mps2 = {0.05, -0.04, 0.06};
  flight.fly(150);
  double worst_m = 0.0;
  for (const double off_m : flight.off_m) worst_m = std::max(worst_m, off_m);
  EXPECT_LT(worst_m, 0.25) << "half a coarse cell";
  const Matrix6 covariance = flight.slam.pose_covariance(flight.slam.filter(), 0.0);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(covariance).eigenvalues().minCoeff(), 0.0);
  EXPECT_LT(std::sqrt(covariance.diagonal().head<3>().maxCoeff()), 0.5);
  EXPECT_EQ(flight.outcomes.back().fit.num_degenerate, 0);
}

TEST(GridMatcher, DetectsDegenerateAisleButNotRoom) {
  SyntheticRoom aisle = SyntheticRoom::box({-300.0, -2.1, -0.2}, {300.0, 2.2, 3.7});
  GridFlight flight(aisle, at_rest);
  flight.fly(100);
  int num_open = 0;  // from the fifth scan in the map on; one goes in every half second
  for (std::size_t i = 30; i < flight.outcomes.size(); ++i) num_open += flight.outcomes[i].fit.num_degenerate == 1;
  EXPECT_GT(num_open, 50);
  GridFlight room(kWorkshop, circling);
  room.fly(40);
  for (const ScanOutcome& outcome : room.outcomes) EXPECT_EQ(outcome.fit.num_degenerate, 0);
}

TEST(GridMatcher, IgnoresScansOfUnknownSpace) {
  GridFlight flight(kWorkshop, at_rest);
  flight.fly(5);
  // Far away from the map.
  InertialFilter elsewhere({}, make_pose({200, 0, 0}, Eigen::Quaterniond::Identity()));
  elsewhere.predict(flight.flight.imu(kGridImuTick));
  auto& matcher = const_cast<ScanMatcher&>(flight.slam.matcher());
  const ScanMatcher::Match match = matcher.match(elsewhere, {.known_share_min = 0.3});
  EXPECT_EQ(match.fit.num_known, 0);
  EXPECT_GT(match.fit.num_points, 100);
  EXPECT_GT(match.num_iterations, 0);
  EXPECT_EQ(elsewhere.T_local_body().translation(), Vector3(200, 0, 0));
}

InertialFilter in_flight() {
  InertialFilter filter({}, make_pose({1, 2, 3}, rotation_by({0.1, -0.2, 0.5})));
  for (int i = 1; i < 50; ++i) {
    filter.predict(
        {.t = i * kGridImuTick, .omega_body_radps = {0.1, 0.05, -0.2}, .specific_force_body_mps2 = {0.3, 0.1, 9.9}});
  }
  return filter;
}

Matrix6 random_spd(std::mt19937& random) {
  const Vector6 scale = (Vector6() << 30, 30, 30, 300, 300, 300).finished();
  return scale.asDiagonal() * testing::random_information(random) * scale.asDiagonal();
}

// With the Kalman gain the update equals that by evidence of the same information.
TEST(InertialFilterTake, EqualsEvidenceUpdateWithBestGain) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 10; ++trial) {
    InertialFilter weighed = in_flight(), updated = in_flight();
    const Matrix6 P = weighed.pose_covariance(), information = random_spd(random);
    InertialFilter::WeighedPose pose;
    pose.slope = pose.scatter = information;
    pose.gain = P * information * (information * P * information + information).inverse();
    pose.contribution = 1e-3 * information * Vector6(0.5, -0.2, 0.3, 0.01, -0.02, 0.03);
    pose.moved = pose.gain * pose.contribution;
    weighed.take(pose);
    updated.update([&](const Pose&) { return PoseEvidence{information, -pose.contribution}; }, 0);
    EXPECT_LT((weighed.covariance() - updated.covariance()).norm(), 1e-6 * updated.covariance().norm());
    InertialFilter moved = in_flight();
    bool first = true;
    moved.update(
        [&](const Pose&) {  // linear: the gradient at the second iterate is that of the first one, moved along
          const Vector6 at = first ? Vector6(Vector6::Zero()) : pose.moved;
          first = false;
          return PoseEvidence{information, information * at - pose.contribution};
        },
        1);
    EXPECT_LT((weighed.state().nav.p_m - moved.state().nav.p_m).norm(), 1e-8);
    EXPECT_LT((weighed.state().nav.v_mps - moved.state().nav.v_mps).norm(), 1e-8);
    EXPECT_LT((weighed.state().gyro_bias_body_radps - moved.state().gyro_bias_body_radps).norm(), 1e-8);
  }
}

}  // namespace
}  // namespace swiftlet
