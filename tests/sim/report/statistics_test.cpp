// SPDX-License-Identifier: BSD-3-Clause
#include "sim/report/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet::sim {
namespace {

TEST(Statistics, ASampleIsSummarized) {
  const std::vector<double> samples = {2.0, std::nan(""), 4.0, 4.0, 5.0, 5.0, 7.0, 9.0, 4.0};
  const SampleSummary s = summarize(samples);
  EXPECT_EQ(s.n, 8U);
  EXPECT_DOUBLE_EQ(s.mean, 5.0);
  EXPECT_DOUBLE_EQ(s.sd, std::sqrt(32.0 / 7.0));
  // Student's t with 7 degrees of freedom: 2.364624 (any table).
  EXPECT_NEAR(s.mean_ci.high - s.mean, 2.364624 * s.sd / std::sqrt(8.0), 1e-6);
  EXPECT_EQ(s.min, 2.0);
  EXPECT_EQ(s.q1, 4.0);
  EXPECT_EQ(s.median, 4.5);
  EXPECT_EQ(s.q3, 5.5);
  EXPECT_EQ(s.max, 9.0);
}

TEST(Statistics, ClustersShareTheirIndependence) {
  EXPECT_EQ(independent_share(std::vector<double>{1, 2, 3}, {}), 1.0) << "no clusters";
  const std::vector<std::uint64_t> one = {4, 4, 4, 4}, pairs = {1, 1, 2, 2};
  EXPECT_EQ(independent_share(std::vector<double>{1, 2, 3, 4}, one), 0.25) << "one cluster is one sample";
  EXPECT_EQ(independent_share(std::vector<double>{3, 3, 3, 3}, pairs), 0.5);
  EXPECT_EQ(independent_share(std::vector<double>{1, -1, 1, -1}, pairs), 1.0) << "pairs that cancel";
}

TEST(Statistics, ConfidenceWidensAnInterval) {
  const std::vector<double> samples = {1.0, 2.0, 4.0};
  // t of 2 degrees of freedom: 2.919986 at 0.95, 9.924843 at 0.995.
  const double error = summarize(samples).sd / std::sqrt(3.0);
  EXPECT_NEAR(summarize(samples, {}, 0.90).mean_ci.high - 7.0 / 3.0, 2.919986 * error, 1e-6);
  EXPECT_NEAR(summarize(samples, {}, 0.99).mean_ci.high - 7.0 / 3.0, 9.924843 * error, 1e-5);
}

/// The roots of (p - x)^2 = z^2 x (1 - x) / n.
Interval wilson_by_roots(double successes, double trials, double n) {
  const double p = successes / trials, z = 1.959963984540054;
  const double a = 1.0 + z * z / n, b = -(2.0 * p + z * z / n), c = p * p;
  const double root = std::sqrt(std::max(0.0, b * b - 4.0 * a * c));
  return {std::max(0.0, (-b - root) / (2.0 * a)), std::min(1.0, (-b + root) / (2.0 * a))};
}

TEST(Statistics, WilsonIntervalInvertsTheScoreTest) {
  for (const std::uint64_t trials : {1U, 2U, 7U, 40U}) {
    for (std::uint64_t successes = 0; successes <= trials; ++successes) {
      for (const double share : {1.0, 0.4}) {
        const Interval found = wilson(successes, trials, share);
        const Interval expected = wilson_by_roots(static_cast<double>(successes), static_cast<double>(trials),
                                                  share * static_cast<double>(trials));
        EXPECT_NEAR(found.low, expected.low, 1e-9) << successes << " of " << trials;
        EXPECT_NEAR(found.high, expected.high, 1e-9) << successes << " of " << trials;
      }
    }
    EXPECT_EQ(wilson(0, trials).low, 0.0);
    EXPECT_EQ(wilson(trials, trials).high, 1.0);
    EXPECT_LT(wilson(0, trials).high, 1.0);
    EXPECT_GT(wilson(trials, trials).low, 0.0);
  }
}

TEST(Statistics, TooFewSamplesSayNothing) {
  EXPECT_TRUE(std::isnan(summarize({}).mean));
  const std::vector<double> one = {3.0};
  EXPECT_EQ(summarize(one).mean, 3.0);
  EXPECT_TRUE(std::isnan(summarize(one).sd));
  EXPECT_TRUE(std::isnan(summarize(one).mean_ci.low));
  EXPECT_TRUE(std::isnan(wilson(0, 0).low));
  EXPECT_TRUE(std::isnan(paired_rate_difference({}).difference));
}

TEST(Statistics, WilsonsIntervalIsThePublishedOne) {
  // Newcombe, Stat. Med. 17 (1998), p. 857, table I, method 3.
  const struct {
    std::uint64_t r, n;
    double low, high;
  } kPublished[] = {
      {81, 263, 0.2553, 0.3662}, {15, 148, 0.0624, 0.1605}, {0, 20, 0.0, 0.1611}, {1, 29, 0.0061, 0.1718}};
  for (const auto& row : kPublished) {
    const Interval ci = wilson(row.r, row.n);
    EXPECT_NEAR(ci.low, row.low, 5e-5);
    EXPECT_NEAR(ci.high, row.high, 5e-5);
  }
  EXPECT_EQ(wilson(20, 20).high, 1.0);
}

TEST(Statistics, PairedDifferencesCancelSharedNoise) {
  const Random random(1, "test");
  std::vector<double> first, second;
  for (std::uint32_t i = 0; i < 50; ++i) {
    const double shared = 10.0 * random.normal(i, 0);
    first.push_back(shared + 0.1 * random.normal(i, 1));
    second.push_back(shared + 0.1 * random.normal(i, 2) + 1.0);
  }
  const SampleSummary difference = paired_difference(first, second);
  EXPECT_EQ(difference.n, 50U);
  EXPECT_LT(difference.mean_ci.high - difference.mean_ci.low, 0.15);
  EXPECT_LT(difference.mean_ci.low, 1.0);
  EXPECT_GT(difference.mean_ci.high, 1.0);
  first[3] = std::nan("");
  EXPECT_EQ(paired_difference(first, second).n, 49U);
  second.pop_back();
  EXPECT_THROW(paired_difference(first, second), std::invalid_argument);
}

TEST(Statistics, PairedRatesHaveThePublishedInterval) {
  // Newcombe, Stat. Med. 17 (1998), p. 2635, method 10.
  const RateDifference d = paired_rate_difference({.both = 36, .first_only = 2, .second_only = 12, .neither = 0});
  EXPECT_DOUBLE_EQ(d.difference, 0.2);
  EXPECT_NEAR(d.ci.low, 0.0569, 5e-5);
  EXPECT_NEAR(d.ci.high, 0.3404, 5e-5);
}

TEST(Statistics, IntervalsHaveTheirNominalCoverage) {
  const Random random(7, "coverage");
  int mean_covered = 0, rate_covered = 0, difference_covered = 0;
  constexpr int kTrials = 4000, kSamples = 20;
  constexpr double kRate = 0.3;
  for (std::uint32_t trial = 0; trial < kTrials; ++trial) {
    std::vector<double> samples;
    PairedCounts counts;
    std::uint64_t successes = 0;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      samples.push_back(5.0 + 2.0 * random.normal(trial, i));
      const bool yes = random.uniform(trial, 1000 + i) < kRate;
      const bool other = random.uniform(trial, 2000 + i) < 0.5;
      successes += yes ? 1 : 0;
      ++(yes ? (other ? counts.both : counts.first_only) : (other ? counts.second_only : counts.neither));
    }
    const auto covers = [](const Interval& ci, double truth) { return ci.low <= truth && truth <= ci.high ? 1 : 0; };
    mean_covered += covers(summarize(samples).mean_ci, 5.0);
    rate_covered += covers(wilson(successes, kSamples), kRate);
    difference_covered += covers(paired_rate_difference(counts).ci, 0.2);
  }
  // Four standard deviations of 4000 trials; a rate's coverage oscillates with the number of samples.
  const double margin = 4.0 * std::sqrt(0.95 * 0.05 / kTrials);
  EXPECT_NEAR(static_cast<double>(mean_covered) / kTrials, 0.95, margin);
  EXPECT_NEAR(static_cast<double>(rate_covered) / kTrials, 0.95, 0.03);
  EXPECT_NEAR(static_cast<double>(difference_covered) / kTrials, 0.95, 0.03);
}

TEST(Statistics, RepeatedFlightsAddNoInformation) {
  const Random random(3, "clusters");
  std::vector<double> once, often;
  std::vector<std::uint64_t> seeds;
  for (std::uint32_t seed = 0; seed < 8; ++seed) {
    once.push_back(random.normal(seed, 0));
    for (int point = 0; point < 5; ++point) {
      often.push_back(once.back());
      seeds.push_back(seed);
    }
  }
  const Interval alone = summarize(once).mean_ci, together = summarize(often, seeds).mean_ci;
  EXPECT_NEAR(together.low, alone.low, 1e-12);
  EXPECT_NEAR(together.high, alone.high, 1e-12);
  EXPECT_LT(summarize(often).mean_ci.high - summarize(often).mean_ci.low, 0.5 * (alone.high - alone.low));
  EXPECT_NEAR(independent_share(often, seeds), 0.2, 0.03);
  EXPECT_NEAR(independent_share(std::vector<double>(40, 1.0), seeds), 0.2, 1e-12) << "all succeeded";
  EXPECT_NEAR(wilson(40, 40, 0.2).low, wilson(8, 8).low, 1e-12);
  EXPECT_TRUE(std::isnan(summarize(often, std::vector<std::uint64_t>(40, 7)).mean_ci.low)) << "one seed says nothing";
  EXPECT_THROW(summarize(often, {seeds.data(), 3}), std::invalid_argument);
}

TEST(Statistics, ClusteredIntervalsHaveNominalCoverage) {
  const Random random(8, "coverage");
  int mean_covered = 0, rate_covered = 0, difference_covered = 0;
  constexpr int kTrials = 2000, kSeeds = 25, kPoints = 4;
  const auto covers = [](const Interval& ci, double truth) { return ci.low <= truth && truth <= ci.high ? 1 : 0; };
  for (std::uint32_t trial = 0; trial < kTrials; ++trial) {
    std::vector<double> samples, outcomes, differences;
    std::vector<std::uint64_t> seeds;
    PairedCounts counts;
    std::uint64_t successes = 0;
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
      const double seed_effect = random.normal(trial, seed);
      for (std::uint32_t point = 0; point < kPoints; ++point) {
        const std::uint32_t index = 1000 + kPoints * seed + point;
        samples.push_back(5.0 + 2.0 * seed_effect + 0.5 * random.normal(trial, index));
        // Both are true in half of the cases.
        const bool yes = seed_effect + 0.5 * random.normal(trial, 1000 + index) > 0.0;
        const bool other = seed_effect + 0.5 * random.normal(trial, 2000 + index) > 0.0;
        successes += yes ? 1 : 0;
        ++(yes ? (other ? counts.both : counts.first_only) : (other ? counts.second_only : counts.neither));
        outcomes.push_back(yes ? 1.0 : 0.0);
        differences.push_back(static_cast<double>(other) - static_cast<double>(yes));
        seeds.push_back(seed);
      }
    }
    counts.independent = independent_share(differences, seeds);
    mean_covered += covers(summarize(samples, seeds).mean_ci, 5.0);
    rate_covered += covers(wilson(successes, kSeeds * kPoints, independent_share(outcomes, seeds)), 0.5);
    difference_covered += covers(paired_rate_difference(counts).ci, 0.0);
  }
  EXPECT_NEAR(static_cast<double>(mean_covered) / kTrials, 0.95, 0.02);
  EXPECT_NEAR(static_cast<double>(rate_covered) / kTrials, 0.95, 0.03);
  EXPECT_GT(static_cast<double>(difference_covered) / kTrials, 0.93);
}

}  // namespace
}  // namespace swiftlet::sim
