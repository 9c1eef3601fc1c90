// SPDX-License-Identifier: BSD-3-Clause
// Fusion of several observers' estimates of one target with unknown correlation.
#include "core/shared_tracks/covariance_intersection.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <vector>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

using Vector = Eigen::Matrix<double, 6, 1>;

/// Any positive definite covariance: an ellipsoid turned at random, with axes of 0.05 to 2.
MotionEstimate drawn(const Random& random, int i) {
  Matrix6 A;
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 6; ++col) A(row, col) = random.normal(i, 10 + 6 * row + col);
  }
  const Matrix6 Q = A.householderQr().householderQ();
  Vector axes;
  for (int k = 0; k < 6; ++k) axes(k) = std::pow(10.0, random.uniform(-1.3, 0.3, i, 100 + k));
  MotionEstimate out;
  for (int k = 0; k < 6; ++k) out.mean(k) = random.normal(i, 200 + k);
  out.covariance = Q * axes.cwiseProduct(axes).asDiagonal() * Q.transpose();
  return out;
}

double determinant_of(const std::vector<MotionEstimate>& estimates, const std::vector<double>& weights) {
  Matrix6 information = Matrix6::Zero();
  for (std::size_t i = 0; i < weights.size(); ++i) information += weights[i] * estimates[i].covariance.inverse();
  return 1.0 / information.determinant();
}

/// Gains of the fusion, which is linear in the means.
std::vector<Matrix6> gains_of(std::vector<MotionEstimate> estimates) {
  for (MotionEstimate& estimate : estimates) estimate.mean.setZero();
  std::vector<Matrix6> gains(estimates.size());
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    for (int k = 0; k < 6; ++k) {
      estimates[i].mean = Vector::Unit(k);
      gains[i].col(k) = covariance_intersection(estimates).mean;
    }
    estimates[i].mean.setZero();
  }
  return gains;
}

TEST(CovarianceIntersection, MatchesFineWeightSearchForTwo) {
  for (int trial = 0; trial < 40; ++trial) {
    const Random random(trial, "test.intersection", "two");
    const std::vector<MotionEstimate> two = {drawn(random, 0), drawn(random, 1)};
    const double ours = covariance_intersection(two).covariance.determinant();
    for (int step = 0; step <= 1000; ++step) {
      EXPECT_LE(ours, determinant_of(two, {1e-3 * step, 1.0 - 1e-3 * step}) * (1.0 + 1e-4)) << trial << " " << step;
    }
  }
}

TEST(CovarianceIntersection, MatchesFineWeightSearchForThree) {
  for (int trial = 0; trial < 15; ++trial) {
    const Random random(trial, "test.intersection", "three");
    const std::vector<MotionEstimate> three = {drawn(random, 0), drawn(random, 1), drawn(random, 2)};
    const double ours = covariance_intersection(three).covariance.determinant();
    for (int i = 0; i <= 40; ++i) {
      for (int j = 0; i + j <= 40; ++j) {
        const double first = i / 40.0, second = j / 40.0;
        EXPECT_LE(ours, determinant_of(three, {first, second, 1.0 - first - second}) * (1.0 + 1e-4));
      }
    }
  }
}

/// Errors e_i = P_i^1/2 U_i z with a common z and orthogonal U_i are correlated as closely as possible. The fused error
/// must not exceed the reported covariance in any direction.
TEST(CovarianceIntersection, IsConsistentUnderAnyErrorCorrelation) {
  for (int trial = 0; trial < 60; ++trial) {
    const Random random(trial, "test.intersection", "common");
    const std::vector<MotionEstimate> estimates = {drawn(random, 0), drawn(random, 1), drawn(random, 2)};
    const std::vector<Matrix6> gains = gains_of(estimates);
    Matrix6 of_error = Matrix6::Zero();  // fused error as a linear map of z
    for (std::size_t i = 0; i < estimates.size(); ++i) {
      const Matrix6 root = estimates[i].covariance.llt().matrixL();
      Matrix6 U = Matrix6::Identity();
      if (trial % 3 == 1) U = -Matrix6::Identity() * (i == 0 ? 1.0 : -1.0);
      if (trial % 3 == 2) U = Matrix6(drawn(random, 7 + static_cast<int>(i)).covariance.householderQr().householderQ());
      of_error += gains[i] * root * U;
    }
    const Matrix6 reported = covariance_intersection(estimates).covariance;
    const Matrix6 margin = reported - of_error * of_error.transpose();
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Matrix6>(margin).eigenvalues()(0), -1e-9) << trial;
  }
}

TEST(CovarianceIntersection, GainsNothingFromARepetition) {
  MotionEstimate one;  // the second carries no new information
  const Matrix6 summed = 0.5 * one.covariance;
  EXPECT_LT(summed.determinant(), 0.1 * one.covariance.determinant());
  const std::vector<MotionEstimate> twice = {one, one};
  EXPECT_LT((covariance_intersection(twice).covariance - one.covariance).norm(), 1e-9);
}

TEST(CovarianceIntersection, GainsFromComplementaryCertainty) {
  MotionEstimate along_x, along_y;  // a distant LiDAR measures range well and bearing badly
  along_x.covariance(0, 0) = along_y.covariance(1, 1) = 1e-4;
  const std::vector<MotionEstimate> both = {along_x, along_y};
  const MotionEstimate fused = covariance_intersection(both);
  EXPECT_NEAR(fused.covariance(0, 0), 2e-4, 1e-6);  // each has half of the weight
  EXPECT_NEAR(fused.covariance(1, 1), 2e-4, 1e-6);
}

TEST(CovarianceIntersection, OfOneIsItself) {
  const Random random(1, "test.intersection", "one");
  const std::vector<MotionEstimate> one = {drawn(random, 0)};
  EXPECT_EQ(covariance_intersection(one).mean, one.front().mean);
  EXPECT_EQ(covariance_intersection(one).covariance, one.front().covariance);
}

TEST(CovarianceIntersection, TheOrderDoesNotMatter) {
  const Random random(2, "test.intersection", "order");
  const MotionEstimate a = drawn(random, 0), b = drawn(random, 1), c = drawn(random, 2);
  const MotionEstimate one = covariance_intersection(std::vector{a, b, c});
  const MotionEstimate other = covariance_intersection(std::vector{c, a, b});
  EXPECT_LT((one.mean - other.mean).norm(), 1e-9);
  EXPECT_LT((one.covariance - other.covariance).norm(), 1e-9);
}

TEST(PredictedMotion, IsIndependentOfStepDivision) {
  const Random random(3, "test.intersection", "predicted");
  const MotionEstimate start = drawn(random, 0);
  const MotionEstimate at_once = predicted(start, 0.6, 1.5), in_two = predicted(predicted(start, 0.2, 1.5), 0.4, 1.5);
  EXPECT_LT((at_once.mean - in_two.mean).norm(), 1e-12);
  EXPECT_LT((at_once.covariance - in_two.covariance).norm(), 1e-12);
}

TEST(PredictedMotion, GrowsExactStatesByAccelerationAlone) {
  MotionEstimate exact;
  exact.mean << 1, 2, 3, 4, 5, 6;
  exact.covariance.setZero();
  const MotionEstimate later = predicted(exact, 2.0, 3.0);
  EXPECT_EQ(later.p_m(), Vector3(9, 12, 15));
  EXPECT_DOUBLE_EQ(later.covariance(0, 0), 8.0);  // q t^3 / 3
  EXPECT_DOUBLE_EQ(later.covariance(0, 3), 6.0);  // q t^2 / 2
  EXPECT_DOUBLE_EQ(later.covariance(3, 3), 6.0);  // q t
}

TEST(DisagreementOfMotions, IsTheLogOfNormalDensity) {
  const Random random(4, "test.intersection", "disagreement");
  const MotionEstimate a = drawn(random, 0), b = drawn(random, 1);
  const Matrix6 S = a.covariance + b.covariance;
  const Vector between = a.mean - b.mean;
  const Disagreement found = disagreement(a, b);
  EXPECT_NEAR(found.squared_sigmas, between.dot(S.inverse() * between), 1e-9);
  EXPECT_NEAR(found.unlikelihood, found.squared_sigmas + std::log(S.determinant()), 1e-9);
  EXPECT_EQ(disagreement(b, a).squared_sigmas, found.squared_sigmas);
}

TEST(JointExistence, HasKnownLimits) {
  EXPECT_NEAR(joint_existence(std::vector{0.3}, 1e-3, 0.1), 0.3, 1e-12) << "one observer";
  EXPECT_NEAR(joint_existence(std::vector{0.4, 0.7, 0.6}, 1e-3, 1.0), 0.7, 1e-12) << "all clutter is common";
  EXPECT_NEAR(joint_existence(std::vector{0.6, 1e-3}, 1e-3, 0.1), 0.6, 1e-12) << "the second has no evidence";
  EXPECT_NEAR(joint_existence(std::vector{0.6, 1e-9}, 1e-3, 0.1), 0.6, 1e-12);
}

TEST(JointExistence, WithoutCommonClutterIsBayesRule) {
  // Odds over prior odds are likelihood ratios, which multiply.
  const double prior = 0.01, a = 0.3, b = 0.2;
  const auto odds = [](double p) { return p / (1.0 - p); };
  const double posterior = odds(prior) * (odds(a) / odds(prior)) * (odds(b) / odds(prior));
  EXPECT_NEAR(joint_existence(std::vector{a, b}, prior, 1e-12), posterior / (1.0 + posterior), 1e-9);
}

TEST(JointExistence, IsBoundedByCommonClutterShare) {
  const auto odds = [](double p) { return p / (1.0 - p); };
  for (const double second : {0.01, 0.1, 0.5, 0.9, 1.0}) {
    const double first = 0.2, joint = joint_existence(std::vector{first, second}, 2e-4, 0.1);
    EXPECT_LE(odds(joint), odds(std::max(first, std::min(second, 1.0 - 1e-9))) / 0.1 * (1.0 + 1e-9));
    EXPECT_GE(joint, std::max(first, std::min(second, 1.0 - 1e-9)) - 1e-12);
  }
}

TEST(JointExistence, TheOrderChangesNoBit) {
  EXPECT_EQ(joint_existence(std::vector{0.2, 0.5, 0.3}, 1e-4, 0.2),
            joint_existence(std::vector{0.3, 0.2, 0.5}, 1e-4, 0.2));
}

}  // namespace
}  // namespace swiftlet
