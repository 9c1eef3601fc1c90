// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/hypotheses.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

// Brute force: the gamma distribution of the share, and Poisson numbers of returns.
TEST(Smallness, WeighsSweepsByNegativeBinomialLikelihoods) {
  const auto likelihood = [](int n, double mean, double variation) {
    double sum = 0.0, norm = 0.0;
    for (int i = 0; i < 200'000; ++i) {
      const double x = 1e-4 * (i + 0.5);  // times the mean
      const double weight = std::pow(x, variation - 1.0) * std::exp(-variation * x);
      norm += weight;
      sum += weight * std::pow(mean * x, n) * std::exp(-mean * x) / std::tgamma(n + 1.0);
    }
    return sum / norm;
  };
  for (const double variation : {1.0, 2.5}) {
    for (const double shots : {2.0, 30.0}) {
      for (const int n : {0, 1, 4}) {
        Smallness small;
        small.weigh(n, shots, 0.0, 0.02, 0.065, variation);
        const double ratio = likelihood(n, 0.02 * shots, variation) / likelihood(n, 0.065 * shots, variation);
        EXPECT_NEAR(small.log_odds, std::log(ratio), 1e-3) << variation << ' ' << shots << ' ' << n;
      }
    }
  }
}

TEST(Smallness, SeparatesBirdsFromTheSmallestUav) {
  const Random random(11, "smallness");
  constexpr double kShots = 7.5, kPrior = 0.05;  // a Mid-360 at 10 m
  int birds = 0, uavs = 0;
  double bird_sweeps = 0.0, uav_small_sweeps = 0.0;
  for (std::uint32_t flight = 0; flight < 200; ++flight) {
    for (const bool bird : {true, false}) {
      Smallness small{std::log(kPrior / (1.0 - kPrior))};
      for (std::uint32_t sweep = 0; sweep < 200; ++sweep) {
        const double share = (bird ? 0.02 : 0.065) * -std::log(random.uniform(flight, 4 * sweep + bird));
        int n = 0;  // Poisson
        for (double left = share * kShots, u = random.uniform(flight, 4 * sweep + 2 + bird), p = std::exp(-left),
                    sum = p;
             u > sum && n < 50; sum += p) {
          p *= left / ++n;
        }
        small.weigh(n, kShots, 0.0, 0.02, 0.065, 1.0);
        (bird ? bird_sweeps : uav_small_sweeps) += (bird ? small.probability() < 0.5 : small.probability() > 0.5);
      }
      (bird ? birds : uavs) += small.probability() > 0.5;
    }
  }
  EXPECT_GT(birds, 195);
  EXPECT_LT(uavs, 5);
  EXPECT_LT(bird_sweeps / 200, 45.0) << "reported for 4.5 s on average";
  EXPECT_LT(uav_small_sweeps / 200, 4.0) << "2 % of 20 s";
}

TEST(Smallness, HiddenSilenceIsWeakEvidence) {
  Smallness seen, hidden;
  seen.weigh(0, 30.0, 0.0, 0.02, 0.065, 1.0);
  hidden.weigh(0, 30.0, 1.0, 0.02, 0.065, 1.0);
  EXPECT_GT(seen.log_odds, 0.3);
  EXPECT_EQ(hidden.log_odds, 0.0);
  for (int i = 0; i < 1000; ++i) seen.weigh(0, 30.0, 0.0, 0.02, 0.065, 1.0);
  EXPECT_LT(seen.probability(), 0.998);
  for (int i = 0; i < 12; ++i) seen.weigh(4, 30.0, 0.0, 0.02, 0.065, 1.0);
  EXPECT_LT(seen.probability(), 0.5) << "returns outweigh earlier silence";
}

}  // namespace
}  // namespace swiftlet
