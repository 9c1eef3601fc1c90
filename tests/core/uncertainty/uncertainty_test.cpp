// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/uncertainty/error_distribution.hpp"
#include "swiftlet/core/uncertainty/point_covariance.hpp"
#include "swiftlet/core/uncertainty/voxel_probability.hpp"

namespace swiftlet {
namespace {

const Random kRandom(1, "uncertainty_test");

Vector3 normals(std::uint32_t index, std::uint32_t set = 0) {
  const auto n = kRandom.normal3(set, index);
  return {n[0], n[1], n[2]};
}

Matrix3 random_rotation(std::uint32_t index) {
  const Vector3 v = normals(index, 7);
  return Eigen::Quaterniond(kRandom.normal(8, index), v.x(), v.y(), v.z()).normalized().toRotationMatrix();
}

Matrix3 random_covariance(std::uint32_t index, double smallest) {
  const Matrix3 R = random_rotation(index);
  return R * Vector3(smallest, 0.3, 1.7).cwiseAbs2().asDiagonal() * R.transpose();
}

TEST(PointCovariance, JacobianAgreesWithNumericalDifferentiation) {
  for (int k = 0; k < 20; ++k) {
    const Vector3 d = normals(k, 1).normalized();
    Pose T = Pose::Identity();
    T.linear() = random_rotation(k);
    T.translation() = 10.0 * normals(k, 2);
    const double range_m = kRandom.uniform(0.5, 90.0, 3, k);
    const Jacobian37 J = point_jacobian(d, range_m, T.linear());
    constexpr double kStep = 1e-6;
    for (int column = 0; column < 7; ++column) {
      Eigen::Matrix<double, 7, 1> w = Eigen::Matrix<double, 7, 1>::Zero();
      w[column] = kStep;
      const Vector3 numeric = (true_point(d, range_m, T, w) - true_point(d, range_m, T, -w)) / (2.0 * kStep);
      EXPECT_LT((J.col(column) - numeric).norm(), 1e-7 * std::max(1.0, range_m)) << "column " << column;
    }
  }
}

TEST(PointCovariance, SeparatesRadialAndLateralError) {
  MeasurementNoise noise;
  const Matrix3 Sigma = point_covariance(Vector3::UnitX(), 20.0, Matrix3::Identity(), noise.Sigma_w());
  EXPECT_NEAR(Sigma(0, 0), 0.03 * 0.03 + 0.05 * 0.05, 1e-12);
  EXPECT_NEAR(Sigma(1, 1), 0.05 * 0.05 + std::pow(20.0 * 0.005, 2), 1e-12);
  EXPECT_NEAR(Sigma(2, 2), Sigma(1, 1), 1e-12);
  EXPECT_NEAR(Sigma(0, 1), 0.0, 1e-12);
}

TEST(ErrorDistribution, IsotropicCaseIsTheMaxwellDistribution) {
  // For Sigma = s^2 I the error is chi-distributed with 3 degrees of freedom: mean s sqrt(8 / pi).
  const ErrorDistribution error(0.25 * Matrix3::Identity());
  EXPECT_NEAR(error.shape(), 1.5, 1e-12);
  EXPECT_NEAR(error.mean_m(), 0.5 * std::sqrt(8.0 / M_PI), 1e-12);
  EXPECT_NEAR(error.variance_m2(), 0.25 * (3.0 - 8.0 / M_PI), 1e-12);
}

TEST(ErrorDistribution, OneDimensionalCaseIsHalfNormal) {
  Matrix3 Sigma = Matrix3::Zero();
  Sigma(1, 1) = 4.0;
  const ErrorDistribution error(Sigma);
  EXPECT_NEAR(error.shape(), 0.5, 1e-12);
  EXPECT_NEAR(error.mean_m(), 2.0 * std::sqrt(2.0 / M_PI), 1e-12);
  EXPECT_NEAR(error.cdf(2.0), std::erf(1.0 / std::sqrt(2.0)), 1e-12);
}

TEST(ErrorDistribution, CdfIntegratesPdfAndInvertsQuantile) {
  const ErrorDistribution error(random_covariance(3, 0.1));
  double sum = 0.0;
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) sum += error.pdf((i + 0.5) * 2.0 / kSteps) * 2.0 / kSteps;
  EXPECT_NEAR(sum, error.cdf(2.0), 1e-4);
  for (const double p : {0.01, 0.5, 0.95}) EXPECT_NEAR(error.cdf(error.quantile_m(p)), p, 1e-12);
  EXPECT_EQ(error.pdf(-0.1), 0.0);
  EXPECT_EQ(error.cdf(-0.1), 0.0);
}

TEST(ErrorDistribution, MeanMatchesMonteCarlo) {
  // The Nakagami form matches two moments; its mean is within a few per cent for any shape of ellipsoid.
  for (int k = 0; k < 5; ++k) {
    const Matrix3 Sigma = random_covariance(k, 0.05);
    const Matrix3 L = Sigma.llt().matrixL();
    double sum = 0.0;
    constexpr int kSamples = 100000;
    for (int i = 0; i < kSamples; ++i) sum += (L * normals(i, 20 + k)).norm();
    EXPECT_NEAR(ErrorDistribution(Sigma).mean_m(), sum / kSamples, 0.03 * sum / kSamples);
  }
}

TEST(BoxProbability, IndependentAxesMultiply) {
  const Vector3 sigma(0.2, 1.0, 3.0);
  const Eigen::AlignedBox3d box(Vector3(-0.1, -2.0, 0.5), Vector3(0.4, 0.3, 4.0));
  double expected = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto Phi = [&](double x) { return 0.5 * std::erfc(-x / (sigma[axis] * std::sqrt(2.0))); };
    expected *= Phi(box.max()[axis]) - Phi(box.min()[axis]);
  }
  EXPECT_NEAR(box_probability(Vector3::Zero(), sigma.cwiseAbs2().asDiagonal(), box), expected, 1e-9);
}

TEST(BoxProbability, MatchesTheKnownEquicorrelatedOrthant) {
  // P(all x > 0) = 1/8 + 3 arcsin(rho) / (4 pi)
  for (const double rho : {-0.45, 0.0, 0.5, 0.95}) {
    Matrix3 Sigma = Matrix3::Constant(rho);
    Sigma.diagonal().setOnes();
    const Eigen::AlignedBox3d orthant(Vector3::Zero(), Vector3::Constant(100.0));
    EXPECT_NEAR(box_probability(Vector3::Zero(), Sigma, orthant), 0.125 + 3.0 * std::asin(rho) / (4.0 * M_PI), 1e-7)
        << rho;
  }
}

TEST(BoxProbability, MatchesMonteCarloForThinEllipsoids) {
  const Eigen::AlignedBox3d box(Vector3(-0.3, -0.5, -0.2), Vector3(0.7, 0.5, 0.8));
  for (int k = 0; k < 6; ++k) {
    const Matrix3 Sigma = random_covariance(k, k < 3 ? 0.2 : 1e-3);
    const Matrix3 L = Sigma.llt().matrixL();
    constexpr int kSamples = 200000;
    int inside = 0;
    for (int i = 0; i < kSamples; ++i) inside += box.contains(L * normals(i, 40 + k)) ? 1 : 0;
    const double p = box_probability(Vector3::Zero(), Sigma, box);
    EXPECT_NEAR(p, static_cast<double>(inside) / kSamples, 5.0 * std::sqrt(p * (1.0 - p) / kSamples)) << "case " << k;
  }
}

TEST(BoxProbability, SumsToOneOverATiling) {
  const Matrix3 Sigma = random_covariance(9, 0.01);
  double sum = 0.0;
  for (int x = -3; x < 3; ++x) {
    for (int y = -3; y < 3; ++y) {
      for (int z = -3; z < 3; ++z) {
        const Vector3 corner = 3.0 * Vector3(x, y, z);
        sum += box_probability(Vector3(0.1, 0.2, 0.3), Sigma, {corner, corner + Vector3::Constant(3.0)});
      }
    }
  }
  EXPECT_NEAR(sum, 1.0, 2e-6);
}

TEST(BoxProbability, DegenerateCovarianceIsAPointMass) {
  const Eigen::AlignedBox3d box(Vector3::Constant(-1.0), Vector3::Constant(1.0));
  EXPECT_NEAR(box_probability(Vector3::Zero(), Matrix3::Zero(), box), 1.0, 1e-9);
  EXPECT_EQ(box_probability(Vector3::Constant(2.0), Matrix3::Zero(), box), 0.0);
}

// The axes may be integrated over in any order.
TEST(BoxProbability, IsIndependentOfAxisOrder) {
  for (int k = 0; k < 16; ++k) {
    const Matrix3 Sigma = random_covariance(100 + k, k % 4 == 0 ? 0.5 : k % 4 == 1 ? 0.1 : k % 4 == 2 ? 0.01 : 1e-3);
    const Vector3 mean = 0.5 * normals(k, 60);
    const Vector3 corner = -0.5 * normals(k, 61).cwiseAbs() - Vector3::Constant(0.1);
    const Eigen::AlignedBox3d box(corner, corner + 1.5 * normals(k, 62).cwiseAbs() + Vector3::Constant(0.2));
    const double p = box_probability(mean, Sigma, box);
    for (const auto& [a, b, c] :
         {std::array{0, 2, 1}, std::array{1, 0, 2}, std::array{1, 2, 0}, std::array{2, 0, 1}, std::array{2, 1, 0}}) {
      Matrix3 order = Matrix3::Zero();
      order(0, a) = order(1, b) = order(2, c) = 1.0;
      const Eigen::AlignedBox3d turned(Vector3(order * box.min()), Vector3(order * box.max()));
      EXPECT_NEAR(box_probability(order * mean, order * Sigma * order.transpose(), turned), p, 2e-9)
          << k << ": " << a << b << c;
    }
  }
}

// All of it lies on a line, of which the box cuts out a piece. Of the variance beside it, rounding leaves 1e-15.
TEST(BoxProbability, LineDistributionMatchesItsSegmentInside) {
  const auto Phi = [](double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); };
  for (int k = 0; k < 20; ++k) {
    const Vector3 along = normals(k, 70);
    const Vector3 low = -normals(k, 71).cwiseAbs(), high = normals(k, 72).cwiseAbs();
    double from = -1e9, to = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = low[axis] / along[axis], b = high[axis] / along[axis];
      from = std::max(from, std::min(a, b));
      to = std::min(to, std::max(a, b));
    }
    EXPECT_NEAR(box_probability(Vector3::Zero(), along * along.transpose(), {low, high}), Phi(to) - Phi(from), 1e-6)
        << k;
  }
}

// For a coordinate without variance, the box includes its lower face and excludes its upper one.
TEST(BoxProbability, CertainCoordinateIsInsideOrOutside) {
  for (int axis = 0; axis < 3; ++axis) {
    Vector3 variance(0.3, 0.5, 0.7);
    variance[axis] = 0.0;
    Vector3 low = Vector3::Constant(-50.0), high = Vector3::Constant(50.0);
    const auto p = [&](double from, double to) {
      low[axis] = from;
      high[axis] = to;
      return box_probability(Vector3::Constant(0.25), variance.asDiagonal(), {low, high});
    };
    EXPECT_NEAR(p(0.25, 1.0), 1.0, 1e-9) << axis;
    EXPECT_NEAR(p(-1.0, 0.25), 0.0, 1e-12) << axis;
    EXPECT_NEAR(p(0.0, 0.5), 1.0, 1e-9) << axis;
    EXPECT_NEAR(p(0.3, 0.5), 0.0, 1e-12) << axis;
  }
}

// In both tails, where 1 - Phi would lose all digits.
TEST(BoxProbability, IsAccurateInTheTails) {
  for (const double sign : {-1.0, 1.0}) {
    for (const double from : {3.0, 5.0, 6.0}) {
      Vector3 low = Vector3::Constant(-40.0), high = Vector3::Constant(40.0);
      (sign > 0.0 ? low : high).z() = sign * from;
      const double tail = 0.5 * std::erfc(from / std::sqrt(2.0));
      EXPECT_NEAR(box_probability(Vector3::Zero(), Matrix3::Identity(), {low, high}), tail, 1e-6 * tail) << sign * from;
    }
  }
}

TEST(CorrectVoxel, IsLikelierWhenNearOrLarge) {
  const MeasurementNoise noise;
  double previous = 1.0;
  for (const double range_m : {5.0, 20.0, 50.0, 80.0}) {
    const Vector3 p(range_m + 0.5, 0.5, 0.5);
    const Matrix3 Sigma = point_covariance(Vector3::UnitX(), range_m, Matrix3::Identity(), noise.Sigma_w());
    const double probability = correct_voxel_probability(p, Sigma, 1.0);
    EXPECT_LT(probability, previous + 1e-9);
    EXPECT_GE(correct_voxel_probability(Vector3(2.0 * std::floor(range_m / 2.0) + 1.0, 1.0, 1.0), Sigma, 2.0),
              probability);
    previous = probability;
  }
}

}  // namespace
}  // namespace swiftlet
