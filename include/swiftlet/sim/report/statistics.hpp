// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <span>

/// What samples say about the law that they come from. All intervals are two-sided, of 95 % unless told.
namespace swiftlet::sim {

struct Interval {
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

inline constexpr double kConfidence = 0.95;

/// Which samples hang together, by a number for each: a seed meets the same random numbers at every point of a sweep.
/// Empty: none do.
using Clusters = std::span<const std::uint64_t>;

/// NaN wherever there are too few samples to tell.
struct SampleSummary {
  std::uint64_t n = 0;  ///< samples that are numbers
  double mean = std::numeric_limits<double>::quiet_NaN();
  double sd = std::numeric_limits<double>::quiet_NaN();  ///< with n - 1
  Interval mean_ci;  ///< Student's t, with the spread between clusters (Liang and Zeger, Biometrika 73, 1986)
  double min = std::numeric_limits<double>::quiet_NaN();
  double q1 = std::numeric_limits<double>::quiet_NaN();
  double median = std::numeric_limits<double>::quiet_NaN();
  double q3 = std::numeric_limits<double>::quiet_NaN();
  double max = std::numeric_limits<double>::quiet_NaN();
};

/// NaN are left out. Quartiles by linear interpolation between order statistics.
SampleSummary summarize(std::span<const double> samples, Clusters clusters = {}, double confidence = kConfidence);

/// How many independent samples would tell the mean as well, as a share of how many there are: at most 1. Where all are
/// equal, one of each cluster. NaN are left out.
double independent_share(std::span<const double> samples, Clusters clusters);

/// Wilson's score interval of a rate (J. Am. Stat. Assoc. 22, 1927).
/// @param independent  share of the trials that counts, where they hang together
Interval wilson(std::uint64_t successes, std::uint64_t trials, double independent = 1.0,
                double confidence = kConfidence);

/// second[i] - first[i]: pairs in which either is NaN are left out. Student's t on the differences.
SampleSummary paired_difference(std::span<const double> first, std::span<const double> second, Clusters clusters = {},
                                double confidence = kConfidence);

/// How often each of two paired yes-or-no outcomes occurred together.
struct PairedCounts {
  std::uint64_t both = 0, first_only = 0, second_only = 0, neither = 0;
  double independent = 1.0;  ///< share of them that counts, where they hang together
};

struct RateDifference {
  double difference = std::numeric_limits<double>::quiet_NaN();  ///< rate of the second less rate of the first
  Interval ci;
};

/// Newcombe's score interval of a difference of paired rates (Stat. Med. 17, 1998, p. 2635, method 10).
RateDifference paired_rate_difference(const PairedCounts& counts, double confidence = kConfidence);

}  // namespace swiftlet::sim
