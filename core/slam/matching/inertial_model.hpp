// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/localization/dead_reckoning.hpp"

namespace swiftlet {

/// State of inertial navigation, its motion, and the motion of its errors.
struct InertialModel {
  /// First index of each part of the error state, and its dimension.
  enum Index : int { kP, kV = 3, kTheta = 6, kAccelBias = 9, kGyroBias = 12, kTilt = 15, kTimeOffset = 17, kStates };
  using Covariance = Eigen::Matrix<double, kStates, kStates>;
  using Error = Eigen::Matrix<double, kStates, 1>;

  struct State {
    NavState nav;
    Vector3 accel_bias_body_mps2 = Vector3::Zero();
    Vector3 gyro_bias_body_radps = Vector3::Zero();
    Eigen::Vector2d tilt_local =
        Eigen::Vector2d::Zero();  ///< horizontal components of the unit vector of gravity, local frame
    double time_offset_s = 0.0;   ///< stamp of the IMU minus stamp of the LiDAR at one instant

    Vector3 gravity_local_mps2() const;
    /// State after a small change in the filter's error coordinates.
    State changed_by(const Error& d) const;
  };

  /// State after dt under a body rate and a specific force, both corrected by their biases.
  static State advanced(const State& state, const Vector3& omega_body_radps, const Vector3& force_body_mps2,
                        double dt_s);
  /// Transition matrix of a small error over dt.
  static Covariance transition(const State& state, const Vector3& omega_body_radps, const Vector3& force_body_mps2,
                               double dt_s);
};

}  // namespace swiftlet
