// SPDX-License-Identifier: BSD-3-Clause
#include "sim/report/statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

namespace swiftlet::sim {
namespace {

double normal_quantile(double confidence) {
  return boost::math::quantile(boost::math::normal(), 0.5 + 0.5 * confidence);
}

/// Linear interpolation between order statistics (type 7 of Hyndman and Fan).
double quantile_of_sorted(const std::vector<double>& sorted, double p) {
  const double at = p * static_cast<double>(sorted.size() - 1);
  const auto i = static_cast<std::size_t>(at);
  const double part = at - static_cast<double>(i);
  return i + 1 < sorted.size() ? sorted[i] + part * (sorted[i + 1] - sorted[i]) : sorted[i];
}

struct ClusteredError {
  double variance = std::numeric_limits<double>::quiet_NaN();  // variance of the mean
  std::size_t num_clusters = 0;
};

/// Variance of the mean of clustered samples; s^2 / n for clusters of one sample.
ClusteredError error_of_mean(std::span<const double> samples, Clusters clusters, double mean) {
  if (!clusters.empty() && clusters.size() != samples.size()) {
    throw std::invalid_argument("clusters: expected one for each sample");
  }
  std::map<std::uint64_t, std::vector<double>> by_cluster;
  std::size_t count = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::isnan(samples[i])) continue;
    by_cluster[clusters.empty() ? i : clusters[i]].push_back(samples[i] - mean);
    ++count;
  }
  std::vector<double> squares;
  squares.reserve(by_cluster.size());
  for (auto& [cluster, deviations] : by_cluster) {
    std::sort(deviations.begin(), deviations.end());
    double sum = 0.0;
    for (const double deviation : deviations) sum += deviation;
    squares.push_back(sum * sum);
  }
  std::sort(squares.begin(), squares.end());  // makes the sum independent of the order of the samples
  double sum = 0.0;
  for (const double square : squares) sum += square;
  const auto n = static_cast<double>(count), g = static_cast<double>(by_cluster.size());
  if (by_cluster.size() < 2) return {std::numeric_limits<double>::quiet_NaN(), by_cluster.size()};
  return {g / (g - 1.0) * sum / (n * n), by_cluster.size()};
}

}  // namespace

SampleSummary summarize(std::span<const double> samples, Clusters clusters, double confidence) {
  std::vector<double> numbers;
  for (const double x : samples) {
    if (!std::isnan(x)) numbers.push_back(x);
  }
  SampleSummary summary;
  summary.n = numbers.size();
  if (numbers.empty()) return summary;
  std::sort(numbers.begin(), numbers.end());  // makes the sum independent of the order of the samples
  const auto n = static_cast<double>(numbers.size());
  double sum = 0.0;
  for (const double x : numbers) sum += x;
  summary.mean = sum / n;
  summary.min = numbers.front();
  summary.max = numbers.back();
  summary.q1 = quantile_of_sorted(numbers, 0.25);
  summary.median = quantile_of_sorted(numbers, 0.5);
  summary.q3 = quantile_of_sorted(numbers, 0.75);
  if (numbers.size() < 2) return summary;
  double squares = 0.0;
  for (const double x : numbers) squares += (x - summary.mean) * (x - summary.mean);
  summary.sd = std::sqrt(squares / (n - 1.0));
  const ClusteredError error = error_of_mean(samples, clusters, summary.mean);
  if (error.num_clusters < 2) return summary;
  const auto freedom = static_cast<double>(error.num_clusters - 1);
  const double t = boost::math::quantile(boost::math::students_t(freedom), 0.5 + 0.5 * confidence);
  const double half = t * std::sqrt(error.variance);
  summary.mean_ci = {summary.mean - half, summary.mean + half};
  return summary;
}

double independent_share(std::span<const double> samples, Clusters clusters) {
  const SampleSummary summary = summarize(samples);
  if (clusters.empty() || summary.n < 2) return 1.0;
  const auto n = static_cast<double>(summary.n);
  const ClusteredError error = error_of_mean(samples, clusters, summary.mean);
  const double least = static_cast<double>(error.num_clusters) / n;
  if (error.num_clusters < 2 || summary.sd == 0.0) return least;
  return std::min(1.0, summary.sd * summary.sd / n / error.variance);
}

Interval wilson(std::uint64_t successes, std::uint64_t trials, double independent, double confidence) {
  if (trials == 0) return {};
  const double n = independent * static_cast<double>(trials);
  const double p = static_cast<double>(successes) / static_cast<double>(trials);
  const double z = normal_quantile(confidence);
  const double scale = 1.0 + z * z / n;
  const double center = (p + z * z / (2.0 * n)) / scale;
  const double half = z / scale * std::sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n));
  // The ends of the interval are exactly 0 or 1 where no or every trial succeeded.
  return {successes == 0 ? 0.0 : std::max(0.0, center - half),
          successes == trials ? 1.0 : std::min(1.0, center + half)};
}

SampleSummary paired_difference(std::span<const double> first, std::span<const double> second, Clusters clusters,
                                double confidence) {
  if (first.size() != second.size()) throw std::invalid_argument("paired_difference: expected as many of either");
  std::vector<double> differences(first.size());
  for (std::size_t i = 0; i < first.size(); ++i) differences[i] = second[i] - first[i];
  return summarize(differences, clusters, confidence);
}

RateDifference paired_rate_difference(const PairedCounts& counts, double confidence) {
  const auto a = static_cast<double>(counts.both), b = static_cast<double>(counts.second_only);
  const auto c = static_cast<double>(counts.first_only), d = static_cast<double>(counts.neither);
  const double n = a + b + c + d;
  RateDifference result;
  if (n == 0.0) return result;
  const std::uint64_t trials = counts.both + counts.second_only + counts.first_only + counts.neither;
  const double p_second = (a + b) / n, p_first = (a + c) / n;
  const Interval second = wilson(counts.both + counts.second_only, trials, counts.independent, confidence);
  const Interval first = wilson(counts.both + counts.first_only, trials, counts.independent, confidence);
  // Correlation of the two outcomes, with continuity correction of the numerator.
  const double margins = (a + b) * (c + d) * (a + c) * (b + d);
  double numerator = a * d - b * c;
  if (numerator > 0.0) numerator = std::max(numerator - 0.5 * n, 0.0);
  const double phi = margins > 0.0 ? numerator / std::sqrt(margins) : 0.0;
  const auto reach = [phi](double x, double y) { return std::sqrt(std::max(0.0, x * x - 2.0 * phi * x * y + y * y)); };
  result.difference = p_second - p_first;
  result.ci = {result.difference - reach(p_second - second.low, first.high - p_first),
               result.difference + reach(p_first - first.low, second.high - p_second)};
  return result;
}

}  // namespace swiftlet::sim
