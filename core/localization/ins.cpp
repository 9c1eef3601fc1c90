// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/ins.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [m] Standard deviation of the initial estimate of the ground height. Larger values let the first altimeter samples
/// correct the ground height instead of the vehicle's height.
constexpr double kStartGround_sigma_m = 2.0;
/// [sigma] Innovation beyond which a measurement is rejected. Larger values accept more outliers.
constexpr double kGate_sigma = 6.0;
/// [s] Longest time without IMU samples that is extrapolated: during a longer one the estimate is not valid, and after
/// it the motion in between counts as unknown. Larger values trust the extrapolation through longer gaps.
constexpr double kMaxImuGap_s = 0.1;
/// [-] Consecutive rejections of one source after which the filter counts as diverged and its next measurement is
/// accepted. Larger values tolerate longer series of outliers, but recover later.
constexpr int kMaxConsecutiveRejections = 20;
/// [m/s^2] Standard deviation of the acceleration assumed during a longer gap. Larger values let the next
/// measurements correct the estimate faster.
constexpr double kGapAcceleration_sigma_mps2 = 2.0;
/// [-] Squared horizontal length of the body's x axis below which the heading is undefined: nose straight up or down.
constexpr double kMinHorizontal_sq = 0.01;

/// Sources of measurements, each with its own count of consecutive rejections.
enum Source { kGnssPosition, kGnssVelocity, kAltimeter, kCompass, kOdometry };

Vector3 cwise_square(const Vector3& v) { return v.cwiseProduct(v); }

double square(double x) { return x * x; }

/// A P A^T.
InsFilter::Covariance sandwiched(const InsFilter::Covariance& A, const InsFilter::Covariance& P) {
  const InsFilter::Covariance AP = A * P;
  return AP * A.transpose();
}

class InsEstimator : public StateEstimator {
 public:
  InsEstimator(const InsConfig& config, const AgentSetup& setup)
      : config_(config),
        filter_(config, setup.T_local_body_start),
        start_m_(setup.T_local_body_start.translation()),
        heading_known_(setup.start_known == StartKnown::kPose),
        position_known_(setup.start_known != StartKnown::kNothing) {
    estimate_.valid = true;
    estimate_.T_local_body = setup.T_local_body_start;
  }

  const StateEstimate& update(const Observation& observation, Outbox&) override {
    process(observation);
    const NavState& now = filter_.state();
    estimate_.t = observation.t;
    const double ahead_s = to_seconds(observation.t - now.t);
    estimate_.T_local_body =
        make_pose(now.p_m + ahead_s * now.v_mps, (now.q * rotation_by(ahead_s * now.omega_body_radps)).normalized());
    estimate_.v_local_mps = now.v_mps;
    estimate_.omega_body_radps = now.omega_body_radps;
    fill_covariance();
    check_validity(ahead_s);
    return estimate_;
  }

  const char* fault() const override { return fault_; }

 private:
  /// Propagates the filter by all IMU samples of the tick, then applies the other measurements. Delayed ones are
  /// compared with the state at their stamp.
  void process(const Observation& observation) {
    for (const ImuSample& sample : observation.imu) filter_.predict(sample);
    if (config_.use_gnss)
      for (const GnssSample& sample : observation.gnss) process(sample);
    if (config_.use_altimeter)
      for (const AltimeterSample& sample : observation.altimeter) filter_.update(sample);
    if (config_.use_compass)
      for (const CompassSample& sample : observation.compass) process(sample);
    if (config_.use_odometry)
      for (const OdometrySample& sample : observation.odometry) filter_.update(sample);
  }

  /// Transforms absolute measurements by the correction into the local frame, in which the filter runs. With an unknown
  /// start heading or position, the first sample sets that part of the correction.
  void process(const CompassSample& sample) {
    if (!heading_known_) {
      if (!std::isfinite(sample.yaw_rad)) return;
      heading_known_ = true;
      const double yaw_rad = sample.yaw_rad - yaw_of(filter_.state().q.toRotationMatrix());
      estimate_.correct(level_alignment(yaw_rad, start_m_, start_m_));
      return;
    }
    CompassSample local = sample;
    local.yaw_rad = FrameChange::to_local(estimate_).yaw(sample.yaw_rad);
    filter_.update(local);
  }

  void process(const GnssSample& sample) {
    if (!heading_known_) return;
    if (!position_known_) {
      if (!sample.p_world_m.allFinite()) return;
      position_known_ = true;
      estimate_.correct(
          level_alignment(yaw_of(estimate_.T_world_local.linear()), sample.p_world_m, filter_.state().p_m));
      return;
    }
    const FrameChange to_local = FrameChange::to_local(estimate_);
    GnssSample local = sample;
    local.p_world_m = to_local.point(sample.p_world_m);
    local.v_world_mps = to_local.direction(sample.v_world_mps);
    filter_.update(local);
  }

  void fill_covariance() {
    const InsFilter::Covariance& P = filter_.covariance();
    estimate_.covariance.topLeftCorner<3, 3>() = P.block<3, 3>(InsFilter::kP, InsFilter::kP);
    estimate_.covariance.topRightCorner<3, 3>() = P.block<3, 3>(InsFilter::kP, InsFilter::kTheta);
    estimate_.covariance.bottomLeftCorner<3, 3>() = P.block<3, 3>(InsFilter::kTheta, InsFilter::kP);
    estimate_.covariance.bottomRightCorner<3, 3>() = P.block<3, 3>(InsFilter::kTheta, InsFilter::kTheta);
  }

  void check_validity(double ahead_s) {
    const double sigma_p_m = std::sqrt(estimate_.covariance.diagonal().head<3>().maxCoeff());
    fault_ = "";
    if (!filter_.is_sound())
      fault_ = "inertial navigation failed: its state is not finite";
    else if (ahead_s > kMaxImuGap_s)
      fault_ = "no IMU";
    else if (sigma_p_m > config_.position_sigma_max_m)
      fault_ = "position too uncertain";
    estimate_.valid = fault_[0] == '\0';
  }

  InsConfig config_;
  InsFilter filter_;  // in the local frame
  Vector3 start_m_;
  bool heading_known_, position_known_;  // whether heading and position of the local frame in the world are known
  StateEstimate estimate_;
  const char* fault_ = "";
};

}  // namespace

InsFilter::InsFilter(const InsConfig& config, const Pose& T_local_body_start) : config_(config) {
  nominal_.p_m = T_local_body_start.translation();
  nominal_.q = Eigen::Quaterniond(T_local_body_start.linear()).normalized();
  ground_m_ = nominal_.p_m.z();

  // Start attitude: tilt and heading have different variances about the world axes, here rotated into body axes.
  const Matrix3 R = nominal_.q.toRotationMatrix();
  const double tilt_variance = square(config.start_tilt_sigma_deg * kRadPerDeg);
  const Vector3 attitude_variance(tilt_variance, tilt_variance, square(config.start_yaw_sigma_deg * kRadPerDeg));
  P_.diagonal() << Vector3::Constant(square(config.start_position_sigma_m)),
      Vector3::Constant(square(config.start_velocity_sigma_mps)), Vector3::Zero(),
      Vector3::Constant(square(config.start_accel_bias_sigma_mps2)),
      Vector3::Constant(square(config.start_gyro_bias_sigma_radps)), square(kStartGround_sigma_m);
  P_.block<3, 3>(kTheta, kTheta) = R.transpose() * attitude_variance.asDiagonal() * R;
  remember();
}

bool InsFilter::is_sound() const {
  return nominal_.all_finite() && accel_bias_.allFinite() && gyro_bias_.allFinite() && P_.allFinite() &&
         P_.diagonal().minCoeff() >= 0.0;
}

void InsFilter::predict(const ImuSample& sample) {
  if (!sample.omega_body_radps.allFinite() || !sample.specific_force_body_mps2.allFinite()) return;
  const double dt = to_seconds(sample.t - nominal_.t);
  if (dt <= 0.0) return;

  const Vector3 omega = sample.omega_body_radps - gyro_bias_;
  const Vector3 specific_force = sample.specific_force_body_mps2 - accel_bias_;
  const Matrix3 R = (nominal_.q * rotation_by(0.5 * dt * omega)).toRotationMatrix();
  strapdown(nominal_, omega, specific_force, dt);
  nominal_.t = sample.t;

  // Error dynamics (Solà, eq. 270 and 271, first order in dt; second order where position depends on acceleration).
  Covariance F = Covariance::Identity();
  const Matrix3 da_dtheta = -R * skew_of(specific_force);
  F.block<3, 3>(kP, kV) = Matrix3::Identity() * dt;
  F.block<3, 3>(kP, kTheta) = 0.5 * dt * dt * da_dtheta;
  F.block<3, 3>(kP, kAccelBias) = -0.5 * dt * dt * R;
  F.block<3, 3>(kV, kTheta) = dt * da_dtheta;
  F.block<3, 3>(kV, kAccelBias) = -dt * R;
  F.block<3, 3>(kTheta, kTheta) = rotation_by(-dt * omega).toRotationMatrix();
  F.block<3, 3>(kTheta, kGyroBias) = -dt * Matrix3::Identity();
  P_ = sandwiched(F, P_);

  const double accel_q = square(config_.accel_noise_mps2_sqrt_hz) * dt;
  P_.block<3, 3>(kP, kP).diagonal().array() += accel_q * dt * dt / 4.0;
  P_.block<3, 3>(kP, kV).diagonal().array() += accel_q * dt / 2.0;
  P_.block<3, 3>(kV, kP).diagonal().array() += accel_q * dt / 2.0;
  P_.block<3, 3>(kV, kV).diagonal().array() += accel_q;
  P_.block<3, 3>(kTheta, kTheta).diagonal().array() += square(config_.gyro_noise_radps_sqrt_hz) * dt;
  P_.block<3, 3>(kAccelBias, kAccelBias).diagonal().array() += square(config_.accel_walk_mps3_sqrt_hz) * dt;
  P_.block<3, 3>(kGyroBias, kGyroBias).diagonal().array() += square(config_.gyro_walk_radps2_sqrt_hz) * dt;
  // The ground height is a random walk over the horizontal distance flown.
  P_(kGround, kGround) += square(config_.ground_walk_m_sqrt_m) * nominal_.v_mps.head<2>().norm() * dt;
  if (dt > kMaxImuGap_s) {
    P_.block<3, 3>(kP, kP).diagonal().array() += square(0.5 * kGapAcceleration_sigma_mps2 * dt * dt);
    P_.block<3, 3>(kV, kV).diagonal().array() += square(kGapAcceleration_sigma_mps2 * dt);
  }
  remember();
}

void InsFilter::update(const GnssSample& sample) {
  const NavState& then = at(sample.t);
  if (sample.p_world_m.allFinite() && sample.sigma_p_m.allFinite()) {
    Eigen::Matrix<double, 3, kStates> H = Eigen::Matrix<double, 3, kStates>::Zero();
    H.block<3, 3>(0, kP).setIdentity();
    correct<3>(sample.p_world_m - then.p_m, H, cwise_square(sample.sigma_p_m).asDiagonal(), kGnssPosition);
  }
  if (sample.v_world_mps.allFinite() && sample.sigma_v_mps.allFinite()) {
    Eigen::Matrix<double, 3, kStates> H = Eigen::Matrix<double, 3, kStates>::Zero();
    H.block<3, 3>(0, kV).setIdentity();
    correct<3>(sample.v_world_mps - at(sample.t).v_mps, H, cwise_square(sample.sigma_v_mps).asDiagonal(),
               kGnssVelocity);
  }
}

void InsFilter::update(const AltimeterSample& sample) {
  if (!std::isfinite(sample.height_m) || !std::isfinite(sample.sigma_m)) return;
  const NavState& then = at(sample.t);
  if (!ground_known_) {  // the first sample initializes the ground height, with the variance set at the start
    ground_m_ = then.p_m.z() - sample.height_m;
    ground_known_ = true;
  }
  Eigen::Matrix<double, 1, kStates> H = Eigen::Matrix<double, 1, kStates>::Zero();
  H[kP + 2] = 1.0;
  H[kGround] = -1.0;
  correct<1>(Eigen::Matrix<double, 1, 1>(sample.height_m - (then.p_m.z() - ground_m_)), H,
             Eigen::Matrix<double, 1, 1>(square(sample.sigma_m)), kAltimeter);
}

void InsFilter::update(const CompassSample& sample) {
  if (!std::isfinite(sample.yaw_rad) || !std::isfinite(sample.sigma_rad)) return;
  // yaw = atan2(R10, R00). A small rotation theta in body axes changes the first column of R by R (theta x e1).
  const Matrix3 R = at(sample.t).q.toRotationMatrix();
  const double horizontal_sq = R(0, 0) * R(0, 0) + R(1, 0) * R(1, 0);
  if (horizontal_sq < kMinHorizontal_sq) return;
  Eigen::Matrix<double, 1, kStates> H = Eigen::Matrix<double, 1, kStates>::Zero();
  const Matrix3 dcolumn_dtheta = -R * skew_of(Vector3::UnitX());
  H.block<1, 3>(0, kTheta) = (R(0, 0) * dcolumn_dtheta.row(1) - R(1, 0) * dcolumn_dtheta.row(0)) / horizontal_sq;
  const double innovation = std::remainder(sample.yaw_rad - yaw_of(R), 2.0 * std::numbers::pi);
  correct<1>(Eigen::Matrix<double, 1, 1>(innovation), H, Eigen::Matrix<double, 1, 1>(square(sample.sigma_rad)),
             kCompass);
}

void InsFilter::update(const OdometrySample& sample) {
  if (!sample.T_local_body.matrix().allFinite() || !sample.v_local_body_mps.allFinite()) return;
  // The heading of the odometry drifts. Velocities are compared in body axes, in which this heading has no effect.
  const NavState& then = at(sample.t);
  const Matrix3 R_body_world = then.q.toRotationMatrix().transpose();
  const Vector3 v_body = R_body_world * then.v_mps;
  const Vector3 measured = sample.T_local_body.linear().transpose() * sample.v_local_body_mps;
  Eigen::Matrix<double, 3, kStates> H = Eigen::Matrix<double, 3, kStates>::Zero();
  H.block<3, 3>(0, kV) = R_body_world;
  H.block<3, 3>(0, kTheta) = skew_of(v_body);
  correct<3>(measured - v_body, H, Matrix3::Identity() * square(config_.odometry_velocity_sigma_mps), kOdometry);
}

template <int M>
void InsFilter::correct(const Eigen::Matrix<double, M, 1>& innovation, const Eigen::Matrix<double, M, kStates>& H,
                        const Eigen::Matrix<double, M, M>& R, int source) {
  const Eigen::Matrix<double, kStates, M> PHt = P_ * H.transpose();
  const Eigen::Matrix<double, M, M> S = H * PHt + R;
  const Eigen::Matrix<double, M, M> S_inverse = S.inverse();

  // Mahalanobis gate: outliers are rejected. If they persist, the filter has diverged.
  const double distance_sq = innovation.dot(S_inverse * innovation);
  if (!std::isfinite(distance_sq) || distance_sq < 0.0) return;
  if (distance_sq > M * square(kGate_sigma)) {
    ++num_rejected_;
    if (++rejected_in_a_row_[source] <= kMaxConsecutiveRejections) return;
    // Inflates the covariance of the observed states by the squared innovation, so that they follow the measurement.
    P_ += H.transpose() * (H * H.transpose()).diagonal().cwiseInverse().asDiagonal() *
          innovation.cwiseProduct(innovation).asDiagonal() * H;
    rejected_in_a_row_[source] = 0;
    correct<M>(innovation, H, R, source);
    return;
  }
  rejected_in_a_row_[source] = 0;

  const Eigen::Matrix<double, kStates, M> K = PHt * S_inverse;
  const Covariance I_KH = Covariance::Identity() - K * H;
  P_ = sandwiched(I_KH, P_) + K * R * K.transpose();  // Joseph form: stays positive definite
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  inject(K * innovation);
}

void InsFilter::inject(const Eigen::Matrix<double, kStates, 1>& dx) {
  if (!dx.allFinite()) return;
  const Eigen::Quaterniond turn = rotation_by(dx.segment<3>(kTheta));
  nominal_.p_m += dx.segment<3>(kP);
  nominal_.v_mps += dx.segment<3>(kV);
  nominal_.q = (nominal_.q * turn).normalized();
  accel_bias_ += dx.segment<3>(kAccelBias);
  gyro_bias_ += dx.segment<3>(kGyroBias);
  nominal_.omega_body_radps -= dx.segment<3>(kGyroBias);
  ground_m_ += dx[kGround];
  // Corrects the stored states too, so that delayed measurements do not correct the same error again.
  for (int i = 0; i < count_; ++i) {
    history_[i].p_m += dx.segment<3>(kP);
    history_[i].v_mps += dx.segment<3>(kV);
    history_[i].q = (history_[i].q * turn).normalized();
  }
}

/// Stored state at the IMU sample nearest to t.
const NavState& InsFilter::at(TimeNs t) const {
  if (t >= nominal_.t || count_ == 0) return nominal_;
  int best = newest_;
  for (int age = 1; age < count_; ++age) {
    const int i = (newest_ - age + kHistory) % kHistory;
    if (std::abs(history_[i].t - t) >= std::abs(history_[best].t - t)) break;
    best = i;
  }
  return history_[best];
}

void InsFilter::remember() {
  newest_ = (newest_ + 1) % kHistory;
  count_ = std::min(count_ + 1, kHistory);
  history_[newest_] = nominal_;
}

void InsConfig::visit(ConfigVisitor& v) {
  const Range positive = Range::positive();
  visit_noise(v);
  v.field("start_position_sigma_m", start_position_sigma_m, "[m] standard deviation of the start position, per axis",
          positive);
  v.field("start_velocity_sigma_mps", start_velocity_sigma_mps,
          "[m/s] standard deviation of the start velocity, whose estimate is zero, per axis", positive);
  v.field("start_tilt_sigma_deg", start_tilt_sigma_deg, "[deg] standard deviation of the start pose's tilt", positive);
  v.field("start_yaw_sigma_deg", start_yaw_sigma_deg, "[deg] standard deviation of the start pose's heading", positive);
  v.field("use_gnss", use_gnss, "[-] whether GNSS position and velocity are used");
  v.field("use_altimeter", use_altimeter, "[-] whether the altimeter's height above the surface below is used");
  v.field("use_compass", use_compass, "[-] whether the compass heading is used");
  v.field("use_odometry", use_odometry, "[-] whether the odometry's velocity in body axes is used");
  v.field("position_sigma_max_m", position_sigma_max_m,
          "[m] standard deviation of the position above which the estimate is not valid", positive);
}

std::unique_ptr<StateEstimator> make_ins_estimator(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<InsEstimator>(dynamic_cast<const InsConfig&>(config), setup);
}

}  // namespace swiftlet
