// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/inertial_filter.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/slam/symmetric_eigen.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/math/ordered_product.hpp"

namespace swiftlet {
namespace {

// [s] Longest gap between IMU samples that the earlier sample covers. Larger values continue old accelerations.
constexpr double kLongestStep_s = 0.1;
// White noise of the accelerations while no samples arrive: within 0.1 s the speed changes by 0.6 m/s and the body rate
// by 3 rad/s (one sigma), as of a multirotor that begins to brake. Smaller values make the estimate smoother and late
// in turns.
constexpr double kCoastAccel_mps2_sqrt_hz = 2.0, kCoastAngularAccel_radps2_sqrt_hz = 10.0;
// [rad/s] Standard deviation of the body rate at a start without IMU. Smaller values are late when the vehicle turns.
constexpr double kStartRate_radps = 0.5;
// Random walk of the time offset: clocks that drift by some 20 ppm against each other. Larger values make its estimate
// noisier.
constexpr double kTimeOffsetWalk_s_sqrt_hz = 5e-5;
// [-] Factor of the variances (twice the standard deviations): the same scans are used again. Smaller values count
// the repeated scans as further ones.
constexpr double kTwice = 4.0;

double squared(double x) { return x * x; }

/// Largest covariance that exceeds in no direction that of independent errors with these standard deviations.
template <int N>
Eigen::Matrix<double, N, N> bounded(const Eigen::Matrix<double, N, N>& covariance,
                                    const Eigen::Matrix<double, N, 1>& sigma) {
  const auto inverse = [](double s) { return s > 0.0 ? 1.0 / s : 0.0; };
  const Eigen::Matrix<double, N, 1> scale = sigma.unaryExpr(inverse);
  const SymmetricEigen<N> eigen =
      symmetric_eigen<N>(Eigen::Matrix<double, N, N>(scale.asDiagonal() * covariance * scale.asDiagonal()));
  const Eigen::Matrix<double, N, N> axes = sigma.asDiagonal() * eigen.vectors;
  return axes * eigen.values.cwiseMin(1.0).asDiagonal() * axes.transpose();
}

}  // namespace

InertialFilter::InertialFilter(const InertialConfig& config, const Pose& T_local_body_start) : config_(config) {
  state_.nav.p_m = T_local_body_start.translation();
  state_.nav.q = Eigen::Quaterniond(T_local_body_start.linear()).normalized();
  P_.diagonal().segment<3>(kV).setConstant(squared(config.start_velocity_sigma_mps));
  P_.diagonal().segment<3>(kAccelBias).setConstant(squared(config.start_accel_bias_sigma_mps2));
  P_.diagonal().segment<3>(kGyroBias).setConstant(squared(config.start_gyro_bias_sigma_radps));
  P_.diagonal().segment<2>(kTilt).setConstant(squared(config.start_tilt_sigma_deg * kRadPerDeg));
  state_.time_offset_s = config.time_offset_s;
  P_(kTimeOffset, kTimeOffset) = squared(config.time_offset_sigma_s);
}

bool InertialFilter::is_sound() const {
  return state_.nav.all_finite() && state_.accel_bias_body_mps2.allFinite() &&
         state_.gyro_bias_body_radps.allFinite() && P_.allFinite() && P_.diagonal().minCoeff() >= 0.0;
}

void InertialFilter::predict(const ImuSample& sample) {
  if (!sample.omega_body_radps.allFinite() || !sample.specific_force_body_mps2.allFinite()) return;
  const bool late = started_ && sample.t <= state_.nav.t;
  if (late && (!has_sample_ || sample.t <= last_.t)) return;
  last_ = sample;
  has_sample_ = true;
  if (coasting_) set_gyro_bias(gyro_bias_aside_radps_, gyro_bias_aside_covariance_);
  coasting_ = false;
  if (!started_) begin_at(sample.t);
  predict_to(sample.t);
}

void InertialFilter::begin_at(TimeNs t) {
  state_.nav.t = t;
  started_ = true;
}

void InertialFilter::predict_to(TimeNs t) {
  const double dt_s = to_seconds(t - state_.nav.t);
  if (dt_s <= 0.0 || !started_) return;
  if (has_sample_ && to_seconds(t - last_.t) <= kLongestStep_s) {
    step(last_.omega_body_radps - state_.gyro_bias_body_radps,
         last_.specific_force_body_mps2 - state_.accel_bias_body_mps2, dt_s);
  } else {
    coast(dt_s);
  }
  P_(kTimeOffset, kTimeOffset) += config_.time_offset_sigma_s > 0.0 ? squared(kTimeOffsetWalk_s_sqrt_hz) * dt_s : 0.0;
  state_.nav.t = t;
}

/// Constant velocity and body rate.
void InertialFilter::coast(double dt_s) {
  if (!coasting_) {
    coasting_ = true;
    gyro_bias_aside_radps_ = state_.gyro_bias_body_radps;
    gyro_bias_aside_covariance_ = P_.block<3, 3>(kGyroBias, kGyroBias);
    const Matrix3 rate_covariance =
        has_sample_ ? gyro_bias_aside_covariance_ : Matrix3(squared(kStartRate_radps) * Matrix3::Identity());
    set_gyro_bias(-state_.nav.omega_body_radps, rate_covariance);
  }
  const Vector3 turn_rad = -dt_s * state_.gyro_bias_body_radps;
  Covariance F = Covariance::Identity();
  F.block<3, 3>(kP, kV) = dt_s * Matrix3::Identity();
  F.block<3, 3>(kTheta, kTheta) = rotation_by(-turn_rad).toRotationMatrix();
  F.block<3, 3>(kTheta, kGyroBias) = -dt_s * Matrix3::Identity();
  P_ = propagated(F, P_);
  state_.nav.p_m += dt_s * state_.nav.v_mps;
  state_.nav.q = (state_.nav.q * rotation_by(turn_rad)).normalized();
  state_.nav.omega_body_radps = -state_.gyro_bias_body_radps;
  const auto add_walk = [&](int integral, int walk, double sign, double density) {
    const double q = noise_factor_ * squared(density) * dt_s;
    P_.block<3, 3>(integral, integral).diagonal().array() += q * dt_s * dt_s / 3.0;
    P_.block<3, 3>(integral, walk).diagonal().array() += sign * q * dt_s / 2.0;
    P_.block<3, 3>(walk, integral).diagonal().array() += sign * q * dt_s / 2.0;
    P_.block<3, 3>(walk, walk).diagonal().array() += q;
  };
  add_walk(kP, kV, 1.0, kCoastAccel_mps2_sqrt_hz);
  add_walk(kTheta, kGyroBias, -1.0, kCoastAngularAccel_radps2_sqrt_hz);
}

/// Replaces the estimated bias by an independent one.
void InertialFilter::set_gyro_bias(const Vector3& bias_body_radps, const Matrix3& covariance) {
  state_.gyro_bias_body_radps = bias_body_radps;
  P_.middleRows<3>(kGyroBias).setZero();
  P_.middleCols<3>(kGyroBias).setZero();
  P_.block<3, 3>(kGyroBias, kGyroBias) = covariance;
}

void InertialFilter::begin_with(const InertialFilter& learned, const Vector3& v_start_local_mps) {
  state_.nav.v_mps = v_start_local_mps;
  state_.accel_bias_body_mps2 = learned.state_.accel_bias_body_mps2;
  state_.gyro_bias_body_radps = learned.state_.gyro_bias_body_radps;
  state_.tilt_local = learned.state_.tilt_local;
  state_.time_offset_s = learned.state_.time_offset_s;
  constexpr int kNum = kStates - kAccelBias;
  P_.block<3, 3>(kV, kV) =
      bounded<3>(kTwice * learned.P_.block<3, 3>(kV, kV), P_.diagonal().segment<3>(kV).cwiseSqrt());
  P_.bottomRightCorner<kNum, kNum>() =
      bounded<kNum>(kTwice * learned.P_.bottomRightCorner<kNum, kNum>(), P_.diagonal().tail<kNum>().cwiseSqrt());
}

/// A small rotation phi changes the direction of gravity (0, 0, -1) by phi x (0, 0, -1) = (-phi_y, phi_x, 0).
Matrix3 InertialFilter::level_covariance_rad2() const {
  Eigen::Matrix<double, 3, 2> A;
  A << 0.0, 1.0, -1.0, 0.0, 0.0, 0.0;
  return A * P_.block<2, 2>(kTilt, kTilt) * A.transpose();
}

Matrix3 InertialFilter::level() {
  const Matrix3 R =
      Eigen::Quaterniond::FromTwoVectors(state_.gravity_local_mps2(), -Vector3::UnitZ()).toRotationMatrix();
  state_.nav.q = (Eigen::Quaterniond(R) * state_.nav.q).normalized();
  state_.nav.v_mps = R * state_.nav.v_mps;
  state_.tilt_local.setZero();
  return R;
}

/// The scan's pose is the state's plus the motion during the time offset. An exact one leaves the state's pose the
/// error of that motion.
void InertialFilter::anchor_pose() {
  Covariance A = Covariance::Identity();
  A.middleRows<3>(kP).setZero();
  A.middleRows<3>(kTheta).setZero();
  A.block<3, 1>(kP, kTimeOffset) = -twist_.head<3>();
  A.block<3, 1>(kTheta, kTimeOffset) = -twist_.tail<3>();
  P_ = propagated(A, P_);
}

void InertialFilter::step(const Vector3& omega_body_radps, const Vector3& force_body_mps2, double dt) {
  const Covariance F = transition(state_, omega_body_radps, force_body_mps2, dt);
  state_ = advanced(state_, omega_body_radps, force_body_mps2, dt);
  P_ = propagated(F, P_);

  const double noise_dt = noise_factor_ * dt;
  const double accel_q = squared(config_.accel_noise_mps2_sqrt_hz) * noise_dt;
  P_.block<3, 3>(kP, kP).diagonal().array() += accel_q * dt * dt / 4.0;
  P_.block<3, 3>(kP, kV).diagonal().array() += accel_q * dt / 2.0;
  P_.block<3, 3>(kV, kP).diagonal().array() += accel_q * dt / 2.0;
  P_.block<3, 3>(kV, kV).diagonal().array() += accel_q;
  P_.block<3, 3>(kTheta, kTheta).diagonal().array() += squared(config_.gyro_noise_radps_sqrt_hz) * noise_dt;
  P_.block<3, 3>(kAccelBias, kAccelBias).diagonal().array() += squared(config_.accel_walk_mps3_sqrt_hz) * noise_dt;
  P_.block<3, 3>(kGyroBias, kGyroBias).diagonal().array() += squared(config_.gyro_walk_radps2_sqrt_hz) * noise_dt;
  if (dt > kLongestStep_s) {  // the motion in the gap is unknown
    P_.block<3, 3>(kP, kP).diagonal().array() += squared(dt * dt);
    P_.block<3, 3>(kV, kV).diagonal().array() += squared(2.0 * dt);
    P_.block<3, 3>(kTheta, kTheta).diagonal().array() += squared(dt);
  }
}

InertialFilter::Vector6 InertialFilter::pose_part(const Error& d) const {
  Vector6 part;
  part << d.segment<3>(kP) - lag_s_ * d.segment<3>(kV), d.segment<3>(kTheta) + lag_s_ * d.segment<3>(kGyroBias);
  return part + d(kTimeOffset) * twist_;
}

Matrix6 InertialFilter::pose_covariance() const {
  const PoseColumns columns = pose_columns();
  Matrix6 out;
  out.topRows<3>() = columns.middleRows<3>(kP) - lag_s_ * columns.middleRows<3>(kV);
  out.bottomRows<3>() = columns.middleRows<3>(kTheta) + lag_s_ * columns.middleRows<3>(kGyroBias);
  return out + twist_ * columns.row(kTimeOffset);
}

/// While the vehicle moves, an error of the time offset displaces the present pose as well.
Matrix6 InertialFilter::pose_covariance_after(double dt_s) const {
  Eigen::Matrix<double, 6, kStates> A = Eigen::Matrix<double, 6, kStates>::Zero();
  A.block<3, 3>(0, kP).setIdentity();
  A.block<3, 3>(0, kV).diagonal().setConstant(dt_s);
  A.block<3, 1>(0, kTimeOffset) = state_.nav.v_mps;
  A.block<3, 3>(3, kTheta).setIdentity();
  A.block<3, 3>(3, kGyroBias).diagonal().setConstant(-dt_s);
  A.block<3, 1>(3, kTimeOffset) = state_.nav.omega_body_radps;
  Matrix6 out = A * P_ * A.transpose();
  const double dt3_s3 = dt_s * dt_s * dt_s;
  out.diagonal().head<3>().array() += squared(kCoastAccel_mps2_sqrt_hz) * dt3_s3 / 3.0;
  out.diagonal().tail<3>().array() += squared(kCoastAngularAccel_radps2_sqrt_hz) * dt3_s3 / 3.0;
  return out;
}

/// P H^T, with the derivative H of the measured pose by the state.
InertialFilter::PoseColumns InertialFilter::pose_columns() const {
  PoseColumns columns;
  columns.leftCols<3>() = P_.middleCols<3>(kP) - lag_s_ * P_.middleCols<3>(kV);
  columns.rightCols<3>() = P_.middleCols<3>(kTheta) + lag_s_ * P_.middleCols<3>(kGyroBias);
  return columns + P_.col(kTimeOffset) * twist_.transpose();
}

/// Pose of the scan's points at an iterate of the update.
Pose InertialFilter::measured_pose(const Error& at) const {
  Vector6 motion = at(kTimeOffset) * twist_;
  motion.head<3>() -= lag_s_ * at.segment<3>(kV);
  motion.tail<3>() += lag_s_ * at.segment<3>(kGyroBias);
  return make_pose(state_.nav.p_m + motion.head<3>(), (state_.nav.q * rotation_by(motion.tail<3>())).normalized());
}

/// With the prior N(0, P), the measured pose's change H d by an error d, and the evidence (Omega, b) at H d = H at:
/// d = P H^T (I + Omega H P H^T)^-1 (Omega H at - b). No inverse of P is needed, which may be singular.
InertialFilter::Error InertialFilter::most_likely(const PoseEvidence& evidence, const Error& at) const {
  const Matrix6 A = Matrix6::Identity() + evidence.information * pose_covariance();
  const Vector6 y = A.partialPivLu().solve(evidence.information * pose_part(at) - evidence.gradient);
  return pose_columns() * y;
}

/// The innovation z, whose information is Omega, has the covariance S = Omega^-1 + H P H^T. With y = S^-1 z as above,
/// z^T S^-1 z = y^T Omega^-1 y + y^T H P H^T y, where y lies in the range of Omega.
void InertialFilter::settle(const PoseEvidence& evidence, const Error& at) {
  // [1/m^2, 1/rad^2] Information that makes Omega regular, far below a scan's. Larger values understate innovations.
  constexpr double kMinInformation = 1e-3;
  const PoseColumns columns = pose_columns();
  const Matrix6 prior = pose_covariance();
  const auto A = Matrix6(Matrix6::Identity() + evidence.information * prior).partialPivLu();
  const Vector6 y = A.solve(evidence.information * pose_part(at) - evidence.gradient);
  const Matrix6 regular = evidence.information + kMinInformation * Matrix6::Identity();
  innovation_sq_ = y.dot(prior * y) + y.dot(regular.partialPivLu().solve(y));
  const Matrix6 M = A.solve(evidence.information);
  settle(P_ - columns * M * columns.transpose());
}

void InertialFilter::settle(const Covariance& posterior) {
  P_ = 0.5 * (posterior + posterior.transpose());
  // Keeps variances positive despite rounding.
  for (int i = 0; i < kStates; ++i) P_(i, i) = std::max(P_(i, i), 1e-18);
}

void InertialFilter::measure(const Pose& T_local_body, double sigma_m, double sigma_rad) {
  constexpr int kIterations = 5;  // [-] the rotation is not linear; more iterations change nothing
  Vector6 information;
  information << Vector3::Constant(1.0 / squared(sigma_m)), Vector3::Constant(1.0 / squared(sigma_rad));
  const Eigen::Quaterniond q_inverse(T_local_body.linear().transpose());
  update(
      [&](const Pose& T) {
        Vector6 error;
        error << T.translation() - T_local_body.translation(),
            rotation_vector_rad(q_inverse * Eigen::Quaterniond(T.linear()));
        PoseEvidence evidence;
        evidence.information = information.asDiagonal();
        evidence.gradient = information.cwiseProduct(error);
        return evidence;
      },
      kIterations);
}

void InertialFilter::move_towards(const Pose& T_local_body, double sigma_m, double sigma_rad) {
  const Covariance P = P_;
  measure(T_local_body, sigma_m, sigma_rad);
  P_ = P;
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
  v.field("start_tilt_sigma_deg", start_tilt_sigma_deg,
          "[deg] standard deviation of the start pose's tilt; above about 1, the first scans level the local frame",
          positive);
  v.field("time_offset_s", time_offset_s, "[s] stamp of the IMU minus stamp of the LiDAR at the same instant",
          Range::between(-1.0, 1.0));
  v.field("time_offset_sigma_s", time_offset_sigma_s,
          "[s] standard deviation of time_offset_s, which is estimated; 0: taken as given", Range::between(0.0, 1.0));
}

}  // namespace swiftlet
