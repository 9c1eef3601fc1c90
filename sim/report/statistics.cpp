// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/report/statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
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

}  // namespace

SampleSummary summarize(std::span<const double> samples, double confidence) {
  std::vector<double> numbers;
  for (const double x : samples) {
    if (!std::isnan(x)) numbers.push_back(x);
  }
  SampleSummary summary;
  summary.n = numbers.size();
  if (numbers.empty()) return summary;
  std::sort(numbers.begin(), numbers.end());  // a sum in this order does not depend on that of the samples
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
  const double t = boost::math::quantile(boost::math::students_t(n - 1.0), 0.5 + 0.5 * confidence);
  const double half = t * summary.sd / std::sqrt(n);
  summary.mean_ci = {summary.mean - half, summary.mean + half};
  return summary;
}

Interval wilson(std::uint64_t successes, std::uint64_t trials, double confidence) {
  if (trials == 0) return {};
  const auto n = static_cast<double>(trials);
  const double p = static_cast<double>(successes) / n;
  const double z = normal_quantile(confidence);
  const double scale = 1.0 + z * z / n;
  const double center = (p + z * z / (2.0 * n)) / scale;
  const double half = z / scale * std::sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n));
  // The ends of the scale are exact where nothing or everything succeeded.
  return {successes == 0 ? 0.0 : std::max(0.0, center - half),
          successes == trials ? 1.0 : std::min(1.0, center + half)};
}

SampleSummary paired_difference(std::span<const double> first, std::span<const double> second, double confidence) {
  if (first.size() != second.size()) throw std::invalid_argument("paired_difference: expected as many of either");
  std::vector<double> differences(first.size());
  for (std::size_t i = 0; i < first.size(); ++i) differences[i] = second[i] - first[i];
  return summarize(differences, confidence);
}

RateDifference paired_rate_difference(const PairedCounts& counts, double confidence) {
  const auto a = static_cast<double>(counts.both), b = static_cast<double>(counts.second_only);
  const auto c = static_cast<double>(counts.first_only), d = static_cast<double>(counts.neither);
  const double n = a + b + c + d;
  RateDifference result;
  if (n == 0.0) return result;
  const double p_second = (a + b) / n, p_first = (a + c) / n;
  const Interval second = wilson(counts.both + counts.second_only,
                                 counts.both + counts.second_only + counts.first_only + counts.neither, confidence);
  const Interval first = wilson(counts.both + counts.first_only,
                                counts.both + counts.second_only + counts.first_only + counts.neither, confidence);
  // Correlation of the two, its numerator corrected for continuity.
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
