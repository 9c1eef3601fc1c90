// SPDX-License-Identifier: BSD-3-Clause
// When a scan counts, when it goes into the map, and what the map may have drifted.
#include "core/slam/matching/local_slam.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "tests/core/slam/synthetic_room.hpp"

namespace swiftlet {
namespace {

using testing::SyntheticFlight;
using testing::SyntheticRoom;

constexpr TimeNs kImuTick = 4'000'000, kLidarTick = 100'000'000;

const SyntheticRoom kStore = SyntheticRoom::box({-6.3, -5.1, -0.2}, {7.4, 6.2, 4.7});

SyntheticFlight flight_in(const SyntheticRoom& room, SyntheticFlight::PoseAt at) {
  SyntheticFlight flight(room, std::move(at));
  flight.sigma_range_m = 0.005;
  return flight;
}

Pose standing(double) { return make_pose({0, 0, 1.5}, Eigen::Quaterniond::Identity()); }

/// Every scan is matched once, so that what it does is seen at once.
LocalSlamConfig from_the_first_scan_on() {
  LocalSlamConfig config;
  config.start_scans = 0;
  return config;
}

const SurfaceMap& map_of(const LocalSlam& slam) { return dynamic_cast<const SurfaceMatcher&>(slam.matcher()).map(); }

/// Outcomes of so many scans, with the IMU between them.
std::vector<ScanOutcome> outcomes_of(LocalSlam& slam, SyntheticFlight& flight, int num_scans) {
  std::vector<ScanOutcome> outcomes;
  for (TimeNs t = kImuTick; static_cast<int>(outcomes.size()) < num_scans; t += kImuTick) {
    slam.add(flight.imu(t));
    if (t % kLidarTick == 0) outcomes.push_back(slam.add(flight.scan(t)));
  }
  return outcomes;
}

std::vector<int> inserted_scans(const std::vector<ScanOutcome>& outcomes) {
  std::vector<int> inserted;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    if (outcomes[i].inserted) inserted.push_back(static_cast<int>(i) + 1);
  }
  return inserted;
}

std::vector<int> first_ten_and(std::vector<int> others) {
  std::vector<int> all;
  for (int i = 1; i <= 10; ++i) all.push_back(i);
  all.insert(all.end(), others.begin(), others.end());
  return all;
}

/// Returns that local SLAM kept of the last scan near a place, which others fly by at the end of that scan.
int kept_near(const Vector3& place_m, const std::vector<SeenVehicle>& others, double vehicle_radius_m = 1.0) {
  SyntheticFlight flight = flight_in(kStore, standing);
  LocalSlamConfig config = from_the_first_scan_on();
  config.vehicle_radius_m = vehicle_radius_m;
  LocalSlam slam(config, flight.at(0), 0.3);
  for (TimeNs t = kImuTick; t <= 3 * kLidarTick; t += kImuTick) {
    slam.add(flight.imu(t));
    if (t % kLidarTick == 0) slam.add(flight.scan(t), others);
  }
  int kept = 0;
  for (const Eigen::Vector3f& p : slam.points_body_m()) {
    kept += (slam.filter().T_local_body() * p.cast<double>() - place_m).norm() < 0.9;
  }
  return kept;
}

TEST(LocalSlam, IgnoresReturnsFromOtherVehicles) {
  const Vector3 on_wall_m(7.4, 1.0, 1.5);  // reported position of a vehicle
  const int all = kept_near(on_wall_m, {});
  ASSERT_GT(all, 20);
  constexpr TimeNs kSeen = 3 * kLidarTick - 200'000'000;
  EXPECT_EQ(kept_near(on_wall_m, {{kSeen, on_wall_m, Vector3::Zero()}}), 0);
  EXPECT_EQ(kept_near(on_wall_m, {{kSeen, on_wall_m - 0.2 * Vector3(0, 5, 0), Vector3(0, 5, 0)}}), 0)
      << "propagated by its velocity";
  EXPECT_EQ(kept_near(on_wall_m, {{kSeen, on_wall_m - Vector3(0, 4, 0), Vector3::Zero()}}), all);
  EXPECT_EQ(kept_near(on_wall_m, {{kSeen, on_wall_m, Vector3::Zero()}}, 0.0), all) << "the filter is off";
  EXPECT_EQ(kept_near(on_wall_m, {{-2'000'000'000, on_wall_m, Vector3::Zero()}}), all) << "an old sighting";
  EXPECT_EQ(kept_near(on_wall_m, {{kSeen, Vector3::Constant(NAN), Vector3::Zero()}}), all);
}

TEST(LocalSlam, InsertsScansEverySecondAtRest) {
  SyntheticFlight flight = flight_in(kStore, standing);
  LocalSlam slam(from_the_first_scan_on(), flight.at(0), 0.3);
  EXPECT_TRUE(slam.started());
  const auto outcomes = outcomes_of(slam, flight, 41);
  EXPECT_EQ(inserted_scans(outcomes), first_ten_and({20, 30, 40}));
  EXPECT_EQ(slam.inserted_at().t, 40 * kLidarTick);
  for (const ScanOutcome& outcome : outcomes) EXPECT_TRUE(outcome.used);
  EXPECT_EQ(outcomes.front().num_iterations, 0) << "the first scan begins the map without matching";
  EXPECT_GT(outcomes.back().num_iterations, 0);
}

TEST(LocalSlam, FirstSampleCountsFromTheStart) {
  const ImuSample turning{20'000'000, {0.0, 0.0, 1.5}, {0.0, 0.0, 9.80665}};
  const auto turned_rad = [&](std::optional<TimeNs> start) {
    LocalSlam slam(LocalSlamConfig{}, Pose::Identity(), 0.3);
    if (start) slam.begin_at(*start);
    slam.add(turning);
    return rotation_vector_rad(slam.filter().state().nav.q).z();
  };
  EXPECT_NEAR(turned_rad(0), 0.03, 1e-9);
  EXPECT_NEAR(turned_rad(10'000'000), 0.015, 1e-9);
  EXPECT_EQ(turned_rad(30'000'000), 0.0) << "clocks that disagree";
  EXPECT_EQ(turned_rad(-1'000'000'000), 0.0) << "the IMU begins late";
  EXPECT_EQ(turned_rad(std::nullopt), 0.0);
}

TEST(LocalSlam, IgnoresScansWithoutImu) {
  SyntheticFlight flight = flight_in(kStore, standing);
  LocalSlam slam(from_the_first_scan_on(), flight.at(0), 0.3);
  const ScanOutcome outcome = slam.add(flight.scan(kLidarTick));
  EXPECT_FALSE(outcome.used || outcome.inserted);
  EXPECT_EQ(map_of(slam).num_cells(), 0U);
}

TEST(LocalSlam, RespectsItsPointLimit) {
  LocalSlamConfig config = from_the_first_scan_on();
  config.match_points = 333;
  config.map_points = 444;
  for (const int num_scans : {10, 11}) {
    SyntheticFlight flight = flight_in(kStore, standing);
    LocalSlam slam(config, flight.at(0), 0.3);
    EXPECT_EQ(outcomes_of(slam, flight, num_scans).back().fit.num_points, 333);
    if (num_scans == 10) {
      EXPECT_GT(slam.points_body_m().size(), 444U) << "the first ones make the map";
      continue;
    }
    ASSERT_EQ(slam.points_body_m().size(), 444U);
    // Points from all around, not the first ones.
    int ahead = 0, behind = 0;
    for (const Eigen::Vector3f& p : slam.points_body_m()) ++(p.x() > 0.0F ? ahead : behind);
    EXPECT_GT(std::min(ahead, behind), 100);
  }
}

TEST(LocalSlam, RebuildsMapWhileSpeedIsUnknown) {
  // A scan is smeared while the velocity is uncertain, so its points do not stay in the map.
  const auto points_of_a_wall = [](double sigma_mps) {
    LocalSlamConfig config = from_the_first_scan_on();
    config.imu.start_velocity_sigma_mps = sigma_mps;
    SyntheticFlight flight = flight_in(kStore, standing);
    LocalSlam slam(config, flight.at(0), 0.3);
    outcomes_of(slam, flight, 2);
    const SurfaceCell* cell = map_of(slam).find({-6.3, 0.5, 1.4}, Vector3::Zero());
    return cell == nullptr ? 0.0F : cell->count;
  };
  EXPECT_GT(points_of_a_wall(0.1), 1.6F * points_of_a_wall(1.0));
  EXPECT_GT(points_of_a_wall(1.0), 20.0F);
}

TEST(LocalSlam, RestartsWithKnowledgeFromFirstScans) {
  LocalSlamConfig config;
  config.start_scans = 3;
  SyntheticFlight flight = flight_in(kStore, standing);
  flight.gyro_bias_radps = {0.02, -0.02, 0.03};
  LocalSlam slam(config, flight.at(0), 0.3);
  outcomes_of(slam, flight, 2);
  EXPECT_FALSE(slam.started());
  const double sigma_before =
      std::sqrt(slam.filter().covariance()(InertialFilter::kGyroBias, InertialFilter::kGyroBias));
  LocalSlam started(config, flight.at(0), 0.3);
  SyntheticFlight again = flight_in(kStore, standing);
  again.gyro_bias_radps = flight.gyro_bias_radps;
  outcomes_of(started, again, 3);
  EXPECT_TRUE(started.started());
  EXPECT_EQ(started.filter().state().nav.t, 3 * kLidarTick);
  EXPECT_LT((started.filter().state().gyro_bias_body_radps - again.gyro_bias_radps).norm(), 0.01);
  EXPECT_LT(std::sqrt(started.filter().covariance()(InertialFilter::kGyroBias, InertialFilter::kGyroBias)),
            sigma_before);
}

TEST(LocalSlam, UncertaintyExceedsFilterAndSettles) {
  SyntheticFlight flight = flight_in(kStore, standing);
  LocalSlam slam(from_the_first_scan_on(), flight.at(0), 0.3);
  outcomes_of(slam, flight, 5);
  const Matrix6 after_5 = slam.pose_covariance(slam.filter(), 0.0) - slam.filter().pose_covariance();
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(after_5).eigenvalues().minCoeff(), 0.0);
  EXPECT_LT(std::sqrt(after_5.diagonal().head<3>().maxCoeff()), 0.03);
  LocalSlam longer(from_the_first_scan_on(), flight.at(0), 0.3);
  SyntheticFlight again = flight_in(kStore, standing);
  outcomes_of(longer, again, 60);
  const Matrix6 after_60 = longer.pose_covariance(longer.filter(), 0.0) - longer.filter().pose_covariance();
  EXPECT_LT(after_60.trace(), 4.0 * after_5.trace()) << "a map that is known is not renewed over and over";
}

// Each inherited error is transformed by the lever from its place; the covariances add up.
TEST(MapDrift, SumsInheritedErrorsAlongTheWay) {
  const Vector3 start_m(1, 2, 3);
  MapDrift drift(start_m);
  EXPECT_TRUE(drift.covariance(Matrix3::Identity()).isZero());
  struct Source {
    Vector3 at_m;
    Matrix6 covariance;  // local axes
  };
  std::vector<Source> sources;
  Vector3 p_m = start_m;
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, 0.1);
  for (int i = 0; i < 25; ++i) {
    p_m += Vector3(std::cos(0.4 * i), 0.7 * std::sin(0.9 * i), 0.2 * (i % 3));
    drift.move_to(p_m);
    const Matrix3 R = rotation_by({0.1 * i, -0.2, 0.3}).toRotationMatrix();
    Matrix6 turn = Matrix6::Identity(), root = Matrix6::Zero();
    turn.bottomRightCorner<3, 3>() = R;
    for (double& x : root.reshaped()) x = normal(random);
    const Matrix6 inherited = root * root.transpose();
    drift.inherit(inherited, R);
    sources.push_back({p_m, turn * inherited * turn.transpose()});
    Matrix6 expected = Matrix6::Zero();
    for (const Source& source : sources) {
      // A turn by phi moves what lies by d away by phi x d.
      Matrix6 carried = Matrix6::Identity();
      carried.topRightCorner<3, 3>() = -skew_of(p_m - source.at_m);
      expected += carried * source.covariance * carried.transpose();
    }
    expected = (turn.transpose() * expected * turn).eval();
    EXPECT_LT((drift.covariance(R) - expected).norm(), 1e-9 * expected.norm()) << i;
  }
}

}  // namespace
}  // namespace swiftlet
