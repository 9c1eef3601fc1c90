// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/body_parts.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/detection/existence.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

using Returns = std::vector<Vector3>;

TEST(BodyParts, NeedsThreeReturnsAndBoundsCertainty) {
  BodyParts parts;
  const Returns left = {{0.0, 0.0, 0.0}}, right = {{1.0, 0.0, 0.0}}, most = Returns(100, {1.0, 0.0, 0.0});
  EXPECT_FALSE(parts.weigh(1, left, 2, right));
  EXPECT_EQ(parts.log_odds(1, 2), 0.0);
  EXPECT_FALSE(parts.weigh(1, left, 2, most));
  EXPECT_EQ(parts.log_odds(1, 2), -kMaxLogOdds);
  EXPECT_FALSE(parts.weigh(1, left, 2, Returns(3, {0.0, 0.0, 0.0}))) << "in one place";
  for (int i = 0; i < 50; ++i) parts.begin_sweep();
  EXPECT_EQ(parts.log_odds(1, 2), -kMaxLogOdds);
  parts.begin_sweep();
  EXPECT_EQ(parts.log_odds(1, 2), 0.0) << "forgotten";
}

TEST(BodyParts, PairsThatAreRememberedAreBounded) {
  BodyParts parts;
  const Returns left = {{0.0, 0.0, 0.0}}, right = {{1.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
  const auto most = static_cast<std::uint32_t>(BodyParts::kMaxPairs);
  for (std::uint32_t k = 0; k <= most; ++k) parts.weigh(0, left, k + 1, right);
  EXPECT_LT(parts.log_odds(0, most), 0.0);
  EXPECT_EQ(parts.log_odds(0, most + 1), 0.0);
  parts.forget(0);
  parts.weigh(0, left, most + 1, right);
  EXPECT_LT(parts.log_odds(0, most + 1), 0.0);
}

/// Number of 200 flights of 10 s that end with one body. Returns are uniform on one body, or on one of two.
int taken_for_one(double length_m, double gap_m, double returns_per_sweep) {
  int ones = 0;
  for (std::uint32_t flight = 0; flight < 200; ++flight) {
    const Random random(flight, "parts");
    BodyParts parts;
    bool one = false;
    for (std::uint32_t sweep = 0; sweep < 100 && !one; ++sweep) {
      parts.begin_sweep();
      Returns a, b;
      for (std::uint32_t k = 0; k < 40; ++k) {
        if (random.uniform(sweep, 3 * k) > returns_per_sweep / 40.0) continue;
        const double along_m = (random.uniform(sweep, 3 * k + 1) - 0.5) * length_m;
        const double x_m = along_m + std::copysign(0.5 * gap_m, along_m);
        (x_m < 0.0 ? a : b).emplace_back(x_m, 0.1 * random.uniform(sweep, 3 * k + 2), 0.0);
      }
      if (a.empty() || b.empty()) continue;
      one = parts.weigh(1, a, 2, b);
    }
    ones += one;
  }
  return ones;
}

TEST(BodyParts, DistinguishesOneBodyFromTwo) {
  EXPECT_GE(taken_for_one(2.0, 0.0, 2.0), 80) << "the means of so few are returns themselves";
  for (const double returns_per_sweep : {6.0, 20.0}) EXPECT_GE(taken_for_one(2.0, 0.0, returns_per_sweep), 190);
  for (const double returns_per_sweep : {2.0, 6.0, 20.0}) EXPECT_LE(taken_for_one(1.0, 0.5, returns_per_sweep), 4);
}

}  // namespace
}  // namespace swiftlet
