// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/control/motion_limits.hpp"
#include "swiftlet/core/interception/intercept_config.hpp"

namespace swiftlet {

/// Half-space n^T p <= offset. Any frame, the same for all arguments.
struct Wall {
  Vector3 normal = Vector3::UnitX();  ///< unit length, points outward
  double offset_m = 0.0;

  double excess_m(const Vector3& p_m) const { return normal.dot(p_m) - offset_m; }
};

/// Position, velocity and acceleration of a point. Any frame, the same for all arguments.
struct PointState {
  Vector3 p_m = Vector3::Zero();
  Vector3 v_mps = Vector3::Zero();
  Vector3 a_mps2 = Vector3::Zero();

  /// State after `dt_s` of constant jerk.
  PointState after(const Vector3& jerk_mps3, double dt_s) const {
    return {p_m + dt_s * (v_mps + dt_s * (0.5 * a_mps2 + dt_s / 6.0 * jerk_mps3)),
            v_mps + dt_s * (a_mps2 + 0.5 * dt_s * jerk_mps3), a_mps2 + dt_s * jerk_mps3};
  }
};

/// Target state at the end of a step, and its weights in the cost. Any frame, the same for all arguments.
struct ChaseAim {
  /// [-] Maximum number of position constraints of a step. More of them cost time in every iteration.
  static constexpr int kMaxWalls = 4;
  Vector3 p_m = Vector3::Zero();
  Vector3 v_mps = Vector3::Zero();
  double weight = 1.0;           ///< weight of the squared distance [1/m^2]
  double velocity_weight = 0.0;  ///< weight of the squared velocity difference [s^2/m^2]
  int num_walls = 0;
  std::array<Wall, kMaxWalls> walls;  ///< position constraints at that time
};

/// Model predictive control of a point that tracks a moving target state within its motion limits.
///
/// The jerk is constant in each step. Velocity and acceleration depend linearly on it, so the jerks of all steps are
/// the only unknowns (the condensed problem):
///
///   minimize  1/2 sum_k w_k |p_k - aim_k|^2 + v_k |v_k - aim velocity_k|^2 + r |u_k|^2 / u_max^2
///             + 1/2 mu dist(p_k, walls_k)^2
///   such that jerk, acceleration and velocity keep the motion limits in each step.
///
/// Horizontal limits apply to the norm of the vector, so the sets are discs and intervals, with projections in closed
/// form. The alternating direction method of multipliers (Boyd et al., Found. Trends Mach. Learn. 3(1), 2011) solves
/// the problem: a product with one small matrix, sums and projections, for a bounded number of iterations. No
/// allocation, no clock: bit-identical results for equal inputs.
class ChaseMpc {
 public:
  /// [-] Maximum number of steps of a plan; capacity of the matrices.
  static constexpr int kMaxSteps = 40;

  ChaseMpc(const ChaseMpcConfig& config, const MotionLimits& limits, int num_steps);

  /// Computes the plan from `start`, in num_steps() steps of `step_s`.
  void solve(const PointState& start, std::span<const ChaseAim> aims, double step_s);
  /// Discards the last solution, so that the next solve() starts cold.
  void forget() { warm_ = false; }

  int num_steps() const { return num_steps_; }
  const Vector3& jerk_mps3(int step) const { return jerks_[static_cast<std::size_t>(step)]; }
  /// State of the plan at a time after its beginning; continues at its last velocity after its end.
  PointState at(double t_s) const;
  double step_s() const { return step_s_; }
  /// Largest difference between a state and its projection, relative to its limit.
  double residual() const { return residual_; }

 private:
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxSteps, kMaxSteps>;
  using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxSteps, 1>;
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxSteps, 3>;

  /// Problem of the horizontal or the vertical axes.
  struct Axes {
    double speed = 1.0, acceleration = 1.0, jerk = 1.0;  // motion limits
    Matrix cost;                                         // Hessian
    Matrix constraints;                                  // sum of the blocks' A^T A, weighted
    Matrix inverse;                                      // inverse of cost + rho constraints
  };
  /// Constrained quantity A u + free, its projection, and the scaled multiplier; in units of its limit.
  struct Block {
    Columns free, value, projected, multiplier;
    std::array<double, 3> per_unit{1.0, 1.0, 1.0};  // limit along each axis
  };
  enum { kJerk, kAcceleration, kVelocity, kPosition, kBlocks };

  void set_up(const PointState& start, std::span<const ChaseAim> aims, double step_s);
  void set_responses();
  void set_cost(const PointState& start, std::span<const ChaseAim> aims);
  void factor();
  void update_jerks();
  void respond(Columns& position, Columns& velocity, Columns& acceleration) const;
  void add_adjoint(const Columns& of_position, const Columns& of_velocity, const Columns& of_acceleration,
                   Columns& sum) const;
  void project(std::span<const ChaseAim> aims);
  bool change_rho();

  ChaseMpcConfig config_;
  int num_steps_;
  double step_s_ = 0.0;
  Axes horizontal_, vertical_;
  Matrix position_of_, velocity_of_, acceleration_of_;  // response to unit jerks
  std::array<Block, kBlocks> blocks_;
  bool has_walls_ = false;
  Columns gradient_, u_;
  double rho_ = 1.0, primal_ = 0.0, dual_ = 0.0;
  double residual_ = 0.0;
  bool warm_ = false;
  std::array<Vector3, kMaxSteps> jerks_;
  std::array<PointState, kMaxSteps + 1> states_;
};

}  // namespace swiftlet
