// SPDX-License-Identifier: BSD-3-Clause
#include "sim/batch/sweep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {
namespace {

using Points = std::vector<std::vector<std::string>>;

ParameterConfig values(std::vector<std::string> list) {
  ParameterConfig p;
  p.key = p.name = "v" + std::to_string(list.size());
  p.values = std::move(list);
  return p;
}

using Law = ParameterConfig::Law;

ParameterConfig law(Law law, double min, double max) {
  ParameterConfig p;
  p.key = p.name = "k_" + std::to_string(static_cast<int>(law));
  p.law = law;
  p.min = min;
  p.max = max;
  return p;
}

std::vector<double> column(const Points& points, std::size_t i = 0) {
  std::vector<double> numbers;
  for (const auto& point : points) numbers.push_back(std::stod(point[i]));
  return numbers;
}

TEST(Sweep, NothingSweptIsOnePoint) { EXPECT_EQ(sweep_points({}), Points{{}}); }

TEST(Sweep, GridVariesLastParameterFastest) {
  SweepConfig sweep;
  sweep.parameters = {values({"a", "b"}), values({"1", "2", "3"})};
  EXPECT_EQ(sweep_points(sweep), (Points{{"a", "1"}, {"a", "2"}, {"a", "3"}, {"b", "1"}, {"b", "2"}, {"b", "3"}}));
}

TEST(Sweep, GridStepsIncludeEndsOrMidpoint) {
  const struct {
    Law law;
    double min, max;
    int steps;
    std::vector<double> expected;
  } grids[] = {
      {Law::kUniform, 2.0, 8.0, 1, {5.0}},         {Law::kUniform, 2.0, 8.0, 4, {2.0, 4.0, 6.0, 8.0}},
      {Law::kLogUniform, 1.0, 4.0, 1, {2.0}},      {Law::kLogUniform, 0.01, 100.0, 5, {0.01, 0.1, 1.0, 10.0, 100.0}},
      {Law::kInteger, 0, 10, 3, {0.0, 5.0, 10.0}}, {Law::kInteger, 4, 4, 5, {4.0}},
      {Law::kInteger, 3, 5, 5, {3.0, 4.0, 5.0}}};
  for (const auto& grid : grids) {
    SweepConfig sweep;
    sweep.parameters = {law(grid.law, grid.min, grid.max)};
    sweep.parameters[0].steps = grid.steps;
    EXPECT_EQ(column(sweep_points(sweep)), grid.expected);
  }
}

TEST(Sweep, DividesDiscreteQuantilesIntoEqualParts) {
  const ParameterConfig list = values({"a", "b", "c", "d"}), whole = law(Law::kInteger, 1.5, 5.5);  // 2 to 5
  const char* const words[] = {"a", "b", "c", "d"};
  for (int i = 0; i < 4; ++i) {
    for (const double part : {0.001, 0.999}) {
      EXPECT_EQ(quantile(list, (i + part) / 4.0), words[i]);
      EXPECT_EQ(quantile(whole, (i + part) / 4.0), std::to_string(2 + i));
    }
  }
  EXPECT_EQ(quantile(list, 1.0), "d") << "rounding may come that far";
  EXPECT_EQ(quantile(whole, 1.0), "5");
  EXPECT_EQ(quantile(law(Law::kUniform, 2.0, 4.0), 0.25), "2.5");
  EXPECT_EQ(quantile(law(Law::kLogUniform, 1.0, 10000.0), 0.25), "10");
}

TEST(Sweep, ShufflesToEveryOrderEquallyOften) {
  // Six orders of three strata over 1200 seeds: 200 each, with a standard deviation of 13.
  SweepConfig sweep;
  sweep.method = SweepConfig::Method::kLatinHypercube;
  sweep.samples = 3;
  sweep.parameters = {law(Law::kUniform, 0.0, 3.0)};
  std::map<std::string, int> orders;
  for (sweep.seed = 1; sweep.seed <= 1200; ++sweep.seed) {
    std::string order;
    for (const double x : column(sweep_points(sweep))) order += std::to_string(static_cast<int>(x));
    ++orders[order];
  }
  ASSERT_EQ(orders.size(), 6U);
  for (const auto& [order, count] : orders) EXPECT_NEAR(count, 200, 60) << order;
}

TEST(Sweep, PairsListsOfEqualLength) {
  SweepConfig sweep;
  sweep.method = SweepConfig::Method::kList;
  sweep.parameters = {values({"a", "b", "c"}), values({"1", "2", "3"})};
  sweep.parameters[1].name = "other";
  EXPECT_EQ(sweep_points(sweep), (Points{{"a", "1"}, {"b", "2"}, {"c", "3"}}));
  sweep.parameters[1].values.pop_back();
  EXPECT_THROW(sweep_points(sweep), InputError);
}

TEST(Sweep, LatinHypercubeSamplesEveryStratumOnce) {
  SweepConfig sweep;
  sweep.method = SweepConfig::Method::kLatinHypercube;
  sweep.samples = 50;
  sweep.parameters = {law(Law::kUniform, 10.0, 20.0), law(Law::kLogUniform, 1.0, 1000.0)};
  const Points points = sweep_points(sweep);
  std::set<int> first, second;
  for (const double x : column(points, 0)) first.insert(static_cast<int>(std::floor((x - 10.0) / 10.0 * 50)));
  for (const double x : column(points, 1))
    second.insert(static_cast<int>(std::floor(std::log(x) / std::log(1000.0) * 50)));
  EXPECT_EQ(first.size(), 50U);
  EXPECT_EQ(second.size(), 50U);
  // The strata of the two are paired at random: |r| of 50 independent pairs exceeds 0.46 once in a thousand times.
  double mean_x = 0.0, mean_y = 0.0, xy = 0.0, xx = 0.0, yy = 0.0;
  for (const auto& point : points) {
    mean_x += std::stod(point[0]) / 50;
    mean_y += std::log(std::stod(point[1])) / 50;
  }
  for (const auto& point : points) {
    const double x = std::stod(point[0]) - mean_x, y = std::log(std::stod(point[1])) - mean_y;
    xy += x * y;
    xx += x * x;
    yy += y * y;
  }
  EXPECT_LT(std::abs(xy / std::sqrt(xx * yy)), 0.46);
}

TEST(Sweep, RandomDrawsFollowTheirLaw) {
  SweepConfig sweep;
  sweep.method = SweepConfig::Method::kRandom;
  sweep.samples = 20'000;
  sweep.parameters = {law(Law::kUniform, -1.0, 3.0), law(Law::kNormal, 0.0, 1.0), law(Law::kInteger, 1, 4),
                      values({"x", "y", "z"})};
  sweep.parameters[1].mean = 5.0;
  sweep.parameters[1].sd = 2.0;
  const Points points = sweep_points(sweep);
  // Kolmogorov-Smirnov at 1e-4: D < 2.23 / sqrt(n).
  const double limit = 2.23 / std::sqrt(20'000.0);
  const auto distance = [](std::vector<double> sample, const auto& cdf) {
    std::sort(sample.begin(), sample.end());
    double worst = 0.0;
    for (std::size_t i = 0; i < sample.size(); ++i) {
      const auto n = static_cast<double>(sample.size());
      worst = std::max({worst, std::abs(cdf(sample[i]) - static_cast<double>(i) / n),
                        std::abs(cdf(sample[i]) - static_cast<double>(i + 1) / n)});
    }
    return worst;
  };
  EXPECT_LT(distance(column(points, 0), [](double x) { return (x + 1.0) / 4.0; }), limit);
  EXPECT_LT(distance(column(points, 1), [](double x) { return 0.5 * std::erfc(-(x - 5.0) / 2.0 / std::sqrt(2.0)); }),
            limit);
  std::map<std::string, int> integers, words;
  for (const auto& point : points) {
    ++integers[point[2]];
    ++words[point[3]];
  }
  ASSERT_EQ(integers.size(), 4U);
  ASSERT_EQ(words.size(), 3U);
  for (const auto& [word, count] : integers) EXPECT_NEAR(count, 5000, 5 * std::sqrt(5000.0)) << word;
  for (const auto& [word, count] : words) EXPECT_NEAR(count, 6667, 5 * std::sqrt(6667.0)) << word;
}

TEST(Sweep, NormalLawHasCutAndQuantiles) {
  ParameterConfig p = law(Law::kNormal, 0.0, 1.0);
  p.mean = 10.0;
  p.sd = 2.0;
  p.cut_sd = 8.0;
  EXPECT_NEAR(std::stod(quantile(p, 0.5)), 10.0, 1e-9);
  EXPECT_NEAR(std::stod(quantile(p, 0.975)), 10.0 + 2.0 * 1.959963985, 1e-6);
  p.cut_sd = 1.0;
  EXPECT_NEAR(std::stod(quantile(p, 0.0)), 8.0, 1e-9);
  EXPECT_NEAR(std::stod(quantile(p, 1.0 - 1e-16)), 12.0, 1e-6);
}

TEST(Sweep, AddedParameterKeepsOtherSamples) {
  SweepConfig sweep;
  for (const auto method : {SweepConfig::Method::kRandom, SweepConfig::Method::kLatinHypercube}) {
    sweep.method = method;
    sweep.parameters = {law(Law::kUniform, 0.0, 1.0)};
    const auto alone = column(sweep_points(sweep));
    sweep.parameters.insert(sweep.parameters.begin(), law(Law::kLogUniform, 1.0, 2.0));
    EXPECT_EQ(column(sweep_points(sweep), 1), alone);
    sweep.seed = 2;
    EXPECT_NE(column(sweep_points(sweep), 1), alone);
    sweep.seed = 1;
  }
}

}  // namespace
}  // namespace swiftlet::sim
