// SPDX-License-Identifier: BSD-3-Clause
#include "core/localization/relative_filter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

/// [s] Largest delay of a sighting or an odometry sample. Larger values accept later ones and cost time.
constexpr double kHistory_s = 3.0;
/// [-] Maximum number of measurements in the history. Smaller values reject measurements with less delay than
/// kHistory_s.
constexpr std::size_t kMaxHistory = 128;
/// [-] Variance by which the logarithm of the drift factor becomes uncertain with each odometry sample. Larger values
/// adapt the factor faster and more noisily; with this value, an excessive factor decays within a minute.
constexpr double kLogFactorWalk = 0.003;
/// [-] Upper bound of the squared Mahalanobis distance of an innovation in the estimation of the drift factor. Larger
/// values adapt the factor faster, but let a single outlier dominate it.
constexpr double kMaxInnovation_sq = 25.0;

Matrix3 rotation_about_vertical(double yaw_rad) {
  const double s = elementary::sin(yaw_rad), c = elementary::cos(yaw_rad);
  return (Matrix3() << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0).finished();
}

/// Cross product of the unit vector along z with v: the derivative of v when it rotates about the vertical.
Vector3 vertical_cross(const Vector3& v) { return {-v.y(), v.x(), 0.0}; }

/// A P A^T, coefficient by coefficient: Eigen's product for large matrices costs more at this size and may start
/// threads.
template <class Transition, class Matrix>
Matrix carried(const Transition& A, const Matrix& P) {
  const Matrix AP = A.lazyProduct(P);
  return AP.lazyProduct(A.transpose());
}

}  // namespace

void RelativeFilterConfig::visit(ConfigVisitor& v) {
  v.field(
      "bias_sigma_m", bias_sigma_m,
      "[m] standard deviation per axis of the error common to all sightings; added to the covariance of each estimate, "
      "because averaging over sightings does not reduce it",
      Range::non_negative());
  v.field("drift_factor_max", drift_factor_max,
          "[-] upper bound of the estimated ratio of actual to configured odometry drift; 1: drift as configured",
          Range::between(1.0, 1000.0));
}

RelativeFilter::RelativeFilter(const RelativeFilterConfig& config, const OdometryDriftConfig& drift)
    : config_(config), drift_(drift) {
  history_.reserve(kMaxHistory + 1);
}

void RelativeFilter::stop() {
  started_ = false;
  base_ = newest();
  history_.clear();
}

void RelativeFilter::start(const FrameAlignment& alignment, const OtherMotion& anchor) {
  const State before = newest();
  history_.clear();
  started_ = true;
  base_ = {};
  base_.log_factor = before.log_factor;
  base_.log_factor_variance = before.log_factor_variance;
  base_.t = base_.seen = anchor.t;
  base_.odometry = anchor;
  const Vector3 v_local_mps = rotation_about_vertical(alignment.yaw_rad) * anchor.v_other_local_mps;
  base_.x << alignment.anchor_local_m, v_local_mps, alignment.anchor_local_m, alignment.yaw_rad;
  // Position and velocity are functions of the alignment, each with the noise of the odometry.
  Eigen::Matrix<double, kStates, 4> J = Eigen::Matrix<double, kStates, 4>::Zero();
  J.block<3, 3>(kP, 0).setIdentity();
  J.block<3, 1>(kV, 3) = vertical_cross(v_local_mps);
  J.block<4, 4>(kAnchor, 0).setIdentity();
  const Eigen::Matrix<double, kStates, 4> JC = J.lazyProduct(alignment.covariance);
  base_.P = JC.lazyProduct(J.transpose());
  base_.P.diagonal().segment<3>(kP).array() += config_.odometry_sigma_m * config_.odometry_sigma_m;
  base_.P.diagonal().segment<3>(kV).array() +=
      config_.odometry_velocity_sigma_mps * config_.odometry_velocity_sigma_mps;
}

bool RelativeFilter::push(const OtherMotion& odometry) {
  Entry entry;
  entry.t = odometry.t;
  entry.is_odometry = true;
  entry.odometry = odometry;
  return insert(entry);
}

RelativeFilter::Expected RelativeFilter::expected(const Sighting& sighting) const {
  State state = before(sighting.t);
  predict(state, std::max(sighting.t, state.t));
  return {state.x.segment<3>(kP), state.P.topLeftCorner<3, 3>() + sighting.covariance};
}

double RelativeFilter::squared_sigmas(const Sighting& sighting) const {
  const Expected predicted = expected(sighting);
  const Vector3 innovation = sighting.p_local_m - predicted.p_local_m;
  return innovation.dot(predicted.covariance.llt().solve(innovation));
}

double RelativeFilter::unlikelihood(const Sighting& sighting) const {
  return squared_sigmas(sighting) + elementary::log(expected(sighting).covariance.determinant());
}

bool RelativeFilter::push(const Sighting& sighting) {
  if (sighting.t < base_.t || !(squared_sigmas(sighting) <= config_.gate_sigma * config_.gate_sigma)) return false;
  Entry entry;
  entry.t = sighting.t;
  entry.sighting = sighting;
  return insert(entry);
}

/// Inserts a measurement in order of time, and applies it and all later ones.
bool RelativeFilter::insert(Entry entry) {
  ENSURE(started_);
  if (entry.t < base_.t) return false;
  const auto place = std::upper_bound(history_.begin(), history_.end(), entry.t,
                                      [](TimeNs t, const Entry& other) { return t < other.t; });
  const auto first = static_cast<std::size_t>(place - history_.begin());
  history_.insert(place, entry);
  for (std::size_t i = first; i < history_.size(); ++i) {
    State state = i == 0 ? base_ : history_[i - 1].after;
    predict(state, history_[i].t);
    history_[i].is_odometry ? correct(state, history_[i].odometry) : correct(state, history_[i].sighting);
    history_[i].after = state;
  }
  // Entries older than the longest accepted delay are merged into the base state.
  const TimeNs oldest = history_.back().t - from_seconds(kHistory_s);
  std::size_t num_old = 0;
  while (num_old + 1 < history_.size() && (history_[num_old].t < oldest || history_.size() - num_old > kMaxHistory)) {
    ++num_old;
  }
  if (num_old > 0) {
    base_ = history_[num_old - 1].after;
    history_.erase(history_.begin(), history_.begin() + static_cast<std::ptrdiff_t>(num_old));
  }
  return true;
}

/// Newest state at or before t, or the oldest state.
const RelativeFilter::State& RelativeFilter::before(TimeNs t) const {
  for (auto entry = history_.rbegin(); entry != history_.rend(); ++entry) {
    if (entry->t <= t) return entry->after;
  }
  return base_;
}

void RelativeFilter::predict(State& state, TimeNs t) const {
  const double dt = to_seconds(t - state.t);
  if (dt <= 0.0) return;
  state.t = t;
  state.x.segment<3>(kP) += dt * state.x.segment<3>(kV);
  Covariance A = Covariance::Identity();
  A.block<3, 3>(kP, kV).diagonal().setConstant(dt);
  state.P = carried(A, state.P);
  const double q = config_.acceleration_mps2_psqrthz * config_.acceleration_mps2_psqrthz;
  for (int axis = 0; axis < 3; ++axis) {
    state.P(kP + axis, kP + axis) += q * dt * dt * dt / 3.0;
    state.P(kP + axis, kV + axis) += q * dt * dt / 2.0;
    state.P(kV + axis, kP + axis) += q * dt * dt / 2.0;
    state.P(kV + axis, kV + axis) += q * dt;
  }
}

template <int M>
void RelativeFilter::correct(State& state, const Eigen::Matrix<double, M, 1>& innovation,
                             const Eigen::Matrix<double, M, kStates>& H, const Eigen::Matrix<double, M, M>& R) const {
  const Eigen::Matrix<double, kStates, M> PHt = state.P.lazyProduct(H.transpose());
  const Eigen::Matrix<double, M, M> S = H.lazyProduct(PHt) + R;
  const Eigen::Matrix<double, kStates, M> K = S.llt().solve(PHt.transpose()).transpose();
  state.x += K.lazyProduct(innovation);
  // Joseph form: the covariance stays positive definite despite rounding.
  Covariance I_KH = Covariance::Identity();
  I_KH -= K.lazyProduct(H);
  const Eigen::Matrix<double, kStates, M> KR = K.lazyProduct(R);
  const Covariance P = carried(I_KH, state.P) + Covariance(KR.lazyProduct(K.transpose()));
  state.P = 0.5 * (P + P.transpose());
}

void RelativeFilter::correct(State& state, const Sighting& sighting) const {
  Eigen::Matrix<double, 3, kStates> H = Eigen::Matrix<double, 3, kStates>::Zero();
  H.block<3, 3>(0, kP).setIdentity();
  correct<3>(state, sighting.p_local_m - state.x.segment<3>(kP), H, sighting.covariance);
  state.seen = std::max(state.seen, sighting.t);
}

void RelativeFilter::correct(State& state, const OtherMotion& odometry) const {
  // Since its anchor, the alignment has drifted with distance, turning and time. A drift of the heading also displaces
  // the end of the step; the drift is assumed to have occurred in the middle of the step.
  const Flown flown = odometry.flown - state.odometry.flown;
  const Vector3 step_other_m = odometry.p_other_local_m - state.odometry.p_other_local_m;
  const Matrix3 R = rotation_about_vertical(state.x(kYaw));
  const Vector3 displacement_m_per_rad = vertical_cross(R * (-0.5 * step_other_m));
  Eigen::Matrix<double, 4, 1> drift_per_rad;
  drift_per_rad << displacement_m_per_rad, 1.0;
  FrameAlignment::Covariance drift = drift_.yaw_variance_rad2(flown) * (drift_per_rad * drift_per_rad.transpose());
  drift.diagonal().head<3>().array() += drift_.position_variance_m2(flown);

  const Vector3 step_m = R * step_other_m, v_local_mps = R * odometry.v_other_local_mps;
  Eigen::Matrix<double, 6, 1> innovation;
  innovation << state.x.segment<3>(kAnchor) + step_m - state.x.segment<3>(kP), v_local_mps - state.x.segment<3>(kV);
  Eigen::Matrix<double, 6, kStates> H = Eigen::Matrix<double, 6, kStates>::Zero();
  H.block<3, 3>(0, kP).setIdentity();
  H.block<3, 3>(0, kAnchor) = -Matrix3::Identity();
  H.block<3, 1>(0, kYaw) = -vertical_cross(step_m);
  H.block<3, 3>(3, kV).setIdentity();
  H.block<3, 1>(3, kYaw) = -vertical_cross(v_local_mps);
  Matrix6 noise = Matrix6::Zero();
  noise.diagonal().head<3>().setConstant(config_.odometry_sigma_m * config_.odometry_sigma_m);
  noise.diagonal().tail<3>().setConstant(config_.odometry_velocity_sigma_mps * config_.odometry_velocity_sigma_mps);
  const Eigen::Matrix<double, 3, kStates> H_position = H.topRows<3>(), HP = H_position.lazyProduct(state.P);
  const Eigen::Matrix<double, 3, 4> H_anchor = H_position.rightCols<4>(), HD = H_anchor.lazyProduct(drift);
  const Matrix3 expected = HP.lazyProduct(H_position.transpose()) + Matrix3(noise.topLeftCorner<3, 3>());
  learn_drift(state, innovation.head<3>(), expected, HD.lazyProduct(H_anchor.transpose()));
  state.P.block<4, 4>(kAnchor, kAnchor) += elementary::exp(state.log_factor) * drift;
  correct<6>(state, innovation, H, noise);

  // Moves the anchor to this sample.
  const Vector3 anchor_step_m = rotation_about_vertical(state.x(kYaw)) * step_other_m;
  state.x.segment<3>(kAnchor) += anchor_step_m;
  Covariance A = Covariance::Identity();
  A.block<3, 1>(kAnchor, kYaw) = vertical_cross(anchor_step_m);
  state.P = carried(A, state.P);
  state.odometry = odometry;
}

/// With the factor f of the drift variance, the innovation of the position has the covariance S = expected + f
/// of_drift. Its squared Mahalanobis distance d2 has the mean 3 if f is right; the share s = tr(S^-1 f of_drift) / 3
/// depends on f. The log-likelihood has the gradient s (d2 - 3) / 2 with respect to log f, and Fisher's information is
/// 3 s^2 / 2.
void RelativeFilter::learn_drift(State& state, const Vector3& innovation_local_m, const Matrix3& expected,
                                 const Matrix3& of_drift) const {
  const Matrix3 drift = elementary::exp(state.log_factor) * of_drift;
  const Eigen::LLT<Matrix3> S = Matrix3(expected + drift).llt();
  const double squared_sigmas = std::min(innovation_local_m.dot(S.solve(innovation_local_m)), kMaxInnovation_sq);
  const double share = S.solve(drift).trace() / 3.0;
  const double gradient = 0.5 * share * (squared_sigmas - 3.0), information = 1.5 * share * share;
  state.log_factor_variance += kLogFactorWalk;
  state.log_factor_variance /= 1.0 + state.log_factor_variance * information;
  state.log_factor = std::clamp(state.log_factor + state.log_factor_variance * gradient, 0.0,
                                2.0 * elementary::log(config_.drift_factor_max));
}

double RelativeFilter::drift_variance_factor() const { return elementary::exp(newest().log_factor); }

RelativeEstimate RelativeFilter::at(TimeNs t) const {
  ENSURE(started_);
  State state = before(t);
  predict(state, t);
  RelativeEstimate out;
  out.t = t;
  out.position_m = state.x.segment<3>(kP);
  out.velocity_mps = state.x.segment<3>(kV);
  const double since_s = std::max(0.0, to_seconds(t - state.odometry.t));
  out.yaw_rad =
      std::remainder(state.x(kYaw) + state.odometry.yaw_rad + since_s * state.odometry.yaw_rate_radps, 2.0 * kPi);
  out.covariance.topLeftCorner<6, 6>() = state.P.topLeftCorner<6, 6>();
  out.covariance.diagonal().head<3>().array() += config_.bias_sigma_m * config_.bias_sigma_m;
  out.covariance.topRightCorner<6, 1>() = state.P.block<6, 1>(0, kYaw);
  out.covariance.bottomLeftCorner<1, 6>() = state.P.block<1, 6>(kYaw, 0);
  const double sigma_rad = config_.odometry_yaw_sigma_deg * kRadPerDeg;
  const double turned_rad = config_.yaw_rate_sigma_degps * kRadPerDeg * since_s;
  out.covariance(6, 6) = state.P(kYaw, kYaw) + sigma_rad * sigma_rad + turned_rad * turned_rad;
  out.seen = state.seen;
  out.report_t = state.odometry.t;
  out.report_stamp = state.odometry.stamp;
  out.report_position_m = state.x.segment<3>(kAnchor);
  out.report_yaw_rad = std::remainder(state.x(kYaw) + state.odometry.yaw_rad, 2.0 * kPi);
  return out;
}

FrameAlignment RelativeFilter::alignment() const {
  const State& state = newest();
  FrameAlignment out;
  out.anchor_other_m = state.odometry.p_other_local_m;
  out.anchor_local_m = state.x.segment<3>(kAnchor);
  out.yaw_rad = std::remainder(state.x(kYaw), 2.0 * kPi);
  out.covariance = state.P.block<4, 4>(kAnchor, kAnchor);
  return out;
}

}  // namespace swiftlet
