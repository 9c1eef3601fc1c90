// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/math/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace swiftlet {
namespace {

TEST(Random, IsIndependentOfCallOrder) {
  const Random a(7, "lidar.range", "uav1/os1");
  const Random b(7, "lidar.range", "uav1/os1");
  const double late = a.normal(1000, 131071);
  EXPECT_EQ(a.uniform(3, 5), b.uniform(3, 5));
  EXPECT_EQ(late, b.normal(1000, 131071));
}

TEST(Random, EveryPartOfTheKeyMatters) {
  const Random base(7, "lidar.range", "uav1/os1");
  EXPECT_NE(base.uniform(1, 1), Random(8, "lidar.range", "uav1/os1").uniform(1, 1));
  EXPECT_NE(base.uniform(1, 1), Random(7, "lidar.drop", "uav1/os1").uniform(1, 1));
  EXPECT_NE(base.uniform(1, 1), Random(7, "lidar.range", "uav2/os1").uniform(1, 1));
  EXPECT_NE(base.uniform(1, 1), base.uniform(2, 1));
  EXPECT_NE(base.uniform(1, 1), base.uniform(1, 2));
}

constexpr int kSamples = 100000;

/// Bounds: 5 standard errors of each estimate.
void expect_standard_normal(const std::vector<double>& x, const char* name) {
  const auto n = static_cast<double>(x.size());
  double sum = 0, sum2 = 0, sum3 = 0, sum4 = 0, lagged = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double v = x[i];
    ASSERT_TRUE(std::isfinite(v)) << name;
    sum += v;
    sum2 += v * v;
    sum3 += v * v * v;
    sum4 += v * v * v * v;
    lagged += i > 0 ? v * x[i - 1] : 0.0;
  }
  EXPECT_NEAR(sum / n, 0.0, 5.0 / std::sqrt(n)) << name;
  EXPECT_NEAR(sum2 / n, 1.0, 5.0 * std::sqrt(2.0 / n)) << name;
  EXPECT_NEAR(sum3 / n, 0.0, 5.0 * std::sqrt(15.0 / n)) << name;
  EXPECT_NEAR(sum4 / n, 3.0, 5.0 * std::sqrt(96.0 / n)) << name;
  EXPECT_NEAR(lagged / n, 0.0, 5.0 / std::sqrt(n)) << name;
  // Shares in the tails and the middle.
  for (const double limit : {0.5, 1.0, 2.0, 3.0, 4.0}) {
    double inside = 0;
    for (const double v : x) inside += std::abs(v) < limit ? 1.0 : 0.0;
    const double p = std::erf(limit / std::sqrt(2.0));
    EXPECT_NEAR(inside / n, p, 5.0 * std::sqrt(p * (1.0 - p) / n)) << name << ": within " << limit;
  }
}

void expect_uniform(const std::vector<double>& x, const char* name) {
  const auto n = static_cast<double>(x.size());
  double lagged = 0;
  std::vector<double> share(10, 0.0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    ASSERT_TRUE(x[i] >= 0.0 && x[i] < 1.0) << name;
    share[static_cast<std::size_t>(10.0 * x[i])] += 1.0 / n;
    lagged += i > 0 ? 12.0 * (x[i] - 0.5) * (x[i - 1] - 0.5) : 0.0;
  }
  for (const double tenth : share) EXPECT_NEAR(tenth, 0.1, 5.0 * std::sqrt(0.09 / n)) << name;
  EXPECT_NEAR(lagged / n, 0.0, 5.0 / std::sqrt(n)) << name;
}

TEST(Random, AllNormalsAreStandardNormal) {
  const Random random(9, "test");
  std::vector<double> single(kSamples), first(kSamples), second(kSamples), third(kSamples);
  for (std::size_t i = 0; i < single.size(); ++i) {
    const auto index = static_cast<std::uint32_t>(i);
    single[i] = random.normal(3, index);
    const auto n = random.normal3(3, index);
    first[i] = n[0];
    second[i] = n[1];
    third[i] = n[2];
  }
  expect_standard_normal(single, "normal");
  expect_standard_normal(first, "first of three");
  expect_standard_normal(second, "second of three");
  expect_standard_normal(third, "third of three");
  std::vector<float> filled(4 * kSamples);
  random.fill_normal(3, 0, filled);
  expect_standard_normal({filled.begin(), filled.end()}, "filled");
}

TEST(Random, ComponentsOfADrawAreIndependent) {
  const Random random(1, "test");
  double xy = 0, yz = 0, zx = 0, of_squares = 0;
  for (std::uint32_t i = 0; i < kSamples; ++i) {
    const auto n = random.normal3(0, i);
    xy += n[0] * n[1] / kSamples;
    yz += n[1] * n[2] / kSamples;
    zx += n[2] * n[0] / kSamples;
    of_squares += (n[0] * n[0] - 1.0) * (n[1] * n[1] - 1.0) / kSamples;
  }
  for (const double correlation : {xy, yz, zx}) EXPECT_NEAR(correlation, 0.0, 5.0 / std::sqrt(kSamples));
  EXPECT_NEAR(of_squares, 0.0, 5.0 * 2.0 / std::sqrt(kSamples));
}

TEST(Random, AllUniformsFillTheirInterval) {
  const Random random(9, "test");
  std::vector<double> single(kSamples);
  for (std::size_t i = 0; i < single.size(); ++i) single[i] = random.uniform(3, static_cast<std::uint32_t>(i));
  expect_uniform(single, "uniform");
  std::vector<float> filled(kSamples);
  random.fill_uniform(3, 0, filled);
  expect_uniform({filled.begin(), filled.end()}, "filled");
}

TEST(Random, FillIsIndependentOfTheSplit) {
  const Random random(1, "test");
  std::vector<float> whole(103), parts(103);
  random.fill_normal(4, 10, whole);
  random.fill_normal(4, 10, std::span(parts).first(50));
  random.fill_normal(4, 60, std::span(parts).subspan(50));
  EXPECT_EQ(whole, parts);
  random.fill_uniform(4, 10, whole);
  random.fill_uniform(4, 10, std::span(parts).first(7));
  random.fill_uniform(4, 17, std::span(parts).subspan(7));
  EXPECT_EQ(whole, parts);
  for (const float u : whole) {
    EXPECT_GE(u, 0.0F);
    EXPECT_LT(u, 1.0F);
  }
}

}  // namespace
}  // namespace swiftlet
