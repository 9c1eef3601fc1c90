// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/uncertainty/point_covariance.hpp"

namespace swiftlet {

Matrix7 MeasurementNoise::Sigma_w() const {
  Eigen::Matrix<double, 7, 1> sigma;
  sigma << sigma_range_m, sigma_position_m, sigma_attitude_rad;
  return sigma.cwiseAbs2().asDiagonal();
}

Vector3 true_point(const Vector3& direction_lidar, double range_m, const Pose& T_world_lidar,
                   const Eigen::Matrix<double, 7, 1>& w) {
  using Eigen::AngleAxisd;
  // eq. (41): R_gt = R_m R_z(gamma) R_y(beta) R_x(alpha)
  const Matrix3 R_noise =
      (AngleAxisd(w[6], Vector3::UnitZ()) * AngleAxisd(w[5], Vector3::UnitY()) * AngleAxisd(w[4], Vector3::UnitX()))
          .toRotationMatrix();
  return (range_m + w[0]) * (T_world_lidar.linear() * R_noise * direction_lidar) + T_world_lidar.translation() +
         w.segment<3>(1);
}

Jacobian37 point_jacobian(const Vector3& direction_lidar, double range_m, const Matrix3& R_world_lidar) {
  Jacobian37 J;
  J.col(0) = R_world_lidar * direction_lidar;
  J.block<3, 3>(0, 1).setIdentity();
  for (int axis = 0; axis < 3; ++axis) {
    // The derivative of a rotation about an axis at zero is the cross product with that axis, eq. (45).
    J.col(4 + axis) = range_m * (R_world_lidar * Vector3::Unit(axis).cross(direction_lidar));
  }
  return J;
}

Matrix3 point_covariance(const Vector3& direction_lidar, double range_m, const Matrix3& R_world_lidar,
                         const Matrix7& Sigma_w) {
  const Jacobian37 J = point_jacobian(direction_lidar, range_m, R_world_lidar);
  return J * Sigma_w * J.transpose();
}

}  // namespace swiftlet
