// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/relative_alignment.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet {
namespace {

constexpr int kMaxSteps = 30;        // largest number of steps of a refinement; three to eight suffice
constexpr double kSmallStep = 1e-9;  // step [m, rad, s] below which a refinement has converged
// [-] Largest number of hypotheses, each from two pairs. With 30 % false sightings, half of the hypotheses are right.
// Larger values tolerate more false sightings and take longer.
constexpr int kMaxHypotheses = 400;
// [-] Residual in standard deviations beyond which a pair is a false sighting once the fit has converged. Larger values
// let false sightings into the result.
constexpr double kPairGate_sigma = 3.5;
constexpr double kKnownClock_s = 1e-9;  // clock sigma that counts as exact
// Information of the clock prior in the normal equations; a known clock is not estimated.
double clock_information(const ClockPrior& clock) {
  const double sigma_s = std::max(clock.sigma_s, kKnownClock_s);
  return 1.0 / (sigma_s * sigma_s);
}

Matrix3 turn_about_z(double yaw_rad) {
  const double s = elementary::sin(yaw_rad), c = elementary::cos(yaw_rad);
  return (Matrix3() << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0).finished();
}

/// z x v: derivative of v by a rotation about the vertical.
Vector3 z_cross(const Vector3& v) { return {-v.y(), v.x(), 0.0}; }

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * kPi); }

/// Weight of a residual of the given squared standard deviations by Cauchy's loss, and its cost.
double weight_of(double scale, double squared) { return 1.0 / (1.0 + squared / (scale * scale)); }

double cost_of(double scale, double squared) {
  const double k2 = scale * scale;
  return k2 * elementary::log(1.0 + squared / k2);
}

}  // namespace

Pose FrameAlignment::T_local_other() const {
  Pose T = Pose::Identity();
  T.linear() = turn_about_z(yaw_rad);
  T.translation() = point(Vector3::Zero());
  return T;
}

Vector3 FrameAlignment::point(const Vector3& p_other_m) const {
  return anchor_local_m + turn_about_z(yaw_rad) * (p_other_m - anchor_other_m);
}

std::optional<FrameAlignment> align_in_closed_form(std::span<const Vector3> p_local_m,
                                                   std::span<const Vector3> p_other_m,
                                                   std::span<const double> weights) {
  ENSURE(p_local_m.size() == p_other_m.size() && p_local_m.size() == weights.size(), p_local_m.size(), p_other_m.size(),
         weights.size());
  FrameAlignment out;
  double sum = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    out.anchor_local_m += weights[i] * p_local_m[i];
    out.anchor_other_m += weights[i] * p_other_m[i];
    sum += weights[i];
  }
  if (!(sum > 0.0)) return std::nullopt;
  out.anchor_local_m /= sum;
  out.anchor_other_m /= sum;
  // The heading maximizes sum w q . R p = cos(yaw) dot + sin(yaw) cross of the horizontal parts.
  double dot = 0.0, cross = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const Vector3 p = p_other_m[i] - out.anchor_other_m, q = p_local_m[i] - out.anchor_local_m;
    dot += weights[i] * (p.x() * q.x() + p.y() * q.y());
    cross += weights[i] * (p.x() * q.y() - p.y() * q.x());
  }
  if (!(elementary::hypot(dot, cross) > 0.0)) return std::nullopt;
  out.yaw_rad = elementary::atan2(cross, dot);
  return out;
}

RelativeAlignment::RelativeAlignment(const RelativeAlignmentConfig& config, const OdometryDriftConfig& drift)
    : config_(config), drift_(drift) {
  pairs_.reserve(config.window_size);
}

void RelativeAlignment::push(const AlignmentPair& pair) {
  const bool rests =
      pairs_.size() >= 2 && pair.flown.path_m - pairs_[pairs_.size() - 2].flown.path_m < config_.window_step_m;
  if (rests) {
    pairs_.back() = pair;
    return;
  }
  if (static_cast<int>(pairs_.size()) == config_.window_size) pairs_.erase(pairs_.begin());
  pairs_.push_back(pair);
}

void RelativeAlignment::clear() {
  pairs_.clear();
  result_.reset();
  fault_ = AlignmentFault::kFewPairs;
  num_inliers_ = 0;
}

const std::optional<FrameAlignment>& RelativeAlignment::fit(const OtherMotion& anchor, const ClockPrior& clock) {
  anchor_other_m_ = anchor.p_other_local_m;
  clock_ = clock;
  num_inliers_ = 0;
  fault_ = AlignmentFault::kFewPairs;
  const std::optional<FrameAlignment> last = result_;
  result_.reset();
  if (num_pairs() < config_.min_pairs) return result_;
  weigh(anchor);

  std::optional<Guess> guess;
  if (last) {
    guess = refine({last->point(anchor_other_m_), last->yaw_rad, last->clock_s}, true);
    take_inliers(*guess);
    if (inlier_share() < config_.min_inlier_share) guess.reset();
  }
  if (!guess) {
    guess = global_start();
    if (!guess) {
      fault_ = AlignmentFault::kNoSpread;
      return result_;
    }
    guess = refine(*guess, true);
    take_inliers(*guess);
  }
  // Inliers have full weight, so that the covariance is that of least squares.
  guess = refine(*guess, false);
  take_inliers(*guess);

  FrameAlignment found;
  found.anchor_other_m = anchor_other_m_;
  found.anchor_local_m = guess->anchor_local_m;
  found.yaw_rad = wrapped(guess->yaw_rad);
  found.clock_s = guess->clock_s;
  const Matrix5 C = covariance(*guess, anchor);
  found.covariance = C.topLeftCorner<4, 4>();
  found.clock_sigma_s = std::sqrt(std::max(0.0, C(4, 4)));
  fault_ = fault_of(found, *guess);
  if (fault_ == AlignmentFault::kNone) result_ = found;
  return result_;
}

Vector3 RelativeAlignment::residual(const AlignmentPair& pair, const Guess& guess) const {
  const Vector3 reported_m = pair.p_other_m + (guess.clock_s - pair.clock_s) * -pair.v_other_mps;
  return pair.p_local_m - guess.anchor_local_m - turn_about_z(guess.yaw_rad) * (reported_m - anchor_other_m_);
}

/// Derivative of the residual by anchor, heading and clock.
RelativeAlignment::Matrix35 RelativeAlignment::jacobian(const AlignmentPair& pair, const Guess& guess) const {
  const Matrix3 R = turn_about_z(guess.yaw_rad);
  const Vector3 reported_m = pair.p_other_m + (guess.clock_s - pair.clock_s) * -pair.v_other_mps;
  Matrix35 J;
  J.leftCols<3>() = -Matrix3::Identity();
  J.col(3) = -z_cross(R * (reported_m - anchor_other_m_));
  J.col(4) = R * pair.v_other_mps;
  return J;
}

double RelativeAlignment::squared_sigmas(std::size_t i, const Guess& guess) const {
  const Vector3 r = residual(pairs_[i], guess);
  return r.dot(information_[i] * r);
}

/// Weights each pair by the covariance of its sighting and the drift of the odometry since then. The drift is taken as
/// equal along all axes: weights need not be exact.
void RelativeAlignment::weigh(const OtherMotion& anchor) {
  information_.clear();
  for (const AlignmentPair& pair : pairs_) {
    const Flown since = anchor.flown - pair.flown;
    const double lever_sq = (pair.p_other_m - anchor_other_m_).head<2>().squaredNorm();
    const double drift =
        drift_factor_ * (drift_.position_variance_m2(since) + drift_.yaw_variance_rad2(since) * lever_sq / 3.0);
    information_.push_back((pair.covariance + drift * Matrix3::Identity()).inverse());
  }
}

/// Two distant pairs define an alignment; the hypothesis that most pairs fit is kept.
std::optional<RelativeAlignment::Guess> RelativeAlignment::global_start() const {
  const std::size_t count = pairs_.size();
  double widest_sq = 0.0;
  for (const AlignmentPair& pair : pairs_) {
    widest_sq = std::max(widest_sq, (pair.p_other_m - pairs_.front().p_other_m).head<2>().squaredNorm());
  }
  const double apart_m = 0.5 * std::sqrt(widest_sq);
  const double gate_sq = kPairGate_sigma * kPairGate_sigma;
  std::optional<Guess> best;
  double least = std::numeric_limits<double>::infinity();
  int num_hypotheses = 0;
  // Pairs with partners at decreasing distances in the window, beginning with half of it.
  for (std::size_t offset = (count + 1) / 2; offset >= 1 && num_hypotheses < kMaxHypotheses; --offset) {
    for (std::size_t i = 0; i + offset < count && num_hypotheses < kMaxHypotheses; ++i) {
      const AlignmentPair &a = pairs_[i], &b = pairs_[i + offset];
      const Vector3 reported_m = b.p_other_m - a.p_other_m, seen_m = b.p_local_m - a.p_local_m;
      const double reported = reported_m.head<2>().norm(), seen = seen_m.head<2>().norm();
      if (!(reported >= apart_m && reported > 0.0 && seen > 0.0)) continue;
      const double sigma_m = std::sqrt(3.0 / information_[i].trace() + 3.0 / information_[i + offset].trace());
      if (std::abs(reported - seen) > kPairGate_sigma * sigma_m) continue;  // one of the two is an outlier
      ++num_hypotheses;
      Guess guess;
      guess.clock_s = clock_.clock_s;
      guess.yaw_rad = elementary::atan2(seen_m.y(), seen_m.x()) - elementary::atan2(reported_m.y(), reported_m.x());
      guess.anchor_local_m = 0.5 * (a.p_local_m + b.p_local_m) -
                             turn_about_z(guess.yaw_rad) * (0.5 * (a.p_other_m + b.p_other_m) - anchor_other_m_);
      double sum = 0.0;
      for (std::size_t k = 0; k < count && sum < least; ++k) sum += std::min(squared_sigmas(k, guess), gate_sq);
      if (sum >= least) continue;
      least = sum;
      best = guess;
    }
  }
  if (!best) return std::nullopt;

  // Fits all inliers together.
  local_.clear();
  other_.clear();
  weights_.clear();
  for (std::size_t k = 0; k < count; ++k) {
    if (squared_sigmas(k, *best) > gate_sq) continue;
    local_.push_back(pairs_[k].p_local_m);
    other_.push_back(pairs_[k].p_other_m);
    weights_.push_back(information_[k].trace());
  }
  if (const auto together = align_in_closed_form(local_, other_, weights_); together && local_.size() >= 3) {
    best->yaw_rad = together->yaw_rad;
    best->anchor_local_m = together->point(anchor_other_m_);
  }
  return best;
}

/// @param robust  true: all pairs, weighted by the loss; false: inliers by least squares
RelativeAlignment::Guess RelativeAlignment::refine(Guess guess, bool robust) const {
  double damping = 1e-6;
  double now = cost(guess, robust);
  for (int step = 0; step < kMaxSteps; ++step) {
    Matrix5 H = Matrix5::Zero();
    Vector5 g = Vector5::Zero();
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (!robust && !inlier_[i]) continue;
      const Vector3 r = residual(pairs_[i], guess);
      const Matrix35 J = jacobian(pairs_[i], guess);
      const double w = robust ? weight_of(config_.loss_scale, r.dot(information_[i] * r)) : 1.0;
      const Matrix35 WJ = w * (information_[i] * J);
      H += J.transpose() * WJ;
      g += WJ.transpose() * r;
    }
    H(4, 4) += clock_information(clock_);
    g(4) += clock_information(clock_) * (guess.clock_s - clock_.clock_s);

    Vector5 move = Vector5::Zero();
    bool better = false;
    for (int attempt = 0; attempt < 8 && !better; ++attempt) {
      Matrix5 damped = H;
      damped.diagonal() += damping * H.diagonal();
      move = damped.ldlt().solve(-g);
      if (!move.allFinite()) return guess;
      const Guess next{guess.anchor_local_m + move.head<3>(), guess.yaw_rad + move(3), guess.clock_s + move(4)};
      const double then = cost(next, robust);
      better = then <= now;
      damping = better ? damping * 0.1 : damping * 10.0;
      if (!better) continue;
      guess = next;
      now = then;
    }
    if (!better || move.cwiseAbs().maxCoeff() < kSmallStep) break;
  }
  return guess;
}

double RelativeAlignment::cost(const Guess& guess, bool robust) const {
  const double clock_off_s = guess.clock_s - clock_.clock_s;
  double sum = clock_information(clock_) * clock_off_s * clock_off_s;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (!robust && !inlier_[i]) continue;
    const double squared = squared_sigmas(i, guess);
    sum += robust ? cost_of(config_.loss_scale, squared) : squared;
  }
  return sum;
}

void RelativeAlignment::take_inliers(const Guess& guess) {
  const double gate_sq = kPairGate_sigma * kPairGate_sigma;
  inlier_.assign(pairs_.size(), 0);
  num_inliers_ = 0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    inlier_[i] = squared_sigmas(i, guess) <= gate_sq;
    num_inliers_ += inlier_[i];
  }
}

double RelativeAlignment::inlier_share() const {
  return static_cast<double>(num_inliers_) / static_cast<double>(pairs_.size());
}

double RelativeAlignment::spread_m() const {
  Vector3 mean_m = Vector3::Zero();
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (inlier_[i]) mean_m += pairs_[i].p_other_m / num_inliers_;
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (inlier_[i]) sum += (pairs_[i].p_other_m - mean_m).head<2>().squaredNorm();
  }
  return std::sqrt(sum / num_inliers_);
}

/// Covariance of the weighted least squares under its true noise: errors of sightings are independent, but each
/// drifting step of the odometry moves and rotates all earlier pairs together. A is the derivative of the result by a
/// pair, so sums of A over the pairs before a step suffice.
RelativeAlignment::Matrix5 RelativeAlignment::covariance(const Guess& guess, const OtherMotion& now) const {
  Matrix5 H = Matrix5::Zero();
  H(4, 4) += clock_information(clock_);
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (!inlier_[i]) continue;
    const Matrix35 J = jacobian(pairs_[i], guess);
    H += J.transpose() * (information_[i] * J);
  }
  const Matrix5 H_inverse = H.ldlt().solve(Matrix5::Identity());
  const Matrix3 R = turn_about_z(guess.yaw_rad);

  Matrix5 C = clock_information(clock_) * H_inverse.col(4) * H_inverse.col(4).transpose();
  Eigen::Matrix<double, 5, 3> A_before = Eigen::Matrix<double, 5, 3>::Zero();
  Vector5 turned_before = Vector5::Zero();  // sum of A (z x R p), about the anchor
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (inlier_[i]) {
      const Eigen::Matrix<double, 5, 3> A = H_inverse * jacobian(pairs_[i], guess).transpose() * information_[i];
      C += A * pairs_[i].covariance * A.transpose();
      A_before += A;
      turned_before += A * z_cross(R * (pairs_[i].p_other_m - anchor_other_m_));
    }
    const bool last = i + 1 == pairs_.size();
    const Flown step = (last ? now.flown : pairs_[i + 1].flown) - pairs_[i].flown;
    const Vector3 next_m = last ? now.p_other_local_m : pairs_[i + 1].p_other_m;
    const Vector3 middle_m = 0.5 * (pairs_[i].p_other_m + next_m) - anchor_other_m_;
    const Vector5 turned = turned_before - A_before * z_cross(R * middle_m);
    C += drift_factor_ * drift_.position_variance_m2(step) * A_before * A_before.transpose();
    C += drift_factor_ * drift_.yaw_variance_rad2(step) * turned * turned.transpose();
  }
  return 0.5 * (C + C.transpose());
}

/// RMS per axis; 1 when the covariances are correct.
double RelativeAlignment::residual_sigma(const Guess& guess) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (inlier_[i]) sum += squared_sigmas(i, guess);
  }
  return std::sqrt(sum / (3.0 * num_inliers_));
}

AlignmentFault RelativeAlignment::fault_of(const FrameAlignment& found, const Guess& guess) const {
  if (num_inliers_ < config_.min_pairs || inlier_share() < config_.min_inlier_share) return AlignmentFault::kFewInliers;
  if (residual_sigma(guess) > config_.residual_sigma_max) return AlignmentFault::kFewInliers;
  if (spread_m() < config_.min_spread_m) return AlignmentFault::kNoSpread;
  const double sigma_max_rad = config_.heading_sigma_max_deg * kRadPerDeg;
  if (!(found.covariance(3, 3) <= sigma_max_rad * sigma_max_rad)) return AlignmentFault::kUncertainHeading;
  return AlignmentFault::kNone;
}

}  // namespace swiftlet
