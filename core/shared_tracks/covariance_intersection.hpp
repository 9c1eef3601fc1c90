// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "swiftlet/core/base/frames.hpp"

/// Fusion of estimates of one target by several observers with unknown correlation of their errors.
namespace swiftlet {

/// Position and velocity [m, m/s] of a target, in any one frame.
struct MotionEstimate {
  Eigen::Matrix<double, 6, 1> mean = Eigen::Matrix<double, 6, 1>::Zero();
  Matrix6 covariance = Matrix6::Identity();

  Vector3 p_m() const { return mean.head<3>(); }
  Vector3 v_mps() const { return mean.tail<3>(); }
};

/// Predicts the estimate with white acceleration noise of this spectral density [m^2/s^3].
/// @param dt_s  not negative
MotionEstimate predicted(const MotionEstimate& estimate, double dt_s, double acceleration_density);

/// Covariance intersection: the information is a convex combination of all informations, P^-1 = sum w_i P_i^-1, and the
/// mean follows from the same sum. The fused estimate is consistent if all estimates are, for any correlation of their
/// errors (Julier and Uhlmann, American Control Conference, 1997). The weights minimize the determinant, which does not
/// mix meters with meters per second. They are a D-optimal design, found by the multiplicative rule w_i <- w_i tr(P
/// P_i^-1) / 6, which improves monotonically (Yu, Annals of Statistics 38(3), 2010).
/// @param estimates  at least one; their covariances are positive definite
MotionEstimate covariance_intersection(std::span<const MotionEstimate> estimates);

/// Squared Mahalanobis distance of two estimates and its likelihood, assuming independent errors.
struct Disagreement {
  double squared_sigmas = 0.0;    ///< six degrees of freedom
  double unlikelihood = 0.0;      ///< twice the negative log-likelihood, up to a constant
  double position_sigma_m = 0.0;  ///< standard deviation of the distance, along its least certain axis
};
Disagreement disagreement(const MotionEstimate& a, const MotionEstimate& b);

/// Probability that a target exists, from the probabilities reported by several observers.
///
/// The highest probability is the basis. Each other observer multiplies the odds by 1 / (c + (1 - c) / L). L is its
/// evidence: its odds divided by the prior odds. c is the share of false tracks that all observers have in common,
/// for example by the same leaf or bird. So a second observer increases the odds by at most 1 / c.
/// Common evidence is not counted twice.
/// @param each           at least one, 0 to 1; their order does not matter
/// @param prior          prior probability of a target at a reported position
/// @param common_clutter c, above 0; 1: only the highest probability counts
double joint_existence(std::span<const double> each, double prior, double common_clutter);

}  // namespace swiftlet
