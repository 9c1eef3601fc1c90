// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "core/slam/matching/inertial_model.hpp"
#include "swiftlet/core/slam/local_slam_config.hpp"

namespace swiftlet {

/// Constraint of a scan on the pose: the cost 0.5 d^T information d + gradient^T d of a small change d of the pose. d
/// is the change of position in the local frame [m], then a rotation vector in body axes [rad].
struct PoseEvidence {
  Matrix6 information = Matrix6::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
};

/// Error-state Kalman filter on position, velocity, attitude, biases of accelerometer and gyroscope, the direction of
/// gravity in the local frame, and the time offset between LiDAR and IMU.
///
/// The first scan defines the local frame: the start pose is exact by definition, and the direction of gravity in that
/// frame is uncertain instead. So an error of the given start tilt bends neither the map nor the biases. Attitude
/// errors are local (R_true = R exp(theta)) as in J. Solà, arXiv 1711.02508.
///
/// Times are those of the IMU. A scan measures the pose time_offset_s after its stamp: its points move with the
/// vehicle, so an error of the offset acts like the motion of the vehicle in that time [Li and Mourikis 2014].
///
/// Without samples the filter assumes constant velocity and body rate, with accelerations as white noise. The state of
/// the gyroscope's bias then holds the negative body rate.
class InertialFilter : public InertialModel {
 public:
  InertialFilter(const InertialConfig& config, const Pose& T_local_body_start);

  /// Propagates the state by the time since the last sample. The first sample starts at its own time.
  void predict(const ImuSample& sample);
  /// Propagates the state to t: by the last sample, or with constant velocity if that is older than 0.1 s.
  void predict_to(TimeNs t);
  /// Starts at t without a sample.
  void begin_at(TimeNs t);
  bool has_begun() const { return started_; }
  /// Initializes biases, gravity and start velocity from another filter. Their standard deviations are twice those of
  /// the other filter, because the same measurements are applied again, but at most those of the own start.
  void begin_with(const InertialFilter& learned, const Vector3& v_start_local_mps);

  /// Covariance of the rotation vector between the local frame and a level one.
  Matrix3 level_covariance_rad2() const;
  /// Rotates the local frame so that gravity points down its z axis. Returns the rotation.
  Matrix3 level();
  /// Velocity (local frame) and body rate of the vehicle during the next scan: change of the measured pose per second
  /// of time offset.
  void set_scan_motion(const Eigen::Matrix<double, 6, 1>& twist) { twist_ = twist; }
  /// Time from the middle of a scan to its end, where scans are undistorted by the predicted velocity and body rate:
  /// such a scan measures the pose of its middle, which the prediction extrapolates to its end. 0 where the IMU
  /// undistorts.
  void set_scan_lag(double lag_s) { lag_s_ = lag_s; }
  /// Factor of the variances of the IMU's noise. Larger values weigh scans more.
  void set_noise_factor(double factor) { noise_factor_ = factor; }

  /// Makes the present pose of scans exact by definition: the map begins here.
  void anchor_pose();

  /// Iterated update by a scan: `evidence_at(pose)` is relinearized at each iterate (Bell and Cathey 1993). The pose is
  /// that of the scan's points, which were undistorted with the prior's time offset. Returns the number of iterations.
  template <class EvidenceAt>
  int update(EvidenceAt&& evidence_at, int most_iterations);

  /// Update by a pose whose position and attitude have independent errors of these standard deviations per axis.
  void measure(const Pose& T_local_body, double sigma_m, double sigma_rad);
  /// Moves the state as measure() does, without a change of the covariance.
  void move_towards(const Pose& T_local_body, double sigma_m, double sigma_rad);

  /// A pose estimated outside of the filter from the scan and the prediction, with weights of its own.
  struct WeighedPose {
    Eigen::Matrix<double, 6, 1> moved;  ///< change from the prediction, in the coordinates of PoseEvidence
    Eigen::Matrix<double, 6, 1>
        contribution;  ///< contribution of the scan: slope times the prediction's error, plus noise
    Matrix6 slope;
    Matrix6 scatter;  ///< covariance of the noise
    Matrix6 gain;     ///< the pose changes by gain times the scan's contribution
  };
  /// Adopts the pose. All other states are corrected with the gain of least variance. The covariance is valid for any
  /// gain (Joseph's form).
  void take(const WeighedPose& pose);

  /// State at the last sample; the body rate is corrected by its estimated bias.
  const State& state() const { return state_; }
  Pose T_local_body() const { return make_pose(state_.nav.p_m, state_.nav.q); }
  const Covariance& covariance() const { return P_; }
  /// Covariance of position (local frame) and attitude (body axes) at the time of the LiDAR.
  Matrix6 pose_covariance() const;
  /// Covariance of the pose dt_s after the state, predicted with constant velocity and body rate.
  Matrix6 pose_covariance_after(double dt_s) const;
  /// Square of the last scan's innovation, normalized by its covariance. Expected: the number of directions that the
  /// scan constrains.
  double innovation_sq() const { return innovation_sq_; }
  double time_offset_sigma_s() const { return std::sqrt(P_(kTimeOffset, kTimeOffset)); }
  bool is_sound() const;
  /// True while no samples arrive.
  bool is_coasting() const { return coasting_; }

 private:
  using PoseColumns = Eigen::Matrix<double, kStates, 6>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  void step(const Vector3& omega_body_radps, const Vector3& force_body_mps2, double dt_s);
  void coast(double dt_s);
  void set_gyro_bias(const Vector3& bias_body_radps, const Matrix3& covariance);
  /// Change of the measured pose by an error of the state.
  Vector6 pose_part(const Error& d) const;
  PoseColumns pose_columns() const;
  Pose measured_pose(const Error& at) const;
  /// Most likely error, given the prior and the evidence at an iterate with offset `at` from the prior.
  Error most_likely(const PoseEvidence& evidence, const Error& at) const;
  void settle(const PoseEvidence& evidence, const Error& at);
  void settle(const Covariance& posterior);

  InertialConfig config_;
  State state_;
  Covariance P_ = Covariance::Zero();
  ImuSample last_;
  bool started_ = false, has_sample_ = false;
  bool coasting_ = false;  // without samples: the bias of the gyroscope is set aside
  Vector3 gyro_bias_aside_radps_ = Vector3::Zero();
  Matrix3 gyro_bias_aside_covariance_ = Matrix3::Zero();
  double lag_s_ = 0.0;               // from the pose that scans measure to the state
  Vector6 twist_ = Vector6::Zero();  // motion during the scan
  double noise_factor_ = 1.0;
  double innovation_sq_ = 0.0;
};

template <class EvidenceAt>
int InertialFilter::update(EvidenceAt&& evidence_at, int most_iterations) {
  // Step below which the iterated update has converged. Smaller values cost iterations.
  constexpr double kStill_m = 2e-4, kStill_rad = 2e-5;
  const State prior = state_;
  Error at = Error::Zero();
  PoseEvidence evidence;
  for (int i = 0;; ++i) {
    evidence = evidence_at(measured_pose(at));
    if (i == most_iterations) {
      settle(evidence, at);
      return i;
    }
    const Error next = most_likely(evidence, at);
    if (!next.allFinite()) {
      state_ = prior;
      return i;
    }
    const Vector6 moved = pose_part(next - at);
    const bool still = moved.head<3>().norm() < kStill_m && moved.tail<3>().norm() < kStill_rad;
    at = next;
    state_ = prior.changed_by(at);
    if (still) {
      settle(evidence, at);
      return i + 1;
    }
  }
}

}  // namespace swiftlet
