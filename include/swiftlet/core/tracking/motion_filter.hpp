// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/base/track.hpp"

namespace swiftlet {

using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

/// Gaussian state of a moving point, eq. (26) of Vrba 2025: position, velocity and acceleration [m, m/s, m/s^2] in the
/// local frame.
struct MotionBelief {
  Vector9 mean = Vector9::Zero();
  Matrix9 covariance = Matrix9::Identity();

  Vector3 position() const { return mean.head<3>(); }
  Vector3 velocity() const { return mean.segment<3>(3); }
  Matrix3 position_covariance() const { return covariance.topLeftCorner<3, 3>(); }
};

/// Filter state of one target. A filter with several motion models also has one state and one probability per model;
/// `belief` then is the mean and covariance of their mixture.
struct MotionState {
  MotionBelief belief;
  std::array<MotionBelief, TrackModes::kModels> modes;
  std::array<double, TrackModes::kModels> mode_probability{1.0, 0.0, 0.0};
};

/// Standard deviations per axis of the process noise in one step of `period_s`, eq. (34). Larger values follow
/// maneuvers sooner and smooth less.
struct ProcessNoise {
  double sigma_position_m = 0.01;
  double sigma_velocity_mps = 0.2;
  double sigma_acceleration_mps2 = 0.3;

  void visit(ConfigVisitor& v);
  /// Covariance of a step of dt_s. The variance is proportional to time, so that two half steps equal one step. With a
  /// period of 0 every step adds the same covariance, as printed in the paper.
  Matrix9 covariance(double dt_s, double period_s) const;
};

/// Filter for the motion of a target. Stateless: one filter serves all targets.
class MotionFilter {
 public:
  virtual ~MotionFilter() = default;
  /// True when the filter has several models, in the order of TrackModes::Model.
  virtual bool has_modes() const { return false; }
  /// State of a new target, with zero velocity and acceleration, eqs. (35) and (36).
  virtual MotionState start(const Vector3& position_local_m, const Matrix3& position_covariance) const = 0;
  virtual void predict(MotionState& state, double dt_s) const = 0;
  /// Corrects the state by a measured position z = H x + noise of covariance Z, eqs. (32) and (33).
  virtual void correct(MotionState& state, const Vector3& z_local_m, const Matrix3& Z) const = 0;
};

/// Standard deviations per axis of the velocity and acceleration of a new target, of which only a position is measured,
/// eq. (36). Larger values accept faster targets, whose first predictions are less certain.
struct InitialSpread {
  double sigma_velocity_mps = 1.0;
  double sigma_acceleration_mps2 = 1.0;

  void visit(ConfigVisitor& v);
  MotionBelief at_rest(const Vector3& position_local_m, const Matrix3& position_covariance) const;
};

/// Kalman filter of Vrba 2025 with constant acceleration, eqs. (30)-(34).
struct KalmanConfig {
  ProcessNoise process;
  double process_period_s = 0.1;  ///< as in ProcessNoise::covariance
  InitialSpread initial;

  void visit(ConfigVisitor& v);
};
std::unique_ptr<MotionFilter> make_kalman_filter(const KalmanConfig& config);

/// Interacting multiple models (Blom and Bar-Shalom, IEEE TAC 33(8), 1988):
/// - constant velocity;
/// - constant acceleration (eq. 30);
/// - coordinated turn in the plane of velocity and acceleration, at the estimate's rate |v x a| / |v|^2 (Li and Jilkov,
///   IEEE TAES 39(4), 2003, sec. V-B).
struct ImmConfig {
  double process_period_s = 0.1;  ///< as in ProcessNoise::covariance
  InitialSpread initial;

  void visit(ConfigVisitor& v);
};
std::unique_ptr<MotionFilter> make_imm_filter(const ImmConfig& config);

// Components, also for tests and custom filters. Transition matrices are for position, velocity and acceleration.
Matrix9 constant_velocity_transition(double dt_s);      ///< the acceleration becomes zero
Matrix9 constant_acceleration_transition(double dt_s);  ///< A of eq. (30)
Matrix9 coordinated_turn_transition(double dt_s, double rate_radps);
/// |v x a| / |v|^2, limited; 0 at low speed, where the direction of the velocity is uncertain.
double turn_rate_radps(const Vector9& mean);
/// Kalman correction by a measured position with covariance Z. Returns the log-likelihood of the measurement.
double correct_belief(MotionBelief& belief, const Vector3& z_local_m, const Matrix3& Z);

}  // namespace swiftlet
