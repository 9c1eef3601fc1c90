// SPDX-License-Identifier: BSD-3-Clause
#include "sim/batch/sweep.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numeric>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {
namespace {

/// [-] Maximum number of points of a parameter sweep; larger ones are refused before they exhaust the memory.
constexpr std::size_t kMaxPoints = 10'000'000;

/// Decimal text with 12 digits: short in tables, and equal on every machine despite different rounding in libraries.
std::string to_text(double value) { return fmt::format("{:.12g}", value); }

/// Evenly spaced values of the distribution of a parameter, or its explicit list.
std::vector<std::string> levels(const ParameterConfig& p) {
  if (p.law == ParameterConfig::Law::kValues) return p.values;
  std::vector<std::string> values;
  if (p.law == ParameterConfig::Law::kInteger) {
    const auto count = static_cast<double>(std::min<long long>(p.steps, std::llround(p.max - p.min) + 1));
    for (double i = 0.0; i < count; i += 1.0) {
      const double part = count > 1.0 ? i / (count - 1.0) : 0.0;
      values.push_back(to_text(std::round(p.min + part * (p.max - p.min))));
    }
    return values;
  }
  for (int i = 0; i < p.steps; ++i) {
    const double part = p.steps > 1 ? static_cast<double>(i) / (p.steps - 1) : 0.5;
    const bool is_log = p.law == ParameterConfig::Law::kLogUniform;
    values.push_back(to_text(is_log ? p.min * std::pow(p.max / p.min, part) : p.min + part * (p.max - p.min)));
  }
  return values;
}

std::vector<std::vector<std::string>> grid(const std::vector<ParameterConfig>& parameters) {
  std::vector<std::vector<std::string>> points = {{}};
  for (const ParameterConfig& parameter : parameters) {
    const std::vector<std::string> values = levels(parameter);
    if (points.size() > kMaxPoints / values.size()) {
      throw InputError("sweep: expected at most " + std::to_string(kMaxPoints) + " points, found more");
    }
    std::vector<std::vector<std::string>> longer;
    for (const auto& point : points) {
      for (const std::string& value : values) {
        longer.push_back(point);
        longer.back().push_back(value);
      }
    }
    points = std::move(longer);
  }
  return points;
}

std::vector<std::vector<std::string>> list(const std::vector<ParameterConfig>& parameters) {
  std::vector<std::vector<std::string>> columns;
  for (const ParameterConfig& parameter : parameters) {
    columns.push_back(levels(parameter));
    if (columns.back().size() != columns.front().size()) {
      throw InputError("sweep: " + parameter.name + ": expected as many values as " + parameters.front().name +
                       " has (" + std::to_string(columns.front().size()) + ") for method \"list\", found " +
                       std::to_string(columns.back().size()));
    }
  }
  std::vector<std::vector<std::string>> points(columns.front().size());
  for (const auto& column : columns) {
    for (std::size_t i = 0; i < points.size(); ++i) points[i].push_back(column[i]);
  }
  return points;
}

/// A random permutation of 0 .. count - 1 with uniform probability (Fisher and Yates).
std::vector<std::size_t> shuffled(std::size_t count, const Random& random) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = count; i > 1; --i) {
    const auto j = static_cast<std::size_t>(random.uniform(0, static_cast<std::uint32_t>(i)) * static_cast<double>(i));
    std::swap(order[i - 1], order[j]);
  }
  return order;
}

std::vector<std::vector<std::string>> samples(const SweepConfig& sweep) {
  const auto count = static_cast<std::size_t>(sweep.samples);
  std::vector<std::vector<std::string>> points(count);
  for (const ParameterConfig& parameter : sweep.parameters) {
    // Random streams are named by the key, so an additional parameter does not change the values of others.
    const Random draw(sweep.seed, "batch.sweep", parameter.key);
    const bool is_stratified = sweep.method == SweepConfig::Method::kLatinHypercube;
    std::vector<std::size_t> stratum(count);
    if (is_stratified) stratum = shuffled(count, Random(sweep.seed, "batch.sweep.order", parameter.key));
    for (std::size_t i = 0; i < count; ++i) {
      double u = draw.uniform(static_cast<std::uint32_t>(i), 0);
      if (is_stratified) u = (static_cast<double>(stratum[i]) + u) / static_cast<double>(count);
      points[i].push_back(quantile(parameter, u));
    }
  }
  return points;
}

double normal_quantile(const ParameterConfig& p, double u) {
  const boost::math::normal standard;
  const double below = boost::math::cdf(standard, -p.cut_sd);
  const double z = boost::math::quantile(standard, below + u * (1.0 - 2.0 * below));
  return p.mean + p.sd * std::clamp(z, -p.cut_sd, p.cut_sd);
}

}  // namespace

std::string quantile(const ParameterConfig& p, double u) {
  if (p.law == ParameterConfig::Law::kValues) {
    const auto count = static_cast<double>(p.values.size());
    return p.values[static_cast<std::size_t>(std::min(u * count, count - 1.0))];
  }
  if (p.law == ParameterConfig::Law::kInteger) {
    const double count = std::floor(p.max) - std::ceil(p.min) + 1.0;
    return to_text(std::ceil(p.min) + std::floor(std::min(u * count, count - 1.0)));
  }
  if (p.law == ParameterConfig::Law::kLogUniform) return to_text(p.min * std::pow(p.max / p.min, u));
  if (p.law == ParameterConfig::Law::kNormal) return to_text(normal_quantile(p, u));
  return to_text(p.min + u * (p.max - p.min));
}

std::vector<std::vector<std::string>> sweep_points(const SweepConfig& sweep) {
  if (sweep.parameters.empty()) return {{}};
  if (sweep.method == SweepConfig::Method::kGrid) return grid(sweep.parameters);
  if (sweep.method == SweepConfig::Method::kList) return list(sweep.parameters);
  return samples(sweep);
}

}  // namespace swiftlet::sim
