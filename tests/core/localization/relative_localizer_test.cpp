// SPDX-License-Identifier: BSD-3-Clause
// The stage as the stack uses it: messages and detections in, where the other vehicle is out.
#include "swiftlet/core/localization/relative_localizer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "swiftlet/core/stage_tables/relative_localizers.hpp"
#include "tests/core/localization/relative_support.hpp"

namespace swiftlet {
namespace {

constexpr double kTick_s = 0.05;
constexpr VehicleId kOther = 1;

SlidingWindowConfig looking_for_uav2() {
  SlidingWindowConfig config;
  config.other = "uav2";
  config.source = SlidingWindowConfig::Source::kDetections;
  return config;
}

AgentSetup three_vehicles() {
  AgentSetup setup;
  setup.vehicle_names = {"uav1", "uav2", "uav3"};
  setup.num_vehicles = 3;
  return setup;
}

std::unique_ptr<RelativeLocalizer> localizer_of(const SlidingWindowConfig& config) {
  Module module(relative_localizer_module_types(), "sliding_window");
  module.as<SlidingWindowConfig>() = config;
  return make_relative_localizer(module, three_vehicles());
}

/// An observer at rest with the reports and sightings of a flight.
struct Team {
  SlidingWindowConfig config = looking_for_uav2();
  Path path = eight();
  OdometryDriftConfig drift;
  double marker = 18.0;  // brightest return of the other vehicle
  double sighting_latency_s = 0.15, odometry_latency_s = 0.1;
  double clock_offset_s = 0.0, clock_drift = 0.0;
  double unseen_from_s = 1e9, seen_again_s = 1e9;
  double false_share = 0.0;
  bool third_beside = false;  // another vehicle without markers
  VehicleId sender = kOther;

  struct Result {
    std::vector<double> errors_m, yaw_errors_rad, nees, sigmas_m;
    double first_s = std::numeric_limits<double>::infinity();
    double known_at_end = false;
  };

  Result fly(double duration_s, std::uint64_t seed = 1) const {
    const OtherFlight flight(path, duration_s + 1.0, drift, seed);
    const Random random(seed, "test.localizer", "noise");
    const auto localizer = localizer_of(config);
    StateEstimate estimate;
    estimate.valid = true;
    LocalPoses poses;
    Outbox outbox(0);
    Result result;
    for (int k = 20; k < static_cast<int>(duration_s / kTick_s); ++k) {
      const double now_s = k * kTick_s;
      estimate.t = from_seconds(now_s);
      poses.push(estimate);
      Observation observation;
      observation.t = estimate.t;
      if (k % 10 == 0) observation.messages.push_back(report(flight, now_s));
      std::vector<Detection> detections;
      if (k % 2 == 0) detect(flight, random, k, detections);
      std::vector<RelativeEstimate> found;
      localizer->step({.observation = observation, .estimate = estimate, .poses = poses, .detections = detections},
                      found, outbox);
      result.known_at_end = !found.empty();
      if (found.empty()) continue;
      EXPECT_EQ(found.front().other, kOther);
      EXPECT_EQ(found.front().t, estimate.t);
      result.first_s = std::min(result.first_s, now_s);
      const Vector3 error_m = found.front().position_m - flight.at(now_s).p_local_m;
      const Matrix3 C = found.front().covariance.topLeftCorner<3, 3>();
      result.errors_m.push_back(error_m.norm());
      result.sigmas_m.push_back(std::sqrt(C.trace()));
      result.nees.push_back(error_m.dot(C.ldlt().solve(error_m)));
      result.yaw_errors_rad.push_back(
          std::abs(std::remainder(found.front().yaw_rad - OtherFlight::kHeading_rad, 2 * kPi)));
    }
    return result;
  }

  Message report(const OtherFlight& flight, double now_s) const {
    const double t_s = now_s - odometry_latency_s;
    const OtherMotion& motion = flight.at(t_s).motion;
    return odometry_message(motion, sender, from_seconds(t_s * (1.0 + clock_drift) + clock_offset_s),
                            from_seconds(now_s));
  }
  void detect(const OtherFlight& flight, const Random& random, int k, std::vector<Detection>& detections) const {
    const double t_s = std::round((k * kTick_s - sighting_latency_s) / kTick_s) * kTick_s;
    if (t_s >= unseen_from_s && t_s < seen_again_s) return;
    Detection d;
    d.t = from_seconds(t_s);
    d.covariance = sighting_covariance();
    d.position_m = sighting_of(flight, t_s, d.covariance, random);
    d.reflectivity = marker;
    if (random.uniform(k, 40) < false_share) {
      d.position_m = {random.uniform(0, 10, k, 41), random.uniform(-4, 6, k, 42), random.uniform(-1, 2, k, 43)};
    }
    if (third_beside) {
      Detection third = d;
      third.position_m = d.position_m + Vector3(0.4, 0.6, 0.0);
      third.reflectivity = 0.3;
      detections.push_back(third);
    }
    detections.push_back(d);
  }
};

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value / static_cast<double>(values.size());
  return sum;
}
double greatest(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

TEST(RelativeLocalizer, RequiresCloudsOnlyForMarkerDetection) {
  using Source = SlidingWindowConfig::Source;
  for (const Source source : {Source::kDetections, Source::kTracks, Source::kMarkers}) {
    SlidingWindowConfig config;
    config.other = "uav2";
    config.source = source;
    EXPECT_EQ(localizer_of(config)->needs_clouds(), source == Source::kMarkers);
  }
}

TEST(RelativeLocalizer, LocalizesUnknownVehicleFromItsMotion) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Team::Result result = Team{}.fly(30.0, seed);
    EXPECT_LT(result.first_s, 10.0);
    EXPECT_LT(mean(result.errors_m), 0.08) << seed;
    EXPECT_LT(mean(result.yaw_errors_rad), 3.0 * kRadPerDeg) << seed;
  }
}

TEST(RelativeLocalizer, ItsCovarianceIsTrue) {
  std::vector<double> nees;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Team team;
    team.config.filter.bias_sigma_m = 0.0;
    const Team::Result result = team.fly(25.0, seed);
    if (!result.nees.empty()) nees.push_back(result.nees.back());
  }
  EXPECT_GE(nees.size(), 58U);
  // The flight is smoother than white acceleration, and its odometry has no noise but drift: the covariance is
  // conservative.
  EXPECT_LT(mean(nees), 3.0 + 3.3 * std::sqrt(6.0 / 60.0));
  EXPECT_GT(mean(nees), 1.0);
}

// Three times the assumed drift, which the filter has to estimate.
TEST(RelativeLocalizer, DetectsExcessOdometryDrift) {
  const auto fly = [](double drift_factor_max) {
    Team::Result all;
    for (std::uint64_t seed = 1; seed <= 15; ++seed) {
      Team team;
      team.drift.position_m_psqrtm *= 3.0;
      team.drift.yaw_deg_psqrtm *= 3.0;
      team.config.filter.drift_factor_max = drift_factor_max;
      const Team::Result result = team.fly(40.0, seed);
      all.errors_m.insert(all.errors_m.end(), result.errors_m.begin(), result.errors_m.end());
      all.nees.insert(all.nees.end(), result.nees.begin(), result.nees.end());
    }
    return all;
  };
  const Team::Result noticed = fly(10.0), trusting = fly(1.0);
  EXPECT_LT(mean(noticed.nees), 3.0);
  EXPECT_GT(mean(trusting.nees), 2.0 * mean(noticed.nees)) << "overconfident";
  EXPECT_LT(mean(noticed.errors_m), 0.75 * mean(trusting.errors_m));
}

TEST(RelativeLocalizer, StaysSilentBeforeTheVehicleMoves) {
  Team team;
  team.path = rest();
  EXPECT_TRUE(team.fly(30.0).errors_m.empty());
}

TEST(RelativeLocalizer, RejectsVehiclesWithoutMarkers) {
  Team team;
  team.marker = 0.5;
  EXPECT_TRUE(team.fly(30.0).errors_m.empty());
  team.config.marker_reflectivity = 0.0;
  EXPECT_FALSE(team.fly(30.0).errors_m.empty()) << "markers are optional";
}

TEST(RelativeLocalizer, IsUndisturbedByUnmarkedVehicleNearby) {
  Team team;
  const double alone_m = mean(team.fly(30.0).errors_m);
  team.third_beside = true;
  EXPECT_EQ(mean(team.fly(30.0).errors_m), alone_m);
}

TEST(RelativeLocalizer, IgnoresReportsOfOtherVehicles) {
  Team team;
  team.sender = 2;
  EXPECT_TRUE(team.fly(30.0).errors_m.empty());
}

TEST(RelativeLocalizer, IsUndisturbedByFalseMarkerSightings) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Team team;
    team.false_share = 0.3;
    const Team::Result result = team.fly(40.0, seed);
    ASSERT_FALSE(result.errors_m.empty()) << seed;
    EXPECT_LT(mean(result.errors_m), 0.1) << seed;
    EXPECT_LT(greatest(result.errors_m), 0.6) << seed;
  }
}

TEST(RelativeLocalizer, CoastsOnOdometryWithConsistentCovariance) {
  Team team;
  team.unseen_from_s = 15.0;
  const Team::Result result = team.fly(45.0);
  ASSERT_TRUE(result.known_at_end);
  EXPECT_LT(result.errors_m.back(), 4.0 * result.sigmas_m.back());
  EXPECT_GT(result.sigmas_m.back(), 2.0 * result.sigmas_m[result.sigmas_m.size() / 4]);
  team.seen_again_s = 40.0;
  EXPECT_LT(team.fly(45.0).sigmas_m.back(), 0.5 * result.sigmas_m.back());
}

TEST(RelativeLocalizer, ToleratesDelaysKnownFromStamps) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Team team;
    team.sighting_latency_s = 0.4;
    team.odometry_latency_s = 0.3;
    const Team::Result result = team.fly(30.0, seed);
    ASSERT_FALSE(result.errors_m.empty());
    EXPECT_LT(mean(result.errors_m), 0.12) << seed;
  }
}

TEST(RelativeLocalizer, EstimatesClockOffsetAndDrift) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Team team;
    team.clock_offset_s = 0.2;
    team.clock_drift = 100e-6;
    team.config.clock = SlidingWindowConfig::Clock::kOneWay;
    team.config.clock_sigma_s = 0.1;  // a message takes 0.1 s here, unknown to the localizer
    const Team::Result known = team.fly(60.0, seed);
    ASSERT_FALSE(known.errors_m.empty());
    EXPECT_LT(mean(known.errors_m), 0.09) << seed;
    team.config.clock = SlidingWindowConfig::Clock::kSynchronized;
    team.config.clock_sigma_s = 0.0;
    const Team::Result taken_for_synchronous = team.fly(60.0, seed);
    EXPECT_TRUE(taken_for_synchronous.errors_m.empty() ||
                mean(taken_for_synchronous.errors_m) > 1.15 * mean(known.errors_m))
        << seed;
  }
}

TEST(RelativeLocalizer, ClocksMayCountFromAnyDay) {
  Team team;
  team.clock_offset_s = -1.7e9;
  team.config.clock = SlidingWindowConfig::Clock::kOneWay;
  team.config.clock_sigma_s = 0.1;
  const Team::Result result = team.fly(30.0);
  ASSERT_FALSE(result.errors_m.empty());
  EXPECT_LT(mean(result.errors_m), 0.09);
}

TEST(RelativeLocalizer, RefusesUnknownVehicleByName) {
  SlidingWindowConfig config = looking_for_uav2();
  config.other = "uav9";
  try {
    localizer_of(config);
    FAIL();
  } catch (const std::invalid_argument& problem) {
    EXPECT_STREQ(problem.what(),
                 "relative_localization.other: expected the name of another vehicle (uav2, uav3), found \"uav9\"");
  }
}

}  // namespace
}  // namespace swiftlet
