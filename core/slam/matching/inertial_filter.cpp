// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/inertial_filter.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/ordered_product.hpp"

namespace swiftlet {
namespace {

constexpr double kLongestStep_s = 0.1;  // longest gap between IMU samples that one sample bridges

// factor of the variances (twice the standard deviations): the same scans are used again
constexpr double kTwice = 4.0;

double squared(double x) { return x * x; }

}  // namespace

Vector3 InertialFilter::State::gravity_local_mps2() const {
  return kStandardGravity_mps2 * Vector3(tilt_local.x(), tilt_local.y(), -std::sqrt(1.0 - tilt_local.squaredNorm()));
}

InertialFilter::State InertialFilter::State::changed_by(const Error& d) const {
  State out = *this;
  out.nav.p_m += d.segment<3>(kP);
  out.nav.v_mps += d.segment<3>(kV);
  out.nav.q = (nav.q * rotation_by(d.segment<3>(kTheta))).normalized();
  out.nav.omega_body_radps -= d.segment<3>(kGyroBias);
  out.accel_bias_body_mps2 += d.segment<3>(kAccelBias);
  out.gyro_bias_body_radps += d.segment<3>(kGyroBias);
  out.tilt_local += d.segment<2>(kTilt);
  if (out.tilt_local.squaredNorm() > 0.9) out.tilt_local *= std::sqrt(0.9) / out.tilt_local.norm();
  return out;
}

InertialFilter::InertialFilter(const InertialConfig& config, const Pose& T_local_body_start) : config_(config) {
  state_.nav.p_m = T_local_body_start.translation();
  state_.nav.q = Eigen::Quaterniond(T_local_body_start.linear()).normalized();
  P_.diagonal().segment<3>(kV).setConstant(squared(config.start_velocity_sigma_mps));
  P_.diagonal().segment<3>(kAccelBias).setConstant(squared(config.start_accel_bias_sigma_mps2));
  P_.diagonal().segment<3>(kGyroBias).setConstant(squared(config.start_gyro_bias_sigma_radps));
  P_.diagonal().segment<2>(kTilt).setConstant(squared(config.start_tilt_sigma_deg * kRadPerDeg));
}

bool InertialFilter::is_sound() const {
  return state_.nav.all_finite() && state_.accel_bias_body_mps2.allFinite() &&
         state_.gyro_bias_body_radps.allFinite() && P_.allFinite() && P_.diagonal().minCoeff() >= 0.0;
}

void InertialFilter::predict(const ImuSample& sample) {
  if (!sample.omega_body_radps.allFinite() || !sample.specific_force_body_mps2.allFinite()) return;
  if (started_ && sample.t <= state_.nav.t) return;
  last_ = sample;
  if (!started_) state_.nav.t = sample.t;
  started_ = true;
  predict_to(sample.t);
}

void InertialFilter::predict_to(TimeNs t) {
  const double dt_s = to_seconds(t - state_.nav.t);
  if (dt_s <= 0.0 || !started_) return;
  step(last_.omega_body_radps - state_.gyro_bias_body_radps,
       last_.specific_force_body_mps2 - state_.accel_bias_body_mps2, dt_s);
  state_.nav.t = t;
}

void InertialFilter::begin_with(const InertialFilter& learned, const Vector3& v_start_local_mps) {
  state_.nav.v_mps = v_start_local_mps;
  state_.accel_bias_body_mps2 = learned.state_.accel_bias_body_mps2;
  state_.gyro_bias_body_radps = learned.state_.gyro_bias_body_radps;
  state_.tilt_local = learned.state_.tilt_local;
  constexpr int kNum = kStates - kAccelBias;
  P_.block<3, 3>(kV, kV) = kTwice * learned.P_.block<3, 3>(kV, kV);
  P_.bottomRightCorner<kNum, kNum>() = kTwice * learned.P_.bottomRightCorner<kNum, kNum>();
}

InertialFilter::State InertialFilter::advanced(const State& state, const Vector3& omega_body_radps,
                                               const Vector3& force_body_mps2, double dt_s) {
  State out = state;
  const Eigen::Quaterniond half = rotation_by(0.5 * dt_s * omega_body_radps);
  const Eigen::Quaterniond q_middle = state.nav.q * half;
  const Vector3 a = q_middle * force_body_mps2 + state.gravity_local_mps2();
  out.nav.p_m += dt_s * (state.nav.v_mps + 0.5 * dt_s * a);
  out.nav.v_mps += dt_s * a;
  out.nav.q = (q_middle * half).normalized();
  out.nav.omega_body_radps = omega_body_radps;
  return out;
}

/// Sola, eqs. 270 and 271: first order in dt, second where position depends on acceleration.
InertialFilter::Covariance InertialFilter::transition(const State& state, const Vector3& omega_body_radps,
                                                      const Vector3& force_body_mps2, double dt_s) {
  const Matrix3 R = (state.nav.q * rotation_by(0.5 * dt_s * omega_body_radps)).toRotationMatrix();
  const Matrix3 a_by_theta = -R * skew_of(force_body_mps2);
  Eigen::Matrix<double, 3, 2> a_by_tilt = Eigen::Matrix<double, 3, 2>::Zero();
  a_by_tilt.topRows<2>().diagonal().setConstant(kStandardGravity_mps2);
  a_by_tilt.row(2) =
      kStandardGravity_mps2 / std::sqrt(1.0 - state.tilt_local.squaredNorm()) * state.tilt_local.transpose();
  Covariance F = Covariance::Identity();
  F.block<3, 3>(kP, kV) = Matrix3::Identity() * dt_s;
  F.block<3, 3>(kP, kTheta) = 0.5 * dt_s * dt_s * a_by_theta;
  F.block<3, 3>(kP, kAccelBias) = -0.5 * dt_s * dt_s * R;
  F.block<3, 2>(kP, kTilt) = 0.5 * dt_s * dt_s * a_by_tilt;
  F.block<3, 3>(kV, kTheta) = dt_s * a_by_theta;
  F.block<3, 3>(kV, kAccelBias) = -dt_s * R;
  F.block<3, 2>(kV, kTilt) = dt_s * a_by_tilt;
  F.block<3, 3>(kTheta, kTheta) = rotation_by(-dt_s * omega_body_radps).toRotationMatrix();
  F.block<3, 3>(kTheta, kGyroBias) = -dt_s * Matrix3::Identity();
  return F;
}

void InertialFilter::anchor_pose() {
  for (const int first : {static_cast<int>(kP), static_cast<int>(kTheta)}) {
    P_.middleRows<3>(first).setZero();
    P_.middleCols<3>(first).setZero();
  }
}

void InertialFilter::step(const Vector3& omega_body_radps, const Vector3& force_body_mps2, double dt) {
  const Covariance F = transition(state_, omega_body_radps, force_body_mps2, dt);
  state_ = advanced(state_, omega_body_radps, force_body_mps2, dt);
  P_ = propagated(F, P_);

  const double accel_q = squared(config_.accel_noise_mps2_sqrt_hz) * dt;
  P_.block<3, 3>(kP, kP).diagonal().array() += accel_q * dt * dt / 4.0;
  P_.block<3, 3>(kP, kV).diagonal().array() += accel_q * dt / 2.0;
  P_.block<3, 3>(kV, kP).diagonal().array() += accel_q * dt / 2.0;
  P_.block<3, 3>(kV, kV).diagonal().array() += accel_q;
  P_.block<3, 3>(kTheta, kTheta).diagonal().array() += squared(config_.gyro_noise_radps_sqrt_hz) * dt;
  P_.block<3, 3>(kAccelBias, kAccelBias).diagonal().array() += squared(config_.accel_walk_mps3_sqrt_hz) * dt;
  P_.block<3, 3>(kGyroBias, kGyroBias).diagonal().array() += squared(config_.gyro_walk_radps2_sqrt_hz) * dt;
  if (dt > kLongestStep_s) {  // the motion in the gap is unknown
    P_.block<3, 3>(kP, kP).diagonal().array() += squared(dt * dt);
    P_.block<3, 3>(kV, kV).diagonal().array() += squared(2.0 * dt);
    P_.block<3, 3>(kTheta, kTheta).diagonal().array() += squared(dt);
  }
}

Matrix6 InertialFilter::pose_covariance() const {
  const PoseColumns columns = pose_columns();
  Matrix6 out;
  out.topRows<3>() = columns.middleRows<3>(kP);
  out.bottomRows<3>() = columns.middleRows<3>(kTheta);
  return out;
}

InertialFilter::PoseColumns InertialFilter::pose_columns() const {
  PoseColumns columns;
  columns.leftCols<3>() = P_.middleCols<3>(kP);
  columns.rightCols<3>() = P_.middleCols<3>(kTheta);
  return columns;
}

/// With the prior N(0, P), the pose's rows of an error d called H d and the evidence (Omega, b) at H d = H at:
/// d = P H^T (I + Omega H P H^T)^-1 (Omega H at - b). No inverse of P is needed, which may be singular.
InertialFilter::Error InertialFilter::most_likely(const PoseEvidence& evidence, const Error& at) const {
  Eigen::Matrix<double, 6, 1> pose_at;
  pose_at << at.segment<3>(kP), at.segment<3>(kTheta);
  const Matrix6 A = Matrix6::Identity() + evidence.information * pose_covariance();
  const Eigen::Matrix<double, 6, 1> y = A.partialPivLu().solve(evidence.information * pose_at - evidence.gradient);
  return pose_columns() * y;
}

void InertialFilter::settle(const PoseEvidence& evidence) {
  const PoseColumns columns = pose_columns();
  const Matrix6 A = Matrix6::Identity() + evidence.information * pose_covariance();
  const Matrix6 M = A.partialPivLu().solve(evidence.information);
  settle(P_ - columns * M * columns.transpose());
}

void InertialFilter::settle(const Covariance& posterior) {
  P_ = 0.5 * (posterior + posterior.transpose());
  // Keeps variances positive despite rounding.
  for (int i = 0; i < kStates; ++i) P_(i, i) = std::max(P_(i, i), 1e-18);
}

void InertialFilter::take(const WeighedPose& pose) {
  const PoseColumns cross_covariance = pose_columns() * pose.slope;  // covariance of all states with the measured pose
  const Matrix6 spread = pose.slope * pose_covariance() * pose.slope + pose.scatter;
  PoseColumns gain = spread.partialPivLu().solve(cross_covariance.transpose()).transpose();
  gain.middleRows<3>(kP) = pose.gain.topRows<3>();
  gain.middleRows<3>(kTheta) = pose.gain.bottomRows<3>();
  Error change = gain * pose.contribution;
  change.segment<3>(kP) = pose.moved.head<3>();
  change.segment<3>(kTheta) = pose.moved.tail<3>();
  if (!change.allFinite() || !gain.allFinite()) return;
  state_ = state_.changed_by(change);
  Covariance left = Covariance::Identity();
  left.middleCols<3>(kP) -= gain * pose.slope.leftCols<3>();
  left.middleCols<3>(kTheta) -= gain * pose.slope.rightCols<3>();
  settle(left * P_ * left.transpose() + gain * pose.scatter * gain.transpose());
}

void InertialConfig::visit(ConfigVisitor& v) {
  const Range positive = Range::positive();
  visit_noise(v);
  v.field("start_velocity_sigma_mps", start_velocity_sigma_mps,
          "[m/s] standard deviation of the velocity at the start; at least the speed of a vehicle turned on in flight",
          positive);
  v.field("start_tilt_sigma_deg", start_tilt_sigma_deg, "[deg] standard deviation of the start pose's tilt", positive);
}

}  // namespace swiftlet
