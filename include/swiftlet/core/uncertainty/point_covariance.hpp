// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

/// Uncertainty of a point measured by a LiDAR with an uncertain pose [Vrba 2025, sec. IV-A].
namespace swiftlet {

using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Jacobian37 = Eigen::Matrix<double, 3, 7>;

/// Sigma_w of eq. (43) without correlations: noise of the range, of the sensor's position and of its attitude. The
/// defaults are eq. (66).
struct MeasurementNoise {
  double sigma_range_m = 0.03;
  Vector3 sigma_position_m = Vector3::Constant(0.05);
  Vector3 sigma_attitude_rad = Vector3::Constant(0.005);  ///< about x, y, z: alpha, beta, gamma of eq. (41)

  /// (7 x 7), order of eq. (42): range, position x y z, attitude alpha beta gamma.
  Matrix7 Sigma_w() const;
};

/// True point for a measurement and a given noise vector, eqs. (38)-(41) [m], frame of the pose.
/// @param direction_lidar  unit vector of the ray
/// @param range_m          measured range l_m
/// @param T_world_lidar    measured pose (R_m, t_m)
/// @param w                noise, order of eq. (42)
Vector3 true_point(const Vector3& direction_lidar, double range_m, const Pose& T_world_lidar,
                   const Eigen::Matrix<double, 7, 1>& w);

/// J of eq. (46): derivative of true_point() with respect to w at w = 0. Columns: R d; I; l R (e_x x d), l R (e_y x d),
/// l R (e_z x d).
Jacobian37 point_jacobian(const Vector3& direction_lidar, double range_m, const Matrix3& R_world_lidar);

/// Covariance of the true point in the world frame, J Sigma_w J^T of eq. (44) [m^2].
Matrix3 point_covariance(const Vector3& direction_lidar, double range_m, const Matrix3& R_world_lidar,
                         const Matrix7& Sigma_w);

}  // namespace swiftlet
