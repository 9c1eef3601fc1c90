// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/slam/local_slam_config.hpp"

namespace swiftlet {

/// Constraint of a scan on the pose: the cost 0.5 d^T information d + gradient^T d of a small change d of it, with d
/// the change of position in the local frame [m], then a rotation vector in body axes [rad].
struct PoseEvidence {
  Matrix6 information = Matrix6::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
};

/// Error-state Kalman filter on position, velocity, attitude, biases of accelerometer and gyroscope, and the direction
/// of gravity in the local frame.
///
/// The first scan defines the local frame: the start pose is exact by definition, and the direction of gravity in that
/// frame is uncertain instead. So an error of the given start tilt bends neither the map nor the biases. Attitude
/// errors are local (R_true = R exp(theta)) as in J. Solà, arXiv 1711.02508.
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
        Eigen::Vector2d::Zero();  ///< horizontal components of the unit vector of gravity, local frame

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

  InertialFilter(const InertialConfig& config, const Pose& T_local_body_start);

  /// Propagates the state by the time since the last sample. The first sample starts at its own time.
  void predict(const ImuSample& sample);
  /// Propagates the state to t with the last sample's rates.
  void predict_to(TimeNs t);
  /// Initializes biases, gravity and start velocity from another filter, with twice its standard deviations, because
  /// the same measurements are applied again.
  void begin_with(const InertialFilter& learned, const Vector3& v_start_local_mps);

  /// Makes the present pose exact by definition: the map begins here.
  void anchor_pose();

  /// Iterated update by a scan: `evidence_at(pose)` is relinearized at each iterate (Bell and Cathey 1993). Returns the
  /// number of iterations.
  template <class EvidenceAt>
  int update(EvidenceAt&& evidence_at, int most_iterations);

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
  /// Covariance of position (local frame) and attitude (body axes).
  Matrix6 pose_covariance() const;
  bool is_sound() const;

 private:
  using PoseColumns = Eigen::Matrix<double, kStates, 6>;
  void step(const Vector3& omega_body_radps, const Vector3& force_body_mps2, double dt_s);
  PoseColumns pose_columns() const;
  /// Most likely error, given the prior and the evidence at an iterate with offset `at` from the prior.
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
