// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Probability that a trivariate normal variable lies in an axis-aligned box [Vrba 2025, eq. 65].
///
/// Triangular factorization gives the innermost integral in closed form (a difference of normal distribution functions,
/// after A. Genz, J. Comput. Graph. Stat. 1, 1992); the two others are integrated adaptively. Absolute error below
/// 1e-7, also for degenerate covariances (a variance of zero is a point mass along that direction).
/// Any frame, the same for all arguments.
/// @param mean   [m]
/// @param Sigma  [m^2], positive semi-definite
double box_probability(const Vector3& mean, const Matrix3& Sigma, const Eigen::AlignedBox3d& box);

/// Probability that the true point lies in the voxel in which it was measured, eqs. (64) and (65). Voxels are aligned
/// with the world and have their corners at multiples of the edge.
double correct_voxel_probability(const Vector3& p_measured_world_m, const Matrix3& Sigma, double voxel_edge_m);

}  // namespace swiftlet
