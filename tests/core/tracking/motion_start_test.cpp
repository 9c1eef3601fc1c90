// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "swiftlet/core/tracking/motion_filter.hpp"

namespace swiftlet {
namespace {

TEST(InitialSpread, CombinesPositionSpreadWithConfiguredSigmas) {
  InitialSpread spread;
  spread.sigma_velocity_mps = 3.0;
  spread.sigma_acceleration_mps2 = 5.0;
  Matrix3 P0;
  P0 << 0.4, 0.1, 0.0, 0.1, 0.3, 0.05, 0.0, 0.05, 0.2;
  const MotionBelief belief = spread.at_rest({1, 2, 3}, P0);
  Matrix9 expected = Matrix9::Zero();
  expected.topLeftCorner<3, 3>() = P0;
  expected.block<3, 3>(3, 3).diagonal().setConstant(9.0);
  expected.block<3, 3>(6, 6).diagonal().setConstant(25.0);
  EXPECT_LT((belief.covariance - expected).norm(), 1e-12);
  Vector9 mean = Vector9::Zero();
  mean.head<3>() = Vector3(1, 2, 3);
  EXPECT_EQ(belief.mean, mean);
}

// After a time t without noise the position's variance is P_0 + t^2 s_v^2 + t^4 / 4 s_a^2.
TEST(InitialSpread, SpreadsThePositionByTheParabola) {
  KalmanConfig config;
  config.process = {};
  config.process.sigma_position_m = config.process.sigma_velocity_mps = config.process.sigma_acceleration_mps2 = 0.0;
  config.initial.sigma_velocity_mps = 2.0;
  config.initial.sigma_acceleration_mps2 = 3.0;
  const auto filter = make_kalman_filter(config);
  MotionState state = filter->start(Vector3::Zero(), 0.25 * Matrix3::Identity());
  for (int i = 0; i < 8; ++i) filter->predict(state, 0.25);
  const double t = 2.0, expected = 0.25 + t * t * 4.0 + 0.25 * std::pow(t, 4) * 9.0;
  EXPECT_LT((state.belief.position_covariance() - expected * Matrix3::Identity()).norm(), 1e-9);
}

TEST(ProcessNoise, SquaresEachOfItsSigmas) {
  const ProcessNoise noise{0.1, 0.2, 0.3};
  Vector9 variance;
  variance << 0.01, 0.01, 0.01, 0.04, 0.04, 0.04, 0.09, 0.09, 0.09;
  EXPECT_LT((noise.covariance(0.2, 0.1) - 2.0 * Matrix9(variance.asDiagonal())).norm(), 1e-12);
}

TEST(TurnRate, VanishesWhenSlowAndStaysBounded) {
  const auto rate = [](double v, double a) {
    Vector9 mean = Vector9::Zero();
    mean[3] = v;
    mean[7] = a;
    return turn_rate_radps(mean);
  };
  EXPECT_EQ(rate(0.49, 1.0), 0.0);
  EXPECT_NEAR(rate(0.51, 1.0), 1.0 / 0.51, 1e-12);
  EXPECT_NEAR(rate(2.0, -3.0), 1.5, 1e-12);
  EXPECT_EQ(rate(1.0, 100.0), 4.0);
}

// Likelihood of a measurement: the Gaussian of the innovation, written out for independent axes.
TEST(CorrectBelief, ReturnsTheLogarithmOfTheGaussian) {
  MotionBelief belief;
  belief.mean.setZero();
  belief.covariance.setIdentity();
  const Vector3 variance(1.5, 2.0, 5.0), z(0.3, -0.7, 1.1);
  const Matrix3 Z = (variance - Vector3::Ones()).asDiagonal();
  double expected = 0.0;
  for (int i = 0; i < 3; ++i) expected -= 0.5 * (z[i] * z[i] / variance[i] + std::log(2.0 * M_PI * variance[i]));
  EXPECT_NEAR(correct_belief(belief, z, Z), expected, 1e-12);
}

}  // namespace
}  // namespace swiftlet
