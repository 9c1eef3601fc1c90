// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/math/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace swiftlet {
namespace {

TEST(Random, SameKeysGiveSameNumbersInAnyOrder) {
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

TEST(Random, NormalHasTheMomentsOfAStandardNormal) {
  const Random random(1, "test");
  constexpr int kSamples = 200000;
  double sum = 0, sum2 = 0, sum4 = 0, cross = 0;
  for (int i = 0; i < kSamples; ++i) {
    const auto n = random.normal3(0, i);
    sum += n[0];
    sum2 += n[1] * n[1];
    sum4 += std::pow(n[2], 4);
    cross += n[0] * n[1];
  }
  // Bounds: 5 standard errors of each estimate.
  EXPECT_NEAR(sum / kSamples, 0.0, 5.0 / std::sqrt(kSamples));
  EXPECT_NEAR(sum2 / kSamples, 1.0, 5.0 * std::sqrt(2.0 / kSamples));
  EXPECT_NEAR(sum4 / kSamples, 3.0, 5.0 * std::sqrt(96.0 / kSamples));
  EXPECT_NEAR(cross / kSamples, 0.0, 5.0 / std::sqrt(kSamples));
}

TEST(Random, FilledNumbersDoNotDependOnTheSplit) {
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

TEST(Random, FilledNormalsHaveTheDistributionOfAStandardNormal) {
  const Random random(9, "test.fill");
  constexpr int kSamples = 400000;
  std::vector<float> x(kSamples);
  random.fill_normal(3, 0, x);
  double sum = 0, sum2 = 0, sum3 = 0, sum4 = 0, lagged = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double v = x[i];
    ASSERT_TRUE(std::isfinite(v));
    sum += v;
    sum2 += v * v;
    sum3 += v * v * v;
    sum4 += v * v * v * v;
    lagged += i > 0 ? v * x[i - 1] : 0.0;
  }
  // Bounds: 5 standard errors of each estimate.
  EXPECT_NEAR(sum / kSamples, 0.0, 5.0 / std::sqrt(kSamples));
  EXPECT_NEAR(sum2 / kSamples, 1.0, 5.0 * std::sqrt(2.0 / kSamples));
  EXPECT_NEAR(sum3 / kSamples, 0.0, 5.0 * std::sqrt(15.0 / kSamples));
  EXPECT_NEAR(sum4 / kSamples, 3.0, 5.0 * std::sqrt(96.0 / kSamples));
  EXPECT_NEAR(lagged / kSamples, 0.0, 5.0 / std::sqrt(kSamples));
  // Shares in the tails and the middle against the normal distribution.
  for (const double limit : {0.5, 1.0, 2.0, 3.0, 4.0}) {
    int inside = 0;
    for (const float v : x) inside += std::abs(v) < limit ? 1 : 0;
    const double p = std::erf(limit / std::sqrt(2.0));
    EXPECT_NEAR(static_cast<double>(inside) / kSamples, p, 5.0 * std::sqrt(p * (1.0 - p) / kSamples)) << limit;
  }
}

}  // namespace
}  // namespace swiftlet
