// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/report/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
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

TEST(Statistics, QuartilesMatchTheOrderedSample) {
  const Random random(5, "test");
  for (std::uint32_t n = 1; n <= 40; ++n) {
    std::vector<double> samples;
    for (std::uint32_t i = 0; i < n; ++i) samples.push_back(random.normal(n, i));
    const SampleSummary s = summarize(samples);
    std::sort(samples.begin(), samples.end());
    // The order statistics stand at even distances from 0 to 1, straight lines between them.
    const auto at = [&](double p) {
      double value = samples.front();
      for (std::uint32_t i = 0; i + 1 < n; ++i) {
        const double from = static_cast<double>(i) / (n - 1), to = static_cast<double>(i + 1) / (n - 1);
        value += (samples[i + 1] - samples[i]) * std::clamp((p - from) / (to - from), 0.0, 1.0);
      }
      return value;
    };
    EXPECT_NEAR(s.q1, at(0.25), 1e-12) << n;
    EXPECT_NEAR(s.median, at(0.5), 1e-12) << n;
    EXPECT_NEAR(s.q3, at(0.75), 1e-12) << n;
    EXPECT_EQ(s.min, samples.front());
    EXPECT_EQ(s.max, samples.back());
  }
}

/// Standard error of the mean by the sums of deviations of each cluster, and Student's t of 0.975 from a table.
TEST(Statistics, ClusteredIntervalsHaveTheirClosedForm) {
  const double t_of_freedom[] = {0.0, 12.706205, 4.302653, 3.182446, 2.776445, 2.570582, 2.446912, 2.364624};
  const Random random(6, "test");
  for (std::uint32_t g = 2; g <= 8; ++g) {
    std::vector<double> samples;
    std::vector<std::uint64_t> clusters;
    for (std::uint32_t i = 0; i < 23; ++i) {
      samples.push_back(random.normal(g, i) + (i % g));
      clusters.push_back(1000 + i % g);
    }
    samples[7] = std::nan("");
    double sum = 0.0, n = 0.0;
    for (const double x : samples) {
      if (std::isnan(x)) continue;
      sum += x;
      n += 1.0;
    }
    const double mean = sum / n;
    std::map<std::uint64_t, double> deviations;
    double squares = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (std::isnan(samples[i])) continue;
      deviations[clusters[i]] += samples[i] - mean;
      squares += (samples[i] - mean) * (samples[i] - mean);
    }
    double between = 0.0;
    for (const auto& [cluster, deviation] : deviations) between += deviation * deviation;
    const double variance = g / (g - 1.0) * between / (n * n);
    const SampleSummary s = summarize(samples, clusters);
    EXPECT_EQ(s.n, 22U);
    EXPECT_NEAR(s.mean, mean, 1e-12);
    EXPECT_NEAR(s.sd, std::sqrt(squares / (n - 1.0)), 1e-12);
    EXPECT_NEAR(s.mean_ci.high - mean, t_of_freedom[g - 1] * std::sqrt(variance), 1e-5);
    EXPECT_NEAR(mean - s.mean_ci.low, t_of_freedom[g - 1] * std::sqrt(variance), 1e-5);
    EXPECT_NEAR(independent_share(samples, clusters), std::min(1.0, squares / (n - 1.0) / n / variance), 1e-9);
  }
  EXPECT_EQ(independent_share(std::vector<double>{1, 2, 3}, {}), 1.0) << "none hang together";
  const std::vector<std::uint64_t> one = {4, 4, 4, 4};
  EXPECT_EQ(independent_share(std::vector<double>{1, 2, 3, 4}, one), 0.25) << "one cluster is one sample";
  EXPECT_EQ(independent_share(std::vector<double>{1}, std::vector<std::uint64_t>{4}), 1.0);
  const std::vector<std::uint64_t> pairs = {1, 1, 2, 2};
  EXPECT_EQ(independent_share(std::vector<double>{3, 3, 3, 3}, pairs), 0.5);
  EXPECT_EQ(independent_share(std::vector<double>{1, -1, 1, -1}, pairs), 1.0) << "pairs that cancel tell no more";
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

/// Newcombe's method 10, from the intervals of either rate and the correlation with its correction for continuity.
TEST(Statistics, PairedRatesFollowNewcombesMethodTen) {
  const auto square_and_add = [](double x, double y, double phi) {
    return std::sqrt(std::max(0.0, x * x + y * y - 2.0 * phi * x * y));
  };
  for (const std::uint64_t both : {0U, 1U, 9U, 40U}) {
    for (const std::uint64_t first_only : {0U, 2U, 11U}) {
      for (const std::uint64_t second_only : {0U, 5U, 12U}) {
        for (const std::uint64_t neither : {0U, 3U, 30U}) {
          const PairedCounts counts{both, first_only, second_only, neither, 0.8};
          const double a = static_cast<double>(both), b = static_cast<double>(first_only),
                       c = static_cast<double>(second_only), d = static_cast<double>(neither), n = a + b + c + d;
          const RateDifference found = paired_rate_difference(counts);
          if (n == 0.0) {
            EXPECT_TRUE(std::isnan(found.difference));
            continue;
          }
          const Interval first = wilson_by_roots(a + b, n, 0.8 * n), second = wilson_by_roots(a + c, n, 0.8 * n);
          const double p1 = (a + b) / n, p2 = (a + c) / n, margins = (a + b) * (c + d) * (a + c) * (b + d);
          double excess = a * d - b * c;
          if (excess > 0.0) excess = std::max(0.0, excess - n / 2.0);
          const double phi = margins > 0.0 ? excess / std::sqrt(margins) : 0.0;
          EXPECT_NEAR(found.difference, p2 - p1, 1e-12);
          EXPECT_NEAR(p2 - p1 - found.ci.low, square_and_add(p2 - second.low, first.high - p1, phi), 1e-7);
          EXPECT_NEAR(found.ci.high - p2 + p1, square_and_add(second.high - p2, p1 - first.low, phi), 1e-7);
        }
      }
    }
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
      const double luck = random.normal(trial, seed);
      for (std::uint32_t point = 0; point < kPoints; ++point) {
        const std::uint32_t index = 1000 + kPoints * seed + point;
        samples.push_back(5.0 + 2.0 * luck + 0.5 * random.normal(trial, index));
        const bool yes = luck + 0.5 * random.normal(trial, 1000 + index) > 0.0;    // half of all
        const bool other = luck + 0.5 * random.normal(trial, 2000 + index) > 0.0;  // as often
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
