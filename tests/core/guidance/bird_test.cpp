// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/bird.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

constexpr double kBirdTick_s = 0.01, kRise_mps = 8.5, kRise_mps2 = 5.0;
// Amplitude and frequency of bounding flight.
constexpr double kBounds_m = 0.03, kBounds_hz = 1.5;
const Vector3 kStart_m(1.0, 2.0, 6.0);

BirdConfig bird_of(std::uint64_t seed) {
  BirdConfig config;
  config.seed = seed;
  return config;
}

class BirdOf : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, BirdOf, ::testing::Values(1U, 2U, 3U));

// Bounds of the spline, plus those of a harmonic of amplitude A that grows as a quintic in 1 s: its first derivative is
// at most 15/8, its second at most 10/sqrt(3).
TEST_P(BirdOf, KeepsItsBounds) {
  const BirdConfig config = bird_of(GetParam());
  BirdFlight flight(config, kStart_m, kRise_mps, kRise_mps2);
  const double omega = 2.0 * std::numbers::pi * kBounds_hz, A = kBounds_m;
  const double rise_mps = A * (15.0 / 8.0 + omega);
  const double rise_mps2 = A * (10.0 / std::sqrt(3.0) + omega * omega + 2.0 * 15.0 / 8.0 * omega);
  for (int i = 0; i < 12'000; ++i) {
    flight.advance(kBirdTick_s);
    const Reference r = flight.reference();
    for (int axis = 0; axis < 3; ++axis) {
      const double beyond_m = axis == 2 ? A : 0.0;
      ASSERT_GE(r.position_m[axis], config.area_min_m[axis] - beyond_m - 1e-9);
      ASSERT_LE(r.position_m[axis], config.area_max_m[axis] + beyond_m + 1e-9);
    }
    ASSERT_LE(r.velocity_mps.norm(), config.speed_max_mps + rise_mps + 1e-9);
    ASSERT_LE(r.acceleration_mps2.norm(), config.acceleration_max_mps2 + rise_mps2 + 1e-9);
    ASSERT_LE(r.velocity_mps.head<2>().norm(), config.speed_max_mps + 1e-9) << "bounds are of the height alone";
  }
}

TEST_P(BirdOf, ReportsTrueDerivativesOfItsPath) {
  BirdConfig config = bird_of(GetParam());
  config.perches_m = {{5.0, 5.0, 5.0}, {-8.0, 3.0, 7.0}};
  BirdFlight flight(config, kStart_m, kRise_mps, kRise_mps2);
  constexpr double kStep_s = 1e-3;
  Reference before = flight.reference();
  flight.advance(kStep_s);
  Reference now = flight.reference();
  for (int i = 0; i < 60'000; ++i) {
    flight.advance(kStep_s);
    const Reference after = flight.reference();
    const Vector3 v_mps = (after.position_m - before.position_m) / (2.0 * kStep_s);
    const Vector3 a_mps2 = (after.velocity_mps - before.velocity_mps) / (2.0 * kStep_s);
    ASSERT_LT((v_mps - now.velocity_mps).norm(), 1e-3) << i;
    ASSERT_LT((a_mps2 - now.acceleration_mps2).norm(), 0.2) << i << ": jerk changes at knots";
    before = now;
    now = after;
  }
}

// Frequency of rise and fall: the height less its mean over a cycle changes sign twice per cycle.
TEST(Bird, RisesAndFallsAtItsFrequency) {
  BirdConfig config;
  config.area_min_m = {-30.0, -30.0, 5.99};
  config.area_max_m = {30.0, 30.0, 6.01};
  BirdFlight flight(config, kStart_m, kRise_mps, kRise_mps2);
  std::vector<double> heights_m;
  for (int i = 0; i < 2000; ++i) {
    flight.advance(kBirdTick_s);
    heights_m.push_back(flight.reference().position_m.z() - 6.0);
  }
  int changes = 0;
  for (std::size_t i = 1001; i < heights_m.size(); ++i) changes += (heights_m[i] > 0.0) != (heights_m[i - 1] > 0.0);
  EXPECT_NEAR(changes, 30, 2) << "in 10 s";
  const auto [low, high] = std::minmax_element(heights_m.begin() + 1000, heights_m.end());
  EXPECT_NEAR(*high - *low, 2.0 * kBounds_m, 0.021) << "to the height of the area";
}

TEST(Bird, FliesAtRealisticBirdSpeed) {
  std::vector<double> speeds_mps;
  BirdFlight flight({}, kStart_m, kRise_mps, kRise_mps2);
  for (int i = 0; i < 20'000; ++i) {
    flight.advance(kBirdTick_s);
    speeds_mps.push_back(flight.reference().velocity_mps.norm());
  }
  std::sort(speeds_mps.begin(), speeds_mps.end());
  EXPECT_GT(speeds_mps[speeds_mps.size() / 2], 4.0);
  EXPECT_LT(speeds_mps[speeds_mps.size() / 2], 9.0);
}

TEST(Bird, TurnsSuddenly) {
  const auto turned_rad = [](double turn_s) {
    BirdConfig config;
    config.turn_s = turn_s;
    BirdFlight flight(config, kStart_m, kRise_mps, kRise_mps2);
    double sum_rad = 0.0;
    for (int i = 0; i < 12'000; ++i) {
      flight.advance(kBirdTick_s);
      const Reference r = flight.reference();
      const double speed_sq = r.velocity_mps.head<2>().squaredNorm();
      if (speed_sq < 1.0) continue;
      sum_rad += kBirdTick_s *
                 std::abs(r.velocity_mps.x() * r.acceleration_mps2.y() - r.velocity_mps.y() * r.acceleration_mps2.x()) /
                 speed_sq;
    }
    return sum_rad;
  };
  EXPECT_GT(turned_rad(1.0), 1.5 * turned_rad(100.0));
}

TEST(Bird, PerchesAfterFlights) {
  BirdConfig config;
  config.perches_m = {{5.0, 5.0, 12.0}, {-8.0, 3.0, 7.0}};
  BirdFlight flight(config, kStart_m, kRise_mps, kRise_mps2);
  double since_s = -1.0;
  std::vector<double> perched_s;
  int on[2] = {0, 0};
  for (int i = 0; i < 60'000; ++i) {
    flight.advance(kBirdTick_s);
    const double t_s = kBirdTick_s * (i + 1);
    if (flight.is_perched() && since_s < 0.0) since_s = t_s;
    if (flight.is_perched() && t_s > since_s + 1.2) {
      const Reference r = flight.reference();
      const double off_m[2] = {(r.position_m - config.perches_m[0]).norm(),
                               (r.position_m - config.perches_m[1]).norm()};
      EXPECT_LT(std::min(off_m[0], off_m[1]), 0.05) << t_s;
      EXPECT_LT(r.velocity_mps.norm(), 0.3) << t_s;
      ++on[off_m[1] < off_m[0]];
    }
    if (!flight.is_perched() && since_s >= 0.0) {
      perched_s.push_back(t_s - since_s);
      since_s = -1.0;
    }
  }
  ASSERT_GE(perched_s.size(), 10U);
  for (const double s : perched_s) {
    EXPECT_GE(s, 2.0 - 2.0 * kBirdTick_s);
    EXPECT_LE(s, 6.0 + 2.0 * kBirdTick_s);
  }
  EXPECT_GT(on[0], 0);
  EXPECT_GT(on[1], 0);
}

TEST(Bird, IsAGuidanceThatNeverEnds) {
  BirdConfig config;
  config.speed_max_mps = 3.0;
  config.speed_min_mps = 2.0;
  config.acceleration_max_mps2 = 1.0;
  testing::GuidanceDriver driver("bird", config, kStart_m);
  Vector3 before_m = kStart_m;
  for (int i = 0; i < 200; ++i) {
    const GuidanceOutput& out = driver.step();
    EXPECT_EQ(out.mission, MissionStatus::kEndless);
    EXPECT_LT((out.goal.position_m - before_m).norm(), 0.1 * 4.0);
    before_m = out.goal.position_m;
  }
  EXPECT_GT((before_m - kStart_m).norm(), 0.5);
  config.speed_max_mps = 50.0;
  EXPECT_THROW(driver.make("bird", config), std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet
