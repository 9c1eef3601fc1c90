// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/imu_noise.hpp"

namespace swiftlet {

/// Noise of the IMU and what is known at the start.
struct InertialConfig : ImuNoise {
  double start_velocity_sigma_mps = 0.1;
  double start_tilt_sigma_deg = 0.5;

  void visit(ConfigVisitor& v);
};

/// What a scan says of the pose: the cost 0.5 d^T information d + gradient^T d of a small change d of it. The change is
/// one of position in the local frame [m], then a rotation vector in body axes [rad].
struct PoseEvidence {
  Matrix6 information = Matrix6::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
};

/// Error-state Kalman filter on position, velocity, attitude, biases of accelerometer and gyroscope, and the direction
/// of gravity in the local frame.
///
/// The local frame is what the first scan made of it: the pose at the start is exact by definition. What is uncertain
/// is how that frame stands against the vertical. So a tilt of the start that was told wrongly bends neither the map
/// nor the biases. Errors of attitude are local (R_true = R exp(theta)) as in J. Solà, arXiv 1711.02508.
class InertialFilter {
 public:
  static constexpr int kStates = 17;
  using Covariance = Eigen::Matrix<double, kStates, kStates>;
  using Error = Eigen::Matrix<double, kStates, 1>;
  enum Index { kP = 0, kV = 3, kTheta = 6, kAccelBias = 9, kGyroBias = 12, kTilt = 15 };

  struct State {
    NavState nav;
    Vector3 accel_bias_body_mps2 = Vector3::Zero();
    Vector3 gyro_bias_body_radps = Vector3::Zero();
    Eigen::Vector2d tilt_local =
        Eigen::Vector2d::Zero();  ///< horizontal parts of the unit vector of gravity, local frame

    Vector3 gravity_local_mps2() const;
    /// A small change, as the filter counts errors.
    State changed_by(const Error& d) const;
  };

  /// The state after dt under a body rate and a specific force, both free of bias.
  static State advanced(const State& state, const Vector3& omega_body_radps, const Vector3& force_body_mps2,
                        double dt_s);
  /// How a small error of the state before grows over dt.
  static Covariance transition(const State& state, const Vector3& omega_body_radps, const Vector3& force_body_mps2,
                               double dt_s);

  InertialFilter(const InertialConfig& config, const Pose& T_local_body_start);

  /// Forward by the time since the last sample. The first sample begins at its own time.
  void predict(const ImuSample& sample);
  /// Forward to t under the last sample's rates.
  void predict_to(TimeNs t);
  /// What another filter learned of biases and gravity, and of the velocity at the start. With twice its doubt, because
  /// the same measurements come again.
  void begin_with(const InertialFilter& learned, const Vector3& v_start_local_mps);

  /// The map begins here: what the pose is in the local frame is right by definition.
  void anchor_pose();

  /// Iterated update by a scan: `evidence_at(pose)` is linearized anew at each iterate (Bell and Cathey 1993). Returns
  /// how many iterates were made.
  template <class EvidenceAt>
  int update(EvidenceAt&& evidence_at, int most_iterations);

  /// A pose that others found by weights of their own. They weighed what a scan tells against the prediction.
  struct WeighedPose {
    Eigen::Matrix<double, 6, 1> moved;  ///< from the prediction to it, as PoseEvidence counts
    Eigen::Matrix<double, 6, 1> told;   ///< by the scan: slope times the prediction's error, and noise
    Matrix6 slope;
    Matrix6 scatter;  ///< covariance of the noise
    Matrix6 gain;     ///< the pose moves by gain times what was told
  };
  /// The pose becomes theirs. All other states take the share that leaves them the least variance. The covariance is
  /// true for any gain (Joseph's form).
  void take(const WeighedPose& pose);

  /// At the last sample; the body rate is free of its estimated bias.
  const State& state() const { return state_; }
  Pose T_local_body() const { return make_pose(state_.nav.p_m, state_.nav.q); }
  const Covariance& covariance() const { return P_; }
  /// Of position (local frame) and attitude (body axes).
  Matrix6 pose_covariance() const;
  bool is_sound() const;

 private:
  using PoseColumns = Eigen::Matrix<double, kStates, 6>;
  void step(const Vector3& omega_body_radps, const Vector3& force_body_mps2, double dt_s);
  PoseColumns pose_columns() const;
  /// The most likely error, given the prior and the evidence at an iterate that lies by `at` off the prior.
  Error most_likely(const PoseEvidence& evidence, const Error& at) const;
  void settle(const PoseEvidence& evidence);
  void settle(const Covariance& posterior);

  InertialConfig config_;
  State state_;
  Covariance P_ = Covariance::Zero();
  ImuSample last_;
  bool started_ = false;
};

template <class EvidenceAt>
int InertialFilter::update(EvidenceAt&& evidence_at, int most_iterations) {
  constexpr double kStill_m = 2e-4, kStill_rad = 2e-5;
  const State prior = state_;
  Error at = Error::Zero();
  PoseEvidence evidence;
  for (int i = 0;; ++i) {
    evidence = evidence_at(T_local_body());
    if (i == most_iterations) {
      settle(evidence);
      return i;
    }
    const Error next = most_likely(evidence, at);
    if (!next.allFinite()) {
      state_ = prior;
      return i;
    }
    const bool still =
        (next - at).segment<3>(kP).norm() < kStill_m && (next - at).segment<3>(kTheta).norm() < kStill_rad;
    at = next;
    state_ = prior.changed_by(at);
    if (still) {
      settle(evidence);
      return i + 1;
    }
  }
}

}  // namespace swiftlet
