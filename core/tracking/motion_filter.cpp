// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/tracking/motion_filter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/ordered_product.hpp"

namespace swiftlet {
namespace {

// Rotation below which a turn counts as a straight line; its closed form would divide by zero.
constexpr double kMinTurn_rad = 1e-4;
// Speed below which direction and turn rate are noise, and the largest plausible turn rate.
constexpr double kMinSpeed_mps = 0.5;
constexpr double kGreatestRate_radps = 4.0;

/// [-] Lower bound of the probability of a mode. At 0 a mode could not become likely again.
constexpr double kMinProbability = 1e-6;

/// Process noise of each motion model in a step of process_period_s [m, m/s, m/s^2]. Larger values follow turns sooner
/// and smooth less.
constexpr ProcessNoise kConstantVelocityNoise{0.01, 0.05, 0.05};
constexpr ProcessNoise kConstantAccelerationNoise{0.01, 0.2, 0.6};
constexpr ProcessNoise kCoordinatedTurnNoise{0.01, 0.05, 0.15};
/// [s] Mean time until a target changes its motion model. Smaller values change the model sooner, and by chance too.
constexpr double kMeanSojourn_s = 2.0;

/// [[aI, bI, cI], [0, dI, eI], [0, fI, gI]] on position, velocity, acceleration; the first column is always (I, 0, 0).
Matrix9 transition(double position_velocity, double position_acceleration, double velocity_velocity,
                   double velocity_acceleration, double acceleration_velocity, double acceleration_acceleration) {
  Matrix9 A = Matrix9::Zero();
  A.block<3, 3>(0, 0).setIdentity();
  A.block<3, 3>(0, 3).diagonal().setConstant(position_velocity);
  A.block<3, 3>(0, 6).diagonal().setConstant(position_acceleration);
  A.block<3, 3>(3, 3).diagonal().setConstant(velocity_velocity);
  A.block<3, 3>(3, 6).diagonal().setConstant(velocity_acceleration);
  A.block<3, 3>(6, 3).diagonal().setConstant(acceleration_velocity);
  A.block<3, 3>(6, 6).diagonal().setConstant(acceleration_acceleration);
  return A;
}

void predict_belief(MotionBelief& belief, const Matrix9& A, const Matrix9& Xi) {
  belief.mean = A * belief.mean;
  belief.covariance = propagated(A, belief.covariance) + Xi;
}

class KalmanFilter : public MotionFilter {
 public:
  explicit KalmanFilter(const KalmanConfig& config) : config_(config) {}

  MotionState start(const Vector3& position_local_m, const Matrix3& position_covariance) const override {
    MotionState state;
    state.belief = config_.initial.at_rest(position_local_m, position_covariance);
    return state;
  }
  void predict(MotionState& state, double dt_s) const override {
    predict_belief(state.belief, constant_acceleration_transition(dt_s),
                   config_.process.covariance(dt_s, config_.process_period_s));
  }
  void correct(MotionState& state, const Vector3& z_local_m, const Matrix3& Z) const override {
    correct_belief(state.belief, z_local_m, Z);
  }

 private:
  KalmanConfig config_;
};

class ImmFilter : public MotionFilter {
 public:
  explicit ImmFilter(const ImmConfig& config) : config_(config) {}
  bool has_modes() const override { return true; }

  MotionState start(const Vector3& position_local_m, const Matrix3& position_covariance) const override {
    MotionState state;
    state.belief = config_.initial.at_rest(position_local_m, position_covariance);
    state.modes.fill(state.belief);
    state.mode_probability.fill(1.0 / kModes);
    return state;
  }

  void predict(MotionState& state, double dt_s) const override {
    mix(state, dt_s);
    const double period_s = config_.process_period_s;
    predict_belief(state.modes[0], constant_velocity_transition(dt_s),
                   kConstantVelocityNoise.covariance(dt_s, period_s));
    predict_belief(state.modes[1], constant_acceleration_transition(dt_s),
                   kConstantAccelerationNoise.covariance(dt_s, period_s));
    const double rate_radps = turn_rate_radps(state.modes[2].mean);
    predict_belief(state.modes[2], coordinated_turn_transition(dt_s, rate_radps),
                   kCoordinatedTurnNoise.covariance(dt_s, period_s));
    combine(state);
  }

  void correct(MotionState& state, const Vector3& z_local_m, const Matrix3& Z) const override {
    std::array<double, kModes> log_likelihood{};
    for (int m = 0; m < kModes; ++m) log_likelihood[m] = correct_belief(state.modes[m], z_local_m, Z);
    const double greatest = *std::max_element(log_likelihood.begin(), log_likelihood.end());
    double sum = 0.0;
    for (int m = 0; m < kModes; ++m) {
      double& p = state.mode_probability[m];
      p = std::max(kMinProbability, p * elementary::exp(log_likelihood[m] - greatest));
      sum += p;
    }
    for (double& p : state.mode_probability) p /= sum;
    combine(state);
  }

 private:
  static constexpr int kModes = TrackModes::kModels;

  // Modes switch at a constant rate, to any other mode alike: the chain has a closed form.
  static void mix(MotionState& state, double dt_s) {
    const double leave_rate = 1.0 / kMeanSojourn_s * kModes / (kModes - 1);
    const double stay = 1.0 / kModes + (1.0 - 1.0 / kModes) * elementary::exp(-leave_rate * dt_s);
    const double change = (1.0 - stay) / (kModes - 1);
    const auto old_modes = state.modes;
    const auto old_probability = state.mode_probability;
    for (int m = 0; m < kModes; ++m) {
      std::array<double, kModes> weight{};
      double sum = 0.0;
      for (int from = 0; from < kModes; ++from) {
        weight[from] = (from == m ? stay : change) * old_probability[from];
        sum += weight[from];
      }
      for (double& w : weight) w /= sum;
      state.mode_probability[m] = sum;
      state.modes[m] = moments(old_modes, weight);
    }
  }

  static void combine(MotionState& state) { state.belief = moments(state.modes, state.mode_probability); }

  /// Mean and covariance of a mixture.
  static MotionBelief moments(const std::array<MotionBelief, kModes>& parts, const std::array<double, kModes>& weight) {
    MotionBelief out;
    out.mean.setZero();
    out.covariance.setZero();
    for (int m = 0; m < kModes; ++m) out.mean += weight[m] * parts[m].mean;
    for (int m = 0; m < kModes; ++m) {
      const Vector9 d = parts[m].mean - out.mean;
      out.covariance += weight[m] * (parts[m].covariance + d * d.transpose());
    }
    return out;
  }

  ImmConfig config_;
};

}  // namespace

void ProcessNoise::visit(ConfigVisitor& v) {
  v.field("sigma_position_m", sigma_position_m, "[m] Xi_r", Range::non_negative());
  v.field("sigma_velocity_mps", sigma_velocity_mps, "[m/s] Xi_v", Range::non_negative());
  v.field("sigma_acceleration_mps2", sigma_acceleration_mps2, "[m/s^2] Xi_a", Range::non_negative());
}

Matrix9 ProcessNoise::covariance(double dt_s, double period_s) const {
  const double steps = period_s > 0.0 ? dt_s / period_s : 1.0;
  Vector9 variance;
  variance << Vector3::Constant(sigma_position_m * sigma_position_m),
      Vector3::Constant(sigma_velocity_mps * sigma_velocity_mps),
      Vector3::Constant(sigma_acceleration_mps2 * sigma_acceleration_mps2);
  return (steps * variance).asDiagonal();
}

void InitialSpread::visit(ConfigVisitor& v) {
  v.field("sigma_velocity_mps", sigma_velocity_mps, "[m/s] P_0,v", Range::positive());
  v.field("sigma_acceleration_mps2", sigma_acceleration_mps2,
          "[m/s^2] P_0,a: standard deviation of the acceleration of a new track", Range::positive());
}

MotionBelief InitialSpread::at_rest(const Vector3& position_local_m, const Matrix3& position_covariance) const {
  MotionBelief belief;
  belief.mean.setZero();
  belief.mean.head<3>() = position_local_m;
  belief.covariance.setZero();
  belief.covariance.topLeftCorner<3, 3>() = position_covariance;
  belief.covariance.diagonal().segment<3>(3).setConstant(sigma_velocity_mps * sigma_velocity_mps);
  belief.covariance.diagonal().tail<3>().setConstant(sigma_acceleration_mps2 * sigma_acceleration_mps2);
  return belief;
}

void KalmanConfig::visit(ConfigVisitor& v) {
  v.object("process", process, "process noise: standard deviations added in a step of process_period_s");
  v.field(
      "process_period_s", process_period_s,
      "[s] duration for which the process noise is given; the variance is proportional to time; 0: equal in every step",
      Range::non_negative());
  v.object("initial", initial, "standard deviations of velocity and acceleration of a new track");
}

void ImmConfig::visit(ConfigVisitor& v) {
  v.field(
      "process_period_s", process_period_s,
      "[s] duration for which the process noise is given; the variance is proportional to time; 0: equal in every step",
      Range::non_negative());
  v.object("initial", initial, "standard deviations of velocity and acceleration of a new track");
}

std::unique_ptr<MotionFilter> make_kalman_filter(const KalmanConfig& config) {
  return std::make_unique<KalmanFilter>(config);
}

std::unique_ptr<MotionFilter> make_imm_filter(const ImmConfig& config) { return std::make_unique<ImmFilter>(config); }

Matrix9 constant_velocity_transition(double dt_s) { return transition(dt_s, 0.0, 1.0, 0.0, 0.0, 0.0); }

Matrix9 constant_acceleration_transition(double dt_s) {
  return transition(dt_s, 0.5 * dt_s * dt_s, 1.0, dt_s, 0.0, 1.0);
}

// Velocity and acceleration rotate at the rate w: a' = -w^2 v.
Matrix9 coordinated_turn_transition(double dt_s, double rate_radps) {
  const double w = rate_radps, angle = w * dt_s;
  if (std::abs(angle) < kMinTurn_rad) return constant_acceleration_transition(dt_s);
  const double s = elementary::sin(angle), c = elementary::cos(angle);
  return transition(s / w, (1.0 - c) / (w * w), c, s / w, -w * s, c);
}

double turn_rate_radps(const Vector9& mean) {
  const Vector3 v = mean.segment<3>(3), a = mean.tail<3>();
  const double speed_sq = v.squaredNorm();
  if (!(speed_sq > kMinSpeed_mps * kMinSpeed_mps)) return 0.0;
  return std::min(v.cross(a).norm() / speed_sq, kGreatestRate_radps);
}

double correct_belief(MotionBelief& belief, const Vector3& z_local_m, const Matrix3& Z) {
  const Matrix3 S = belief.position_covariance() + Z;
  const Eigen::LLT<Matrix3> llt(S);
  if (llt.info() != Eigen::Success) return -std::numeric_limits<double>::max();  // the belief is no longer Gaussian
  const Vector3 innovation = z_local_m - belief.position();
  // K = P H^T S^-1, of the shape (9 x 3).
  const Eigen::Matrix<double, 9, 3> PHt = belief.covariance.leftCols<3>();
  const Eigen::Matrix<double, 9, 3> K = llt.solve(PHt.transpose()).transpose();
  belief.mean += K * innovation;
  // Joseph form: stays positive despite rounding.
  Matrix9 I_KH = Matrix9::Identity();
  I_KH.leftCols<3>() -= K;
  const Matrix9 P =
      propagated(I_KH, belief.covariance) + ordered_product(Eigen::Matrix<double, 9, 3>(K * Z), K.transpose());
  belief.covariance = 0.5 * (P + P.transpose());

  const Matrix3 L = llt.matrixL();
  const double log_det = 2.0 * elementary::log(L(0, 0) * L(1, 1) * L(2, 2));
  return -0.5 * (innovation.dot(llt.solve(innovation)) + log_det + 3.0 * elementary::log(2.0 * std::numbers::pi));
}

}  // namespace swiftlet
