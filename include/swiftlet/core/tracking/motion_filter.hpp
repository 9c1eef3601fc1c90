// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

/// State of a moving point, eq. (26) of Vrba 2025: position, velocity, acceleration [m, m/s, m/s^2], local frame.
struct MotionBelief {
  Vector9 mean = Vector9::Zero();
  Matrix9 covariance = Matrix9::Identity();

  Vector3 position() const { return mean.head<3>(); }
  Vector3 velocity() const { return mean.segment<3>(3); }
  Matrix3 position_covariance() const { return covariance.topLeftCorner<3, 3>(); }
};

/// Filter state of one target: the mixture, and the beliefs of the single motion models if there are several. A value
/// type.
struct MotionState {
  /// [-] Most motion models of a filter.
  static constexpr int kMaxModes = 3;
  MotionBelief belief;
  std::array<MotionBelief, kMaxModes> modes;
  std::array<double, kMaxModes> mode_probability{1.0, 0.0, 0.0};
};

/// Standard deviations of the process noise of one step of `period_s`, eq. (34).
struct ProcessNoise {
  double sigma_position_m = 0.01;
  double sigma_velocity_mps = 0.2;
  double sigma_acceleration_mps2 = 0.3;

  void visit(ConfigVisitor& v);
  /// Covariance for a step of another length: variance is proportional to time, so that two half steps equal one step.
  /// With a period of 0, every step adds the same covariance, as printed.
  Matrix9 covariance(double dt_s, double period_s) const;
};

/// Predicts and corrects beliefs; stateless.
class MotionFilter {
 public:
  virtual ~MotionFilter() = default;
  /// True when the filter has several models, in the order of TrackModes::Model.
  virtual bool has_modes() const { return false; }
  /// Initial state at rest, eqs. (35) and (36).
  virtual MotionState start(const Vector3& position_local_m, const Matrix3& position_covariance) const = 0;
  virtual void predict(MotionState& state, double dt_s) const = 0;
  /// Corrects by a measured position z = H x + noise of covariance Z, eqs. (32) and (33).
  virtual void correct(MotionState& state, const Vector3& z_local_m, const Matrix3& Z) const = 0;
};

/// Initial standard deviations of velocity and acceleration of a target with known position only, eq. (36).
struct InitialSpread {
  double sigma_velocity_mps = 1.0;
  double sigma_acceleration_mps2 = 1.0;

  void visit(ConfigVisitor& v);
  MotionBelief at_rest(const Vector3& position_local_m, const Matrix3& position_covariance) const;
};

/// The document's Kalman filter with constant acceleration, eqs. (30)-(34).
struct KalmanConfig {
  ProcessNoise process;
  double process_period_s = 0.1;
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
  double process_period_s = 0.1;
  InitialSpread initial;

  void visit(ConfigVisitor& v);
};
std::unique_ptr<MotionFilter> make_imm_filter(const ImmConfig& config);

// Components, for tests and custom filters.
Matrix9 constant_velocity_transition(double dt_s);      ///< zero acceleration
Matrix9 constant_acceleration_transition(double dt_s);  ///< A of eq. (30)
Matrix9 coordinated_turn_transition(double dt_s, double rate_radps);
double turn_rate_radps(const Vector9& mean);
/// Kalman correction by a position; returns the log-likelihood of the measurement.
double correct_belief(MotionBelief& belief, const Vector3& z_local_m, const Matrix3& Z);

}  // namespace swiftlet
