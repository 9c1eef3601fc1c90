// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/estimator.hpp"
#include "swiftlet/core/localization/imu_noise.hpp"

namespace swiftlet {

/// Inertial navigation aided by the available sensors: GNSS, altimeter, compass, velocity from odometry. With an
/// unknown start heading, GNSS is used only after a compass sample. With an unknown start position, the first fix after
/// that sets the position.
struct InsConfig : ModuleConfigOf<InsConfig>, ImuNoise {
  // Uncertainty of the start pose given by the operator.
  double start_position_sigma_m = 0.1;
  double start_velocity_sigma_mps = 0.1;
  double start_tilt_sigma_deg = 1.0;
  double start_yaw_sigma_deg = 3.0;
  // Sensors in use, and their processing.
  bool use_gnss = true;
  bool use_altimeter = true;
  bool use_compass = true;
  bool use_odometry = true;
  double odometry_velocity_sigma_mps = 0.1;  ///< [m/s] standard deviation of the odometry's velocity, per axis
  /// [m/sqrt(m)] random walk of the ground's height over the path; larger values trust the altimeter less over slopes
  double ground_walk_m_sqrt_m = 0.1;
  double position_sigma_max_m = 30.0;

  void visit(ConfigVisitor& v) override;
};

/// Error-state Kalman filter on (position, velocity, attitude, accelerometer bias, gyroscope bias, ground height).
///
/// J. Solà, "Quaternion kinematics for the error-state Kalman filter", arXiv 1711.02508, sec. 5-6, local attitude error
/// (R_true = R exp(theta)); covariance updates in Joseph form. The sixteenth state makes the altimeter, which measures
/// the height above the ground below, usable over uneven ground. Delayed measurements (by their stamps) are compared
/// with the state at their time, and correct the present one.
class InsFilter {
 public:
  /// [-] Dimension of the error state, in the order of Index.
  static constexpr int kStates = 16;
  using Covariance = Eigen::Matrix<double, kStates, kStates>;
  enum Index { kP = 0, kV = 3, kTheta = 6, kAccelBias = 9, kGyroBias = 12, kGround = 15 };

  InsFilter(const InsConfig& config, const Pose& T_local_body_start);

  /// Propagates the state by the time since the last sample.
  void predict(const ImuSample& sample);
  void update(const GnssSample& sample);
  void update(const AltimeterSample& sample);
  void update(const CompassSample& sample);
  void update(const OdometrySample& sample);

  /// State at the last IMU sample; the body rate is corrected by its estimated bias.
  const NavState& state() const { return nominal_; }
  const Vector3& accel_bias_mps2() const { return accel_bias_; }
  const Vector3& gyro_bias_radps() const { return gyro_bias_; }
  double ground_m() const { return ground_m_; }
  const Covariance& covariance() const { return P_; }
  bool is_sound() const;
  int num_rejected() const { return num_rejected_; }

 private:
  template <int M>
  void correct(const Eigen::Matrix<double, M, 1>& innovation, const Eigen::Matrix<double, M, kStates>& H,
               const Eigen::Matrix<double, M, M>& R, int source);
  void inject(const Eigen::Matrix<double, kStates, 1>& dx);
  const NavState& at(TimeNs t) const;
  void remember();

  /// [-] Stored states, at the last IMU samples. Smaller values use delayed measurements at a later state.
  static constexpr int kHistory = 128;
  InsConfig config_;
  NavState nominal_;
  Vector3 accel_bias_ = Vector3::Zero(), gyro_bias_ = Vector3::Zero();
  double ground_m_ = 0.0;
  bool ground_known_ = false;
  Covariance P_ = Covariance::Zero();
  std::array<NavState, kHistory> history_;  // states at the last IMU samples, for delayed measurements
  int newest_ = -1, count_ = 0;
  std::array<int, 5> rejected_in_a_row_{};  // rejections of each kind of measurement
  int num_rejected_ = 0;
};

std::unique_ptr<StateEstimator> make_ins_estimator(const ModuleConfig& config, const AgentSetup& setup);

}  // namespace swiftlet
