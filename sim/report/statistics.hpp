// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <span>

/// Statistics of samples. All intervals are two-sided, with 95 % confidence by default.
namespace swiftlet::sim {

struct Interval {
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

/// [-] Usual coverage probability of confidence intervals.
inline constexpr double kConfidence = 0.95;

/// Cluster number of each sample; samples of one cluster are correlated, such as those of one seed, which draws equal
/// random numbers at every point of a sweep. Empty: all samples are independent.
using Clusters = std::span<const std::uint64_t>;

/// Values are NaN where there are too few samples.
struct SampleSummary {
  std::uint64_t n = 0;  ///< number of samples, without NaN
  double mean = std::numeric_limits<double>::quiet_NaN();
  double sd = std::numeric_limits<double>::quiet_NaN();  ///< sample standard deviation (n - 1)
  Interval mean_ci;  ///< Student's t, with the spread between clusters (Liang and Zeger, Biometrika 73, 1986)
  double min = std::numeric_limits<double>::quiet_NaN();
  double q1 = std::numeric_limits<double>::quiet_NaN();
  double median = std::numeric_limits<double>::quiet_NaN();
  double q3 = std::numeric_limits<double>::quiet_NaN();
  double max = std::numeric_limits<double>::quiet_NaN();
};

/// NaN is omitted. Quartiles by linear interpolation between order statistics.
SampleSummary summarize(std::span<const double> samples, Clusters clusters = {}, double confidence = kConfidence);

/// Effective sample size of the mean, as a share of the number of samples: at most 1. Where all samples are equal, one
/// for each cluster. NaN is omitted.
double independent_share(std::span<const double> samples, Clusters clusters);

/// Wilson's score interval of a rate (J. Am. Stat. Assoc. 22, 1927).
/// @param independent  effective share of the trials; below 1 if trials are correlated, see independent_share()
Interval wilson(std::uint64_t successes, std::uint64_t trials, double independent = 1.0,
                double confidence = kConfidence);

/// second[i] - first[i]; pairs with NaN are omitted. Student's t on the differences.
SampleSummary paired_difference(std::span<const double> first, std::span<const double> second, Clusters clusters = {},
                                double confidence = kConfidence);

/// Numbers of pairs by their two yes-or-no outcomes.
struct PairedCounts {
  std::uint64_t both = 0, first_only = 0, second_only = 0, neither = 0;
  double independent = 1.0;  ///< effective share of the pairs; below 1 if pairs are correlated
};

struct RateDifference {
  double difference = std::numeric_limits<double>::quiet_NaN();  ///< rate of the second minus rate of the first
  Interval ci;
};

/// Newcombe's score interval of a difference of paired rates (Stat. Med. 17, 1998, p. 2635, method 10).
RateDifference paired_rate_difference(const PairedCounts& counts, double confidence = kConfidence);

}  // namespace swiftlet::sim
