// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/hypotheses.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/math/random.hpp"
#include "tests/core/detection/detection_support.hpp"

namespace swiftlet {
namespace {

using namespace testing;
constexpr TimeNs kSweep = 100'000'000;

/// Returns at a height where the background is not known, and whatever is a candidate waits.
class Waiting {
 public:
  Waiting() {
    config.air.size_m = {64.0, 64.0, 32.0};
    config.background_share = 1.0;
    config.learning_delay_s = 60.0;
    config.rays_per_sweep = 10'000'000;
    hypotheses = std::make_unique<Hypotheses>(config);
  }
  /// A sweep of returns in voxels of their own, along x first.
  void take(std::size_t count, double z_m) {
    auto beams = std::make_shared<BeamTable>();
    beams->rows = 1;
    beams->cols = static_cast<int>(count);
    beams->column_offset_s.assign(count, 0.0F);
    beams->directions_lidar.assign(count, Eigen::Vector3f::UnitX());
    beams->origins_lidar.assign(count, Eigen::Vector3f::Zero());
    auto scan = std::make_shared<Scan>();
    scan->stamp = number_++ * kSweep;
    scan->beams = beams;
    scan->range_m.assign(count, 0.1F);  // too short to clear air
    LocalCloud cloud;
    cloud.scan = scan;
    cloud.T_local_lidar.assign(count, pose_at({0.0, 0.0, 0.0}));
    for (std::size_t i = 0; i < count; ++i) {
      cloud.points_local_m.push_back(place(i, z_m));
      cloud.beam.push_back(static_cast<std::uint32_t>(i));
    }
    hypotheses->take(cloud);
  }
  static Eigen::Vector3f place(std::size_t i, double z_m) {
    return {-29.75F + 0.5F * static_cast<float>(i % 100), -29.75F + 0.5F * static_cast<float>(i / 100),
            static_cast<float>(z_m)};
  }
  bool learned(std::size_t i, double z_m) const {
    return hypotheses->air().clutter_share(place(i, z_m).cast<double>()) > hypotheses->air().prior_share();
  }

  TrackBeforeDetectConfig config;
  std::unique_ptr<Hypotheses> hypotheses;

 private:
  TimeNs number_ = 0;
};

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
  EXPECT_LT(bird_sweeps / 200, 45.0) << "told for 4.5 s in the mean";
  EXPECT_LT(uav_small_sweeps / 200, 4.0) << "a fiftieth of 20 s";
}

TEST(Smallness, HiddenSilenceSaysLittle) {
  Smallness seen, hidden;
  seen.weigh(0, 30.0, 0.0, 0.02, 0.065, 1.0);
  hidden.weigh(0, 30.0, 1.0, 0.02, 0.065, 1.0);
  EXPECT_GT(seen.log_odds, 0.3);
  EXPECT_EQ(hidden.log_odds, 0.0);
  for (int i = 0; i < 1000; ++i) seen.weigh(0, 30.0, 0.0, 0.02, 0.065, 1.0);
  EXPECT_LT(seen.probability(), 0.998);
  for (int i = 0; i < 12; ++i) seen.weigh(4, 30.0, 0.0, 0.02, 0.065, 1.0);
  EXPECT_LT(seen.probability(), 0.5) << "it has learned better";
}

// A return without room to wait is background at once; of those that wait, the oldest.
TEST(Hypotheses, BoundsTheReturnsThatWait) {
  Waiting waiting;
  waiting.take(4098, 0.25);
  for (const std::size_t i : {0U, 1U, 2000U, 4095U}) EXPECT_FALSE(waiting.learned(i, 0.25)) << i;
  for (const std::size_t i : {4096U, 4097U}) EXPECT_TRUE(waiting.learned(i, 0.25)) << i;
  for (const double z_m : {1.25, 2.25, 3.25}) waiting.take(4096, z_m);
  EXPECT_FALSE(waiting.learned(0, 0.25)) << "16384 wait";
  waiting.take(2, 4.25);
  EXPECT_TRUE(waiting.learned(0, 0.25));
  EXPECT_TRUE(waiting.learned(1, 0.25));
  EXPECT_FALSE(waiting.learned(2, 0.25));
  EXPECT_FALSE(waiting.learned(1, 4.25));
}

}  // namespace
}  // namespace swiftlet
