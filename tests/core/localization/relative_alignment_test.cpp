// SPDX-License-Identifier: BSD-3-Clause
// Pose of another vehicle's local frame: closed form, robust fit, covariance, and unobservable cases.
#include "swiftlet/core/localization/relative_alignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/localization/relative_support.hpp"

namespace swiftlet {
namespace {

double weighted_squares(std::span<const Vector3> local, std::span<const Vector3> other, std::span<const double> weights,
                        double yaw_rad) {
  Vector3 mean_local = Vector3::Zero(), mean_other = Vector3::Zero();
  double sum = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    mean_local += weights[i] * local[i];
    mean_other += weights[i] * other[i];
    sum += weights[i];
  }
  mean_local /= sum;
  mean_other /= sum;
  double squares = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    squares += weights[i] * (local[i] - mean_local - turned_by(yaw_rad) * (other[i] - mean_other)).squaredNorm();
  }
  return squares;
}

TEST(AlignInClosedForm, MatchesExhaustiveHeadingSearch) {
  for (int trial = 0; trial < 50; ++trial) {
    const Random random(trial, "test.closed_form", "pairs");
    std::vector<Vector3> local, other;
    std::vector<double> weights;
    const double yaw_rad = random.uniform(-kPi, kPi, 0, 0);
    for (int i = 0; i < 12; ++i) {
      other.emplace_back(random.normal(i, 1), random.normal(i, 2), random.normal(i, 3));
      const Vector3 noise(random.normal(i, 4), random.normal(i, 5), random.normal(i, 6));
      local.push_back(turned_by(yaw_rad) * other.back() + Vector3(3, -7, 1) + 0.3 * noise);
      weights.push_back(random.uniform(0.1, 2.0, i, 7));
    }
    const auto found = align_in_closed_form(local, other, weights);
    ASSERT_TRUE(found);
    const double least = weighted_squares(local, other, weights, found->yaw_rad);
    for (int step = 0; step < 3600; ++step) {
      EXPECT_GE(weighted_squares(local, other, weights, step * 0.1 * kRadPerDeg), least - 1e-12);
    }
    EXPECT_NEAR(std::remainder(found->yaw_rad - yaw_rad, 2.0 * kPi), 0.0, 0.7);
  }
}

TEST(AlignInClosedForm, PairsWithoutNoiseAreMetExactly) {
  const std::vector<Vector3> other = {{1, 2, 3}, {-4, 0, 1}, {2, -5, 0}};
  std::vector<Vector3> local;
  for (const Vector3& p : other) local.push_back(turned_by(2.5) * p + Vector3(100, -200, 7));
  const auto found = align_in_closed_form(local, other, std::vector<double>{1, 2, 3});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->yaw_rad, 2.5, 1e-14);
  for (std::size_t i = 0; i < other.size(); ++i) {
    EXPECT_LT((found->point(other[i]) - local[i]).norm(), 1e-12);
    EXPECT_LT((found->T_local_other() * other[i] - local[i]).norm(), 1e-12);
  }
}

TEST(AlignInClosedForm, NeedsHorizontalSpreadAndWeight) {
  const std::vector<Vector3> apart = {{0, 0, 0}, {1, 0, 0}}, above = {{1, 2, 0}, {1, 2, 1}};
  const std::vector<double> weights = {1.0, 1.0}, none = {0.0, 0.0};
  EXPECT_TRUE(align_in_closed_form(apart, apart, weights));
  EXPECT_FALSE(align_in_closed_form(apart, above, weights));
  EXPECT_FALSE(align_in_closed_form(above, apart, weights));
  EXPECT_FALSE(align_in_closed_form(above, above, weights));
  EXPECT_FALSE(align_in_closed_form(apart, apart, none));
  EXPECT_FALSE(align_in_closed_form({}, {}, {}));
}

// ---- the window

struct Trial {
  Path path = eight();
  double duration_s = 15.0;
  OdometryDriftConfig drift;
  RelativeAlignmentConfig config;
  double outlier_share = 0.0;
  double clock_s = 0.0;  // delay of the other's clock
  ClockPrior prior;
};

struct Outcome {
  std::optional<FrameAlignment> found;
  AlignmentFault fault;
  double nees = 0.0;
};

Outcome run(const Trial& trial, std::uint64_t seed) {
  const OtherFlight flight(trial.path, trial.duration_s + 2.0, trial.drift, seed);
  const Random random(seed, "test.alignment", "sightings");
  RelativeAlignment alignment(trial.config, trial.drift);
  const Matrix3 C = sighting_covariance();
  const int num = static_cast<int>(trial.duration_s / 0.1);
  for (int i = 0; i < num; ++i) {
    const double t_s = 1.0 + 0.1 * i;
    Vector3 seen = sighting_of(flight, t_s, C, random);
    if (random.uniform(i, 0) < trial.outlier_share) {
      seen = {random.uniform(0, 10, i, 1), random.uniform(-4, 6, i, 2), random.uniform(-1, 2, i, 3)};
    }
    const OtherMotion& reported = flight.at(t_s + trial.clock_s).motion;
    AlignmentPair pair{from_seconds(t_s), seen, C, reported.p_other_local_m, reported.v_other_local_mps, 0.0,
                       reported.flown};
    alignment.push(pair);
  }
  const double now_s = 1.0 + 0.1 * (num - 1);
  Outcome outcome;
  outcome.found = alignment.fit(flight.at(now_s).motion, trial.prior);
  outcome.fault = alignment.fault();
  if (outcome.found) outcome.nees = nees_of(*outcome.found, flight, now_s);
  return outcome;
}

struct MonteCarlo {
  int found = 0;
  double mean_nees = 0.0, worst_yaw_sigma = 0.0, mean_sigma_m = 0.0, mean_sigma_yaw_rad = 0.0;
};

MonteCarlo monte_carlo(const Trial& trial, int num) {
  MonteCarlo result;
  for (int seed = 1; seed <= num; ++seed) {
    const Outcome outcome = run(trial, seed);
    if (!outcome.found) continue;
    ++result.found;
    result.mean_nees += outcome.nees;
    result.mean_sigma_m += std::sqrt(outcome.found->covariance.topLeftCorner<3, 3>().trace());
    result.mean_sigma_yaw_rad += std::sqrt(outcome.found->covariance(3, 3));
  }
  result.mean_nees /= result.found;
  result.mean_sigma_m /= result.found;
  result.mean_sigma_yaw_rad /= result.found;
  return result;
}

// Bound of the mean NEES of `num` trials with 4 degrees of freedom, exceeded in one of 1000 cases.
double bound_of_mean_nees(int num) { return 3.3 * std::sqrt(8.0 / num); }

TEST(RelativeAlignment, FindsAnyTransformExactlyWithoutNoise) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const OtherFlight flight(eight(), 20.0, no_drift(), seed);
    RelativeAlignment alignment({}, no_drift());
    for (int i = 0; i < 60; ++i) {
      const OtherFlight::Sample& s = flight.at(0.2 * i);
      alignment.push({s.motion.t, s.p_local_m, sighting_covariance(), s.motion.p_other_local_m,
                      s.motion.v_other_local_mps, 0.0, s.motion.flown});
    }
    const auto& found = alignment.fit(flight.at(11.8).motion, {});
    ASSERT_TRUE(found) << reason_of(alignment.fault());
    EXPECT_NEAR(std::remainder(found->yaw_rad - flight.at(0).yaw_local_other_rad, 2 * kPi), 0.0, 1e-8);
    EXPECT_LT((found->point(flight.at(3.0).motion.p_other_local_m) - flight.at(3.0).p_local_m).norm(), 1e-8);
  }
}

TEST(RelativeAlignment, IsConsistentWithPoorOdometry) {
  Trial trial;
  trial.drift.position_m_psqrtm = 0.15;
  trial.drift.yaw_deg_psqrtm = 1.0;
  trial.config.heading_sigma_max_deg = 10.0;
  const MonteCarlo result = monte_carlo(trial, 300);
  EXPECT_GE(result.found, 290);
  EXPECT_NEAR(result.mean_nees, 4.0, 1.3 * bound_of_mean_nees(300));  // the heading's error is no small angle
}

TEST(RelativeAlignment, IsConsistentWithoutFalseSightings) {
  const MonteCarlo result = monte_carlo({}, 150);
  EXPECT_EQ(result.found, 150);
  EXPECT_NEAR(result.mean_nees, 4.0, bound_of_mean_nees(150));
}

TEST(RelativeAlignment, SurvivesFalseSightings) {
  Trial trial;
  trial.outlier_share = 0.15;
  trial.config.min_inlier_share = 0.5;
  const MonteCarlo result = monte_carlo(trial, 60);
  EXPECT_GE(result.found, 58);
  EXPECT_NEAR(result.mean_nees, 4.0, 3.0 * bound_of_mean_nees(60));
  RecordProperty("nees", std::to_string(result.mean_nees));
}

TEST(RelativeAlignment, ToleratesThirtyPercentFalseSightings) {
  Trial trial;
  trial.outlier_share = 0.3;
  trial.config.min_inlier_share = 0.5;
  const MonteCarlo result = monte_carlo(trial, 300);
  EXPECT_EQ(result.found, 300);
  // A false sighting that happens to lie within the gate remains one.
  EXPECT_NEAR(result.mean_nees, 4.0, 2.0 * bound_of_mean_nees(300));
}

TEST(RelativeAlignment, NeedsHorizontalMotion) {
  const std::pair<const char*, Path> paths[] = {
      {"rest", rest()}, {"rising", [](double t) { return Vector3(5.0, 1.0, 0.5 * t); }}, {"centimeters", eight(0.08)}};
  for (const auto& [name, path] : paths) {
    Trial trial;
    trial.path = path;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const Outcome outcome = run(trial, seed);
      EXPECT_FALSE(outcome.found) << name;
      EXPECT_NE(outcome.fault, AlignmentFault::kNone) << name;
    }
  }
}

// The other vehicle restarts its odometry in another frame. The last result fits no new pair and is given up.
TEST(RelativeAlignment, RecoversFromARestartOfOdometry) {
  const OtherFlight before(eight(), 20.0, no_drift(), 1), after(eight(), 20.0, no_drift(), 2);
  RelativeAlignmentConfig config;
  config.window_size = 40;
  RelativeAlignment alignment(config, no_drift());
  Flown offset;
  for (const OtherFlight* flight : {&before, &after}) {
    OtherMotion now;
    for (int i = 0; i < 60; ++i) {
      const OtherFlight::Sample& s = flight->at(0.2 * i);
      now = s.motion;
      now.flown.path_m += offset.path_m;
      now.flown.time_s += offset.time_s;
      alignment.push({now.t + from_seconds(offset.time_s), s.p_local_m, sighting_covariance(), now.p_other_local_m,
                      now.v_other_local_mps, 0.0, now.flown});
    }
    now.t += from_seconds(offset.time_s);
    const auto& found = alignment.fit(now, {});
    ASSERT_TRUE(found) << reason_of(alignment.fault());
    EXPECT_NEAR(std::remainder(found->yaw_rad - flight->at(0).yaw_local_other_rad, 2 * kPi), 0.0, 1e-6);
    offset = {100.0, 0.0, 100.0};
  }
}

TEST(RelativeAlignment, SightingsOfAnotherVehicleFitNothing) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const OtherFlight reported(eight(), 20.0, {}, seed);
    const OtherFlight seen([](double t) { return Vector3(4.0 + 0.4 * t, -3.0, 2.0); }, 20.0, {}, seed + 100);
    RelativeAlignment alignment({}, {});
    for (int i = 0; i < 100; ++i) {
      const OtherMotion& m = reported.at(0.15 * i).motion;
      alignment.push({m.t, seen.at(0.15 * i).p_local_m, sighting_covariance(), m.p_other_local_m, m.v_other_local_mps,
                      0.0, m.flown});
    }
    EXPECT_FALSE(alignment.fit(reported.at(14.85).motion, {}));
    EXPECT_EQ(alignment.fault(), AlignmentFault::kFewInliers);
  }
}

TEST(RelativeAlignment, KeepsHeadingFromMotionAtRest) {
  const Path path = [](double t) { return eight()(std::min(t, 12.0)); };
  Trial trial;
  trial.path = path;
  trial.duration_s = 100.0;
  EXPECT_TRUE(run(trial, 1).found);
}

TEST(RelativeAlignment, EstimatesTheClockOffsetFromMotion) {
  Trial trial;
  trial.clock_s = 0.2;
  trial.prior = {0.0, 0.3};
  trial.drift = no_drift();
  double sum = 0.0, sum_nees = 0.0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Outcome outcome = run(trial, seed);
    ASSERT_TRUE(outcome.found);
    const double error_s = outcome.found->clock_s - 0.2;
    sum += error_s / 100.0;
    sum_nees += error_s * error_s / (outcome.found->clock_sigma_s * outcome.found->clock_sigma_s) / 100.0;
  }
  EXPECT_NEAR(sum, 0.0, 0.01);
  EXPECT_NEAR(sum_nees, 1.0, 0.5);
}

}  // namespace
}  // namespace swiftlet
