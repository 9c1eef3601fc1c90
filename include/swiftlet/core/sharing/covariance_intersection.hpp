// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "swiftlet/core/frames.hpp"

/// What several observers know of one target, put together without knowing how their errors hang together.
namespace swiftlet {

/// Position and velocity [m, m/s] of a target, in any one frame.
struct MotionEstimate {
  Eigen::Matrix<double, 6, 1> mean = Eigen::Matrix<double, 6, 1>::Zero();
  Matrix6 covariance = Matrix6::Identity();

  Vector3 p_m() const { return mean.head<3>(); }
  Vector3 v_mps() const { return mean.tail<3>(); }
};

/// The estimate moved on in time by white acceleration of this spectral density [m^2/s^3].
/// @param dt_s  not negative
MotionEstimate predicted(const MotionEstimate& estimate, double dt_s, double acceleration_density);

/// Covariance intersection: the information is a convex sum of all informations, P^-1 = sum w_i P_i^-1, and the mean is
/// that of the same sum. It is consistent whenever all of them are, whatever the correlation of their errors (Julier
/// and Uhlmann, American Control Conference, 1997). The weights are those of the least determinant, which mixes no
/// meters with meters a second. To find them is the design of a D-optimal experiment. So they are found by its
/// multiplicative rule w_i <- w_i tr(P P_i^-1) / 6, which never gets worse (Yu, Annals of Statistics 38(3), 2010).
/// @param estimates  at least one; their covariances are positive definite
MotionEstimate covariance_intersection(std::span<const MotionEstimate> estimates);

/// Squared statistical distance of two estimates and how unlikely it is, as if their errors were independent.
struct Disagreement {
  double squared_sigmas = 0.0;    ///< six degrees of freedom
  double unlikelihood = 0.0;      ///< twice the negative logarithm of the likelihood, but for a constant
  double position_sigma_m = 0.0;  ///< of their distance, along its least certain axis
};
Disagreement disagreement(const MotionEstimate& a, const MotionEstimate& b);

/// Probability that a target exists which several observers tell, each with its own probability.
///
/// The surest of them is taken at its word. Another one multiplies the odds by 1 / (c + (1 - c) / L). L is its own
/// evidence: its odds over those that a target is there before anybody looks. c is the share of false tracks that all
/// observers have together, because the same leaf or bird is there for each of them. So a second observer makes a
/// target at most 1 / c times as likely. What was counted by one is not counted again by the next.
/// @param each           at least one, 0 to 1; their order does not matter
/// @param prior          probability that a target is where it is told before anybody looks
/// @param common_clutter c, above 0: 1 is the surest alone
double joint_existence(std::span<const double> each, double prior, double common_clutter);

}  // namespace swiftlet
