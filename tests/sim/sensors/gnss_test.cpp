// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/gnss.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/sample_statistics.hpp"
#include "tests/support/sensor_driver.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

constexpr DriveOptions kSlow{.duration_s = 60.0, .tick = 100'000'000, .step = 100'000'000, .capacity = 8};

GnssConfig perfect_gnss() {
  GnssConfig config;
  config.rate_hz = 10.0;
  config.sigma_xy_m = config.sigma_z_m = config.drift_sigma_xy_m = config.drift_sigma_z_m = 0.0;
  config.altitude_walk_m_psqrts = config.sigma_velocity_xy_mps = config.sigma_velocity_z_mps = 0.0;
  config.multipath_sigma_m = 0.0;
  return config;
}

TEST(Gnss, WithoutNoiseGivesTheAntenna) {
  GnssConfig config = perfect_gnss();
  config.position_m = {0.1, 0.0, 0.2};
  const double rate = 2.0;
  const Motion turning = [&](double t) {
    VehicleState state = state_at({1.0 + t, 2.0, 3.0}, rate * t);
    state.v_world_mps = {1.0, 0.0, 0.0};
    state.omega_body_radps.z() = rate;
    return state;
  };
  const auto sensor = make_gnss_sensor(config, sensor_setup("gnss"));
  const Observation seen = drive(*sensor, {turning}, {});
  ASSERT_EQ(seen.gnss.size(), 11U);
  for (const GnssSample& sample : seen.gnss) {
    const double t = to_seconds(sample.t);
    const Vector3 lever(0.1 * std::cos(rate * t), 0.1 * std::sin(rate * t), 0.2);
    EXPECT_NEAR((sample.p_world_m - Vector3(1.0 + t, 2.0, 3.0) - lever).norm(), 0.0, 1e-9);
    const Vector3 v_lever(-rate * lever.y(), rate * lever.x(), 0.0);
    EXPECT_NEAR((sample.v_world_mps - Vector3(1.0, 0.0, 0.0) - v_lever).norm(), 0.0, 1e-9);
  }
}

TEST(Gnss, ErrorsMatchTheirSigmaAndCorrelation) {
  const GnssConfig config = [] {
    GnssConfig c;
    c.rate_hz = 1.0;
    c.altitude_walk_m_psqrts = 0.0;
    return c;
  }();
  SampleStatistics east, up, velocity, east_product;
  Vector3 sigma = Vector3::Zero();
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const auto sensor = make_gnss_sensor(config, sensor_setup("gnss", seed));
    const Observation seen = drive(*sensor, {resting(Vector3::Zero())},
                                   {.duration_s = 60.0, .tick = 1'000'000'000, .step = 1'000'000'000, .capacity = 4});
    ASSERT_EQ(seen.gnss.size(), 61U);
    east.add(seen.gnss[60].p_world_m.x());
    up.add(seen.gnss[60].p_world_m.z());
    velocity.add(seen.gnss[60].v_world_mps.y());
    east_product.add(seen.gnss[0].p_world_m.x() * seen.gnss[60].p_world_m.x());
    sigma = seen.gnss[60].sigma_p_m;
  }
  const double v_east = 0.3 * 0.3 + 1.5 * 1.5;
  const double v_up = 0.5 * 0.5 + 2.0 * 2.0;
  EXPECT_NEAR(east.variance(), v_east, variance_bound(v_east, east.size()));
  EXPECT_NEAR(up.variance(), v_up, variance_bound(v_up, up.size()));
  EXPECT_NEAR(velocity.variance(), 0.01, variance_bound(0.01, velocity.size()));
  EXPECT_NEAR((sigma - Vector3(std::sqrt(v_east), std::sqrt(v_east), std::sqrt(v_up))).norm(), 0.0, 1e-12);
  // One correlation time apart only the drift is still alike, by 1/e.
  const double covariance = 1.5 * 1.5 * std::exp(-1.0);
  EXPECT_NEAR(east_product.mean(), covariance,
              mean_bound(std::sqrt(v_east * v_east + covariance * covariance), east_product.size()));
}

TEST(Gnss, AltitudeDriftsAsARandomWalk) {
  GnssConfig config = perfect_gnss();
  config.rate_hz = 1.0;
  config.altitude_walk_m_psqrts = 0.05;
  SampleStatistics landing;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const auto sensor = make_gnss_sensor(config, sensor_setup("gnss", seed));
    const Observation seen = drive(*sensor, {resting(Vector3::Zero())},
                                   {.duration_s = 240.0, .tick = 1'000'000'000, .step = 1'000'000'000, .capacity = 4});
    EXPECT_EQ(seen.gnss.front().p_world_m.z(), 0.0);
    EXPECT_EQ(seen.gnss.back().p_world_m.x(), 0.0);
    landing.add(seen.gnss.back().p_world_m.z());
  }
  const double variance = 0.05 * 0.05 * 240.0;  // 0.77 m after four minutes
  EXPECT_NEAR(landing.variance(), variance, variance_bound(variance, landing.size()));
}

TEST(Gnss, GivesNoFixInPlannedOutages) {
  GnssConfig config = perfect_gnss();
  config.outages = {{10.0, 12.0}, {20.0, 20.5}};
  const auto sensor = make_gnss_sensor(config, sensor_setup("gnss"));
  const Observation seen = drive(*sensor, {resting(Vector3::Zero())}, kSlow);
  EXPECT_EQ(seen.gnss.size(), 601U - 20U - 5U);
  for (const GnssSample& sample : seen.gnss) {
    const double t = to_seconds(sample.t);
    EXPECT_FALSE((t >= 10.0 && t < 12.0) || (t >= 20.0 && t < 20.5)) << t;
  }
}

TEST(Gnss, RandomOutagesMatchTheirTimeShare) {
  GnssConfig config = perfect_gnss();
  config.random_outages_per_min = 6.0;  // 10 s with a fix
  config.random_outage_mean_s = 5.0;
  SampleStatistics share;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const auto sensor = make_gnss_sensor(config, sensor_setup("gnss", seed));
    DriveOptions options = kSlow;
    options.duration_s = 300.0;
    int late = 0;  // the process starts with a fix: count when it has forgotten that
    for (const GnssSample& sample : drive(*sensor, {resting(Vector3::Zero())}, options).gnss) {
      late += sample.t > 60 * kNsPerSecond;
    }
    share.add(late / 2400.0);
  }
  EXPECT_NEAR(share.mean(), 10.0 / 15.0, mean_bound(share.sigma(), share.size()));
  EXPECT_GT(share.sigma(), 0.0);
}

TEST(Gnss, CanyonsDegradeAndRoofsBlockFixes) {
  GnssConfig config;
  config.rate_hz = 10.0;
  config.sky_view = true;
  TestScene open, canyon, roof;
  open.add_wall({-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0});
  canyon.add_box({-100, 3, 0}, {100, 5, 6});
  canyon.add_box({-100, -5, 0}, {100, -3, 6});
  roof.add_wall({-100, -100, 10}, {100, -100, 10}, {100, 100, 10}, {-100, 100, 10});
  const auto fixes = [&](const TestScene& world) {
    const auto sensor =
        make_gnss_sensor(config, sensor_setup("gnss", 1, 1, std::make_shared<const StaticScene>(world.scene())));
    return drive(*sensor, {resting({0.0, 0.0, 1.5})}, {}).gnss;
  };
  const auto in_the_open = fixes(open);
  const auto in_the_canyon = fixes(canyon);
  ASSERT_EQ(in_the_open.size(), 11U);
  ASSERT_EQ(in_the_canyon.size(), 11U);
  EXPECT_NEAR(in_the_open[0].sigma_p_m.x(), std::hypot(0.3, 1.5), 1e-12);
  EXPECT_GT(in_the_canyon[0].sigma_p_m.x(), 1.5 * in_the_open[0].sigma_p_m.x());
  EXPECT_TRUE(fixes(roof).empty());
}

// The satellites are spread over the sky above the mask, so a wall all around that ends below the mask hides none.
TEST(Gnss, IgnoresWallsBelowTheElevationMask) {
  GnssConfig config;
  config.sky_view = true;
  config.num_satellites = 30;
  config.elevation_mask_deg = 20.0;
  const auto sigma_m = [&](double wall_top_deg) {
    TestScene world;
    const auto top_m = static_cast<float>(1.5 + 40.0 * std::tan(wall_top_deg * std::numbers::pi / 180.0));
    constexpr int kSides = 24;
    for (int i = 0; i < kSides; ++i) {
      const auto corner = [&](int k, float z) {
        const double angle = 2.0 * std::numbers::pi * k / kSides;
        return Eigen::Vector3f(static_cast<float>(40.0 * std::cos(angle)), static_cast<float>(40.0 * std::sin(angle)),
                               z);
      };
      world.add_wall(corner(i, 0.0F), corner(i + 1, 0.0F), corner(i + 1, top_m), corner(i, top_m));
    }
    const auto sensor =
        make_gnss_sensor(config, sensor_setup("gnss", 1, 1, std::make_shared<const StaticScene>(world.scene())));
    const auto fixes = drive(*sensor, {resting({0.0, 0.0, 1.5})}, {}).gnss;
    EXPECT_FALSE(fixes.empty());
    return fixes.empty() ? 0.0 : fixes[0].sigma_p_m.x();
  };
  const double open_m = sigma_m(1.0);
  EXPECT_EQ(sigma_m(19.5), open_m);
  EXPECT_GT(sigma_m(30.0), open_m);
}

}  // namespace
}  // namespace swiftlet::sim
