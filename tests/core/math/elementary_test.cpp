// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/base/elementary.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

constexpr double kUnit = std::numeric_limits<double>::epsilon();

// Against libm in extended precision: `units` in the last place of the result or of 1 for what passes through zero.
template <class Ours, class Theirs>
void expect_close(Ours ours, Theirs theirs, double low, double high, double units, double floor = 0.0) {
  const Random random(3, "test.elementary");
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const double x = random.uniform(low, high, 0, i);
    const auto expected = static_cast<double>(theirs(static_cast<long double>(x)));
    ASSERT_NEAR(ours(x), expected, units * kUnit * std::max(std::abs(expected), floor)) << "at " << x;
  }
}

TEST(ElementaryFunctions, AreAccurateToAFewUlps) {
  using namespace elementary;
  const auto of = [](auto f) { return f; };
  expect_close([](double x) { return elementary::sin(x); }, of([](long double x) { return sinl(x); }), -50, 50, 2,
               0.01);
  expect_close([](double x) { return elementary::cos(x); }, of([](long double x) { return cosl(x); }), -50, 50, 2,
               0.01);
  expect_close([](double x) { return elementary::sin(x); }, of([](long double x) { return sinl(x); }), -9e4, 9e4, 2,
               0.1);
  expect_close([](double x) { return elementary::tan(x); }, of([](long double x) { return tanl(x); }), -1.5, 1.5, 4);
  expect_close([](double x) { return elementary::exp(x); }, of([](long double x) { return expl(x); }), -30, 30, 2);
  expect_close([](double x) { return elementary::exp(x); }, of([](long double x) { return expl(x); }), -700, 700, 2);
  expect_close([](double x) { return elementary::exp2(x); }, of([](long double x) { return exp2l(x); }), -60, 60, 2);
  expect_close([](double x) { return elementary::log(x); }, of([](long double x) { return logl(x); }), 1e-6, 3, 2, 0.1);
  expect_close([](double x) { return elementary::log(x); }, of([](long double x) { return logl(x); }), 1, 1e9, 2, 0.1);
  expect_close([](double x) { return elementary::asin(x); }, of([](long double x) { return asinl(x); }), -1, 1, 3, 0.1);
  expect_close([](double x) { return elementary::acos(x); }, of([](long double x) { return acosl(x); }), -1, 1, 3, 0.1);
  expect_close([](double x) { return elementary::cbrt(x); }, of([](long double x) { return cbrtl(x); }), -1e3, 1e3, 2);
  expect_close([](double x) { return elementary::pow(x, 0.37); }, of([](long double x) { return powl(x, 0.37); }), 1e-3,
               1e3, 8);
  expect_close([](double x) { return elementary::hypot(x, 1.7); }, of([](long double x) { return hypotl(x, 1.7L); }),
               -9, 9, 2);
}

TEST(ElementaryFunctions, OfAnAngleFindEveryQuadrant) {
  const Random random(4, "test.elementary");
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const double y = random.uniform(-1, 1, 0, i), x = random.uniform(-1, 1, 1, i);
    ASSERT_NEAR(elementary::atan2(y, x), std::atan2(y, x), 3 * kUnit * std::numbers::pi) << y << ", " << x;
  }
  for (const double y : {-2.0, -0.0, 0.0, 2.0}) {
    for (const double x : {-2.0, -0.0, 0.0, 2.0}) EXPECT_DOUBLE_EQ(elementary::atan2(y, x), std::atan2(y, x));
  }
}

TEST(ElementaryFunctions, AtTheEndsOfTheirRange) {
  EXPECT_EQ(elementary::exp(-HUGE_VAL), 0.0);
  EXPECT_EQ(elementary::exp(1000.0), HUGE_VAL);
  EXPECT_TRUE(std::isnan(elementary::exp(std::nan(""))));
  EXPECT_NEAR(elementary::exp(-744.0) / std::exp(-744.0), 1.0, 0.5);
  EXPECT_EQ(elementary::exp(0.0), 1.0);
  EXPECT_EQ(elementary::log(1.0), 0.0);
  EXPECT_EQ(elementary::log(0.0), -HUGE_VAL);
  EXPECT_EQ(elementary::pow(0.0, 2.0), 0.0);
  EXPECT_EQ(elementary::pow(5.0, 0.0), 1.0);
  EXPECT_EQ(elementary::cbrt(0.0), 0.0);
  EXPECT_EQ(elementary::sin(0.0), 0.0);
  EXPECT_EQ(elementary::cos(0.0), 1.0);
  EXPECT_LE(std::abs(elementary::sin(1e15)), 1.0);
}

}  // namespace
}  // namespace swiftlet
