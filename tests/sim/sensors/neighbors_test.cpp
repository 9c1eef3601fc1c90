// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/neighbors.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "swiftlet/core/math/angles.hpp"
#include "tests/support/sample_statistics.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

NeighborsConfig exact_neighbors() {
  NeighborsConfig config;
  config.sigma_bearing_deg = config.sigma_range_m = config.sigma_range_relative = config.dropout_probability = 0.0;
  config.range_max_m = 100.0;
  return config;
}

std::vector<NeighborSample> see(const NeighborsConfig& config, const std::vector<Motion>& motions,
                                double duration_s = 0.1, std::shared_ptr<const StaticScene> world = nullptr,
                                std::uint64_t seed = 1) {
  const auto sensor = make_neighbors_sensor(
      config, sensor_setup("neighbors", seed, static_cast<int>(motions.size()), std::move(world)));
  return drive(*sensor, motions, {.duration_s = duration_s}).neighbors;
}

std::vector<VehicleId> seen_at_start(const NeighborsConfig& config, const std::vector<Motion>& motions,
                                     std::shared_ptr<const StaticScene> world = nullptr) {
  std::vector<VehicleId> ids;
  for (const NeighborSample& sample : see(config, motions, 0.004, std::move(world))) ids.push_back(sample.id);
  return ids;
}

TEST(Neighbors, AreExactInBodyWithoutNoise) {
  const Motion observer = resting({1.0, 1.0, 5.0}, std::numbers::pi / 2.0);  // looks along y
  const Motion other = straight({1.0, 4.0, 6.0}, {1.0, 0.0, 0.0});
  const auto seen = see(exact_neighbors(), {observer, other}, 1.0);
  ASSERT_EQ(seen.size(), 11U);
  for (const NeighborSample& sample : seen) {
    EXPECT_EQ(sample.id, 1);
    EXPECT_NEAR((sample.p_body_m - Vector3(3.0, -to_seconds(sample.t), 1.0)).norm(), 0.0, 1e-9);
  }
}

TEST(Neighbors, IdealIgnoresRangeViewAndWorld) {
  NeighborsConfig config;
  config.ideal = true;
  TestScene wall;
  wall.add_box({5, -50, -50}, {6, 50, 50});
  const auto seen = see(config, {resting(Vector3::Zero()), resting({80.0, 0.0, 0.0}), resting({0.0, 0.0, 10.0})}, 0.004,
                        std::make_shared<const StaticScene>(wall.scene()));
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[0].p_body_m, Vector3(80.0, 0.0, 0.0));
  EXPECT_EQ(seen[1].p_body_m, Vector3(0.0, 0.0, 10.0));
}

TEST(Neighbors, HaveStatedRadialAndLateralErrors) {
  NeighborsConfig config = exact_neighbors();
  config.sigma_bearing_deg = 1.0;
  config.sigma_range_m = 0.1;
  config.sigma_range_relative = 0.1;
  const Vector3 truth(8.0, 6.0, 0.0);
  SampleStatistics along, across, up, mahalanobis;
  for (const NeighborSample& sample : see(config, {resting(Vector3::Zero()), resting(truth)}, 400.0)) {
    along.add(sample.p_body_m.norm() - 10.0);
    const Vector3 bearing = sample.p_body_m.normalized();
    across.add(std::atan2(bearing.y(), bearing.x()) - std::atan2(6.0, 8.0));
    up.add(std::asin(bearing.z()));
    const Vector3 error = sample.p_body_m - truth;
    mahalanobis.add(error.dot(sample.covariance_body.inverse() * error));
  }
  ASSERT_EQ(along.size(), 4001);
  const double v_range = 0.01 + 1.0;
  const double v_bearing = kRadPerDeg * kRadPerDeg;
  EXPECT_NEAR(along.variance(), v_range, variance_bound(v_range, along.size()));
  EXPECT_NEAR(across.variance(), v_bearing, variance_bound(v_bearing, across.size()));
  EXPECT_NEAR(up.variance(), v_bearing, variance_bound(v_bearing, up.size()));
  // Consistent: mean 3, but for the covariance being taken at the measured range (spread of 10 %: up by 1 + 3 * 0.01).
  EXPECT_NEAR(mahalanobis.mean(), 3.0, mean_bound(std::sqrt(6.0), mahalanobis.size()) + 0.15);
}

TEST(Neighbors, AreSeenWithinRangeOnly) {
  NeighborsConfig config = exact_neighbors();
  config.range_max_m = 15.0;
  config.occlusion = false;
  const std::vector<Motion> motions = {resting(Vector3::Zero()), resting({14.9, 0.0, 0.0}), resting({0.0, 15.1, 0.0}),
                                       resting({0.0, 0.0, 0.2})};
  EXPECT_EQ(seen_at_start(config, motions), std::vector<VehicleId>{1});
}

TEST(Neighbors, AreLimitedToFieldOfView) {
  NeighborsConfig config = exact_neighbors();
  config.elevation_min_deg = -30.0;
  config.elevation_max_deg = 45.0;
  const auto bearing = [](double azimuth_deg, double elevation_deg) {
    return resting(5.0 * Vector3(std::cos(elevation_deg * kRadPerDeg) * std::cos(azimuth_deg * kRadPerDeg),
                                 std::cos(elevation_deg * kRadPerDeg) * std::sin(azimuth_deg * kRadPerDeg),
                                 std::sin(elevation_deg * kRadPerDeg)));
  };
  const std::vector<Motion> motions = {resting(Vector3::Zero()), bearing(0.0, 0.0),    bearing(180.0, 44.0),
                                       bearing(90.0, 46.0),      bearing(10.0, -31.0), bearing(60.0, 0.0)};
  EXPECT_EQ(seen_at_start(config, motions), (std::vector<VehicleId>{1, 2, 5}));
  config.cameras = {{.yaw_deg = 0.0, .pitch_deg = 0.0, .fov_deg = 100.0},
                    {.yaw_deg = 90.0, .pitch_deg = 40.0, .fov_deg = 20.0}};
  EXPECT_EQ(seen_at_start(config, motions), (std::vector<VehicleId>{1, 3, 4}));
}

TEST(Neighbors, AreHiddenByWorldAndVehicles) {
  TestScene wall;
  wall.add_box({5, 0, -5}, {6, 10, 5});
  const auto world = std::make_shared<const StaticScene>(wall.scene());
  NeighborsConfig config = exact_neighbors();
  const std::vector<Motion> motions = {resting(Vector3::Zero()), resting({10.0, 1.0, 0.0}), resting({10.0, -1.0, 0.0}),
                                       resting({-3.0, 0.2, 0.0}), resting({-9.0, 0.0, 0.0})};
  // 1 is behind the wall; 4 is behind 3, which passes within half of its radius of 0.5 m.
  EXPECT_EQ(seen_at_start(config, motions, world), (std::vector<VehicleId>{2, 3}));
  config.occlusion = false;
  EXPECT_EQ(seen_at_start(config, motions, world), (std::vector<VehicleId>{1, 2, 3, 4}));
}

TEST(Neighbors, AreMissedAtDropoutRate) {
  NeighborsConfig config = exact_neighbors();
  config.dropout_probability = 0.3;
  const int n = 5001;
  const auto seen = see(config, {resting(Vector3::Zero()), resting({5.0, 0.0, 0.0})}, 500.0);
  EXPECT_NEAR(static_cast<double>(seen.size()) / n, 0.7, share_bound(0.7, n));
}

TEST(Neighbors, SwapIdsAtRateWithoutMoving) {
  NeighborsConfig config = exact_neighbors();
  config.id_swap_probability = 0.05;
  const auto seen = see(config, {resting(Vector3::Zero()), resting({5.0, 0.0, 0.0}), resting({0.0, 5.0, 0.0})}, 400.0);
  ASSERT_EQ(seen.size(), 2U * 4001U);
  int swapped = 0;
  for (std::size_t i = 0; i < seen.size(); i += 2) {
    EXPECT_EQ(seen[i].p_body_m.x(), 5.0);
    EXPECT_NE(seen[i].id, seen[i + 1].id);
    swapped += seen[i].id != 1;
  }
  const double p = 2.0 * 0.05 * 0.95;  // two draws; both together change nothing
  EXPECT_NEAR(swapped / 4001.0, p, share_bound(p, 4001));
}

TEST(Neighbors, AnotherVehicleChangesNoOtherMeasurement) {
  NeighborsConfig config;
  config.dropout_probability = 0.2;
  const std::vector<Motion> two = {resting(Vector3::Zero()), resting({5.0, 0.0, 0.0})};
  std::vector<Motion> three = two;
  three.push_back(resting({0.0, 5.0, 0.0}));
  const auto alone = see(config, two, 10.0);
  auto crowded = see(config, three, 10.0);
  crowded.erase(std::remove_if(crowded.begin(), crowded.end(), [](const NeighborSample& s) { return s.id == 2; }),
                crowded.end());
  ASSERT_EQ(crowded.size(), alone.size());
  for (std::size_t i = 0; i < alone.size(); ++i) EXPECT_EQ(crowded[i].p_body_m, alone[i].p_body_m);
}

}  // namespace
}  // namespace swiftlet::sim
