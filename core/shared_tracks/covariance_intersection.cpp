// SPDX-License-Identifier: BSD-3-Clause
#include "core/shared_tracks/covariance_intersection.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

/// [-] Maximum number of iterations of the weights; the tolerance usually ends them earlier.
constexpr int kMaxSteps = 300;
constexpr double kAlmostBest = 1e-5;  // tolerance of the logarithm of the determinant, by degree of freedom
/// [-] Upper bound of a probability in odds, which keeps them finite.
constexpr double kSurest = 1.0 - 1e-9;

Matrix6 inverse_of(const Matrix6& C) {
  const Matrix6 I = C.llt().solve(Matrix6::Identity());
  return 0.5 * (I + I.transpose());
}

}  // namespace

MotionEstimate predicted(const MotionEstimate& estimate, double dt_s, double acceleration_density) {
  ENSURE(dt_s >= 0.0, dt_s);
  MotionEstimate next = estimate;
  next.mean.head<3>() += dt_s * estimate.mean.tail<3>();
  Matrix6 F = Matrix6::Identity();
  F.topRightCorner<3, 3>() = dt_s * Matrix3::Identity();
  next.covariance = F * estimate.covariance * F.transpose();
  const double q = acceleration_density;
  for (int axis = 0; axis < 3; ++axis) {
    next.covariance(axis, axis) += q * dt_s * dt_s * dt_s / 3.0;
    next.covariance(axis, axis + 3) += q * dt_s * dt_s / 2.0;
    next.covariance(axis + 3, axis) += q * dt_s * dt_s / 2.0;
    next.covariance(axis + 3, axis + 3) += q * dt_s;
  }
  return next;
}

MotionEstimate covariance_intersection(std::span<const MotionEstimate> estimates) {
  ENSURE(!estimates.empty());
  if (estimates.size() == 1) return estimates.front();
  std::vector<Matrix6> informations;
  informations.reserve(estimates.size());
  for (const MotionEstimate& estimate : estimates) informations.push_back(inverse_of(estimate.covariance));
  std::vector<double> weights(estimates.size(), 1.0 / static_cast<double>(estimates.size()));
  Matrix6 P = Matrix6::Zero();
  for (int step = 0; step < kMaxSteps; ++step) {
    Matrix6 information = Matrix6::Zero();
    for (std::size_t i = 0; i < weights.size(); ++i) information += weights[i] * informations[i];
    P = inverse_of(information);
    // At the optimum no trace exceeds the number of states (equivalence theorem of Kiefer and Wolfowitz).
    double greatest = 0.0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const double gain = P.cwiseProduct(informations[i]).sum() / 6.0;
      greatest = std::max(greatest, gain);
      weights[i] *= gain;
    }
    if (greatest <= 1.0 + kAlmostBest) break;
  }
  // The last weights sum to 1 up to rounding, and P belongs to earlier weights, so P is computed again.
  Matrix6 information = Matrix6::Zero();
  Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
  double total = 0.0;
  for (const double weight : weights) total += weight;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    information += weights[i] / total * informations[i];
    sum += weights[i] / total * (informations[i] * estimates[i].mean);
  }
  MotionEstimate out;
  out.covariance = inverse_of(information);
  out.mean = out.covariance * sum;
  return out;
}

Disagreement disagreement(const MotionEstimate& a, const MotionEstimate& b) {
  const Matrix6 S = a.covariance + b.covariance;
  const Eigen::LLT<Matrix6> factor = S.llt();
  const Eigen::Matrix<double, 6, 1> between = a.mean - b.mean;
  Disagreement out;
  out.squared_sigmas = between.dot(factor.solve(between));
  double log_determinant = 0.0;
  for (int i = 0; i < 6; ++i) log_determinant += 2.0 * elementary::log(factor.matrixLLT()(i, i));
  out.unlikelihood = out.squared_sigmas + log_determinant;
  const Matrix3 place = S.topLeftCorner<3, 3>();
  const double greatest = Eigen::SelfAdjointEigenSolver<Matrix3>(place, Eigen::EigenvaluesOnly).eigenvalues()(2);
  out.position_sigma_m = std::sqrt(std::max(0.0, greatest));
  return out;
}

double joint_existence(std::span<const double> each, double prior, double common_clutter) {
  ENSURE(!each.empty() && prior > 0.0 && prior < 1.0 && common_clutter > 0.0, each.size(), prior, common_clutter);
  std::vector<double> sorted(each.begin(), each.end());
  std::sort(sorted.begin(), sorted.end(), std::greater<>());  // the result does not depend on the order of observers
  const auto odds = [](double p) { return std::min(p, kSurest) / (1.0 - std::min(p, kSurest)); };
  double together = odds(sorted.front());
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double evidence = odds(sorted[i]) / odds(prior);
    if (evidence <= 1.0) continue;  // no evidence against the target, which may be out of view
    together /= common_clutter + (1.0 - common_clutter) / evidence;
  }
  return together / (1.0 + together);
}

}  // namespace swiftlet
