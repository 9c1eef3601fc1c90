// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/chase_mpc.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/ensure.hpp"

namespace swiftlet {
namespace {

/// Settings of the alternating direction method of multipliers [Boyd et al. 2011, sec. 3.4.1 and 3.4.3]. With these,
/// 80 iterations end within 0.5 % of the least cost and 1 % of the limits.
struct SolverTuning {
  double over_relaxation = 1.6;  ///< [-] weight of the new iterate against the last projection; 1: none
  int check_period = 10;         ///< [-] iterations between checks of the residuals
  int wall_rounds = 2;           ///< [-] rounds of successive projections onto the walls of a step
  double unbalanced = 4.0;       ///< [-] ratio of the residuals beyond which rho changes
  double max_change = 10.0;      ///< [-] largest factor of one change of rho
  double max_rho = 1e8;          ///< [-] upper bound of rho; its inverse is the lower one
  double first_rho = 5.0;        ///< [-] first rho in relation to the scale of the cost
  std::array<double, 4> block_weight = {0.3, 1.0, 4.0, 0.1};  ///< [-] weight of each block's rho
};
constexpr SolverTuning kSolver;

Eigen::Map<const Vector3> along(const std::array<double, 3>& per_unit) {
  return Eigen::Map<const Vector3>(per_unit.data());
}

/// Projects onto a disc of radius 1 in the plane and an interval of 1 along the vertical.
void project_to_unit(auto&& row) {
  const double length_sq = row[0] * row[0] + row[1] * row[1];
  if (length_sq > 1.0) {
    const double scale = 1.0 / std::sqrt(length_sq);
    row[0] *= scale;
    row[1] *= scale;
  }
  row[2] = std::clamp(row[2], -1.0, 1.0);
}

/// Projection onto the walls; exact for one wall or walls at right angles, approximate for others.
Vector3 projected_to_walls(Vector3 p_m, const ChaseAim& aim) {
  for (int round = 0; round < kSolver.wall_rounds; ++round) {
    for (int i = 0; i < aim.num_walls; ++i) {
      const Wall& wall = aim.walls[static_cast<std::size_t>(i)];
      p_m -= std::max(wall.excess_m(p_m), 0.0) * wall.normal;
    }
    if (aim.num_walls < 2) break;
  }
  return p_m;
}

}  // namespace

ChaseMpc::ChaseMpc(const ChaseMpcConfig& config, const MotionLimits& limits, int num_steps)
    : config_(config), num_steps_(num_steps) {
  ENSURE(num_steps > 0 && num_steps <= kMaxSteps, num_steps);
  horizontal_.speed = limits.horizontal_speed_mps;
  horizontal_.acceleration = limits.horizontal_acceleration_mps2;
  horizontal_.jerk = limits.horizontal_jerk_mps3;
  vertical_.speed = limits.vertical_speed_mps;
  vertical_.acceleration = limits.vertical_acceleration_mps2;
  vertical_.jerk = limits.vertical_jerk_mps3;
  const auto per_unit = [&](double Axes::*limit) {
    return std::array{1.0 / horizontal_.*limit, 1.0 / horizontal_.*limit, 1.0 / vertical_.*limit};
  };
  blocks_[kJerk].per_unit = per_unit(&Axes::jerk);
  blocks_[kAcceleration].per_unit = per_unit(&Axes::acceleration);
  blocks_[kVelocity].per_unit = per_unit(&Axes::speed);
  position_of_.setZero(num_steps, num_steps);
  velocity_of_.setZero(num_steps, num_steps);
  acceleration_of_.setZero(num_steps, num_steps);
  u_.setZero(num_steps, 3);
  gradient_.setZero(num_steps, 3);
  for (Block& block : blocks_) {
    block.free.setZero(num_steps, 3);
    block.value = block.projected = block.multiplier = block.free;
  }
}

void ChaseMpc::solve(const PointState& start, std::span<const ChaseAim> aims, double step_s) {
  ENSURE(static_cast<int>(aims.size()) == num_steps_ && step_s > 0.0, aims.size(), num_steps_, step_s);
  set_up(start, aims, step_s);
  factor();
  int next_change = kSolver.check_period;
  for (int used = 1; used <= config_.iterations; ++used) {
    update_jerks();
    project(aims);
    if (used % kSolver.check_period != 0) continue;
    if (primal_ < config_.tolerance && dual_ < config_.tolerance) break;
    // At growing intervals: the method converges only with constant rho.
    if (used < next_change) continue;
    next_change *= 2;
    if (change_rho()) factor();
  }
  residual_ = primal_;
  warm_ = true;

  // The projected jerks keep their limit exactly.
  states_[0] = start;
  for (int k = 0; k < num_steps_; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Vector3 unit = blocks_[kJerk].projected.row(k).transpose();
    jerks_[i] = unit.cwiseQuotient(along(blocks_[kJerk].per_unit));
    states_[i + 1] = states_[i].after(jerks_[i], step_s);
  }
}

PointState ChaseMpc::at(double t_s) const {
  const double steps = t_s / step_s_;
  const int k = std::clamp(static_cast<int>(std::floor(steps)), 0, num_steps_);
  const PointState& from = states_[static_cast<std::size_t>(k)];
  const double beyond_s = t_s - k * step_s_;
  if (k == num_steps_) return {from.p_m + beyond_s * from.v_mps, from.v_mps, Vector3::Zero()};
  return from.after(jerks_[static_cast<std::size_t>(k)], beyond_s);
}

void ChaseMpc::set_up(const PointState& start, std::span<const ChaseAim> aims, double step_s) {
  if (step_s != step_s_) warm_ = false;
  step_s_ = step_s;
  set_responses();
  set_cost(start, aims);
  if (warm_) return;
  rho_ = kSolver.first_rho * horizontal_.cost.trace() / horizontal_.constraints.trace();
  for (Block& block : blocks_) {
    block.multiplier.setZero();
    block.projected = block.free;
    for (int k = 0; k < num_steps_ && &block != &blocks_[kPosition]; ++k) project_to_unit(block.projected.row(k));
  }
  u_.setZero();
}

void ChaseMpc::set_responses() {
  const double h = step_s_;
  for (int k = 0; k < num_steps_; ++k) {
    for (int i = 0; i <= k; ++i) {
      const double j = k - i;  // whole steps in between
      position_of_(k, i) = h * h * h / 6.0 * (1.0 + 3.0 * j + 3.0 * j * j);
      velocity_of_(k, i) = 0.5 * h * h * (2.0 * j + 1.0);
      acceleration_of_(k, i) = h;
    }
  }
}

void ChaseMpc::set_cost(const PointState& start, std::span<const ChaseAim> aims) {
  const int n = num_steps_;
  // Motion without jerk, and its deviation from the aim.
  has_walls_ = false;
  Columns missing_p(n, 3), missing_v(n, 3);
  Column weight(n), velocity_weight(n);
  for (int k = 0; k < n; ++k) {
    const ChaseAim& aim = aims[static_cast<std::size_t>(k)];
    const PointState free = start.after(Vector3::Zero(), (k + 1) * step_s_);
    missing_p.row(k) = (free.p_m - aim.p_m).transpose();
    missing_v.row(k) = (free.v_mps - aim.v_mps).transpose();
    weight[k] = aim.weight;
    velocity_weight[k] = aim.velocity_weight;
    blocks_[kAcceleration].free.row(k) = free.a_mps2.cwiseProduct(along(blocks_[kAcceleration].per_unit)).transpose();
    blocks_[kVelocity].free.row(k) = free.v_mps.cwiseProduct(along(blocks_[kVelocity].per_unit)).transpose();
    blocks_[kPosition].free.row(k) = free.p_m.transpose();
    has_walls_ = has_walls_ || aim.num_walls > 0;
  }

  Matrix weighted = weight.asDiagonal() * position_of_;
  Matrix hessian = position_of_.transpose().lazyProduct(weighted);
  Columns weighted_missing = weight.asDiagonal() * missing_p;
  gradient_ = position_of_.transpose().lazyProduct(weighted_missing);
  if (velocity_weight.maxCoeff() > 0.0) {
    weighted = velocity_weight.asDiagonal() * velocity_of_;
    hessian += velocity_of_.transpose().lazyProduct(weighted);
    weighted_missing = velocity_weight.asDiagonal() * missing_v;
    gradient_ += velocity_of_.transpose().lazyProduct(weighted_missing);
  }
  const Matrix of_position = position_of_.transpose().lazyProduct(position_of_);
  const Matrix of_velocity = velocity_of_.transpose().lazyProduct(velocity_of_);
  const Matrix of_acceleration = acceleration_of_.transpose().lazyProduct(acceleration_of_);
  for (Axes* axes : {&horizontal_, &vertical_}) {
    axes->cost = hessian;
    axes->cost.diagonal().array() += config_.jerk_weight / (axes->jerk * axes->jerk);
    axes->constraints =
        kSolver.block_weight[kVelocity] / (axes->speed * axes->speed) * of_velocity +
        kSolver.block_weight[kAcceleration] / (axes->acceleration * axes->acceleration) * of_acceleration;
    if (has_walls_) axes->constraints += kSolver.block_weight[kPosition] * of_position;
    axes->constraints.diagonal().array() += kSolver.block_weight[kJerk] / (axes->jerk * axes->jerk);
  }
}

void ChaseMpc::factor() {
  for (Axes* axes : {&horizontal_, &vertical_}) {
    const Matrix sum = axes->cost + rho_ * axes->constraints;
    axes->inverse.setIdentity(num_steps_, num_steps_);
    Eigen::LLT<Matrix> llt(sum);
    llt.solveInPlace(axes->inverse);
  }
}

void ChaseMpc::update_jerks() {
  const auto wanted = [&](int block) -> Columns {
    const Block& b = blocks_[static_cast<std::size_t>(block)];
    return kSolver.block_weight[static_cast<std::size_t>(block)] * (b.projected - b.multiplier - b.free) *
           along(b.per_unit).asDiagonal();
  };
  const Columns of_velocity = wanted(kVelocity), of_acceleration = wanted(kAcceleration);
  const Columns of_position = has_walls_ ? wanted(kPosition) : Columns::Zero(num_steps_, 3);
  Columns right = wanted(kJerk);
  add_adjoint(of_position, of_velocity, of_acceleration, right);
  right = rho_ * right - gradient_;
  u_.leftCols<2>() = horizontal_.inverse.lazyProduct(right.leftCols<2>());
  u_.col(2) = vertical_.inverse.lazyProduct(right.col(2));

  Block &jerk = blocks_[kJerk], &acceleration = blocks_[kAcceleration], &velocity = blocks_[kVelocity];
  respond(blocks_[kPosition].value, velocity.value, acceleration.value);
  jerk.value = u_ * along(jerk.per_unit).asDiagonal();
  acceleration.value = acceleration.free + acceleration.value * along(acceleration.per_unit).asDiagonal();
  velocity.value = velocity.free + velocity.value * along(velocity.per_unit).asDiagonal();
  if (has_walls_) blocks_[kPosition].value += blocks_[kPosition].free;
}

// Products with position_of_, velocity_of_ and acceleration_of_, as cumulative sums.
void ChaseMpc::respond(Columns& position, Columns& velocity, Columns& acceleration) const {
  const double h = step_s_;
  std::array<double, 3> p{}, v{}, a{};
  for (int k = 0; k < num_steps_; ++k) {
    for (int c = 0; c < 3; ++c) {
      const auto i = static_cast<std::size_t>(c);
      const double u = u_(k, c);
      p[i] += h * (v[i] + h * (0.5 * a[i] + h / 6.0 * u));
      v[i] += h * (a[i] + 0.5 * h * u);
      a[i] += h * u;
      position(k, c) = p[i];
      velocity(k, c) = v[i];
      acceleration(k, c) = a[i];
    }
  }
}

// Products with their transposes, backward in time.
void ChaseMpc::add_adjoint(const Columns& of_position, const Columns& of_velocity, const Columns& of_acceleration,
                           Columns& sum) const {
  const double h = step_s_;
  std::array<double, 3> p{}, v{}, a{};
  for (int k = num_steps_ - 1; k >= 0; --k) {
    for (int c = 0; c < 3; ++c) {
      const auto i = static_cast<std::size_t>(c);
      p[i] += of_position(k, c);
      v[i] += of_velocity(k, c);
      a[i] += of_acceleration(k, c);
      sum(k, c) += h * (a[i] + h * (0.5 * v[i] + h / 6.0 * p[i]));
      a[i] += h * (v[i] + 0.5 * h * p[i]);
      v[i] += h * p[i];
    }
  }
}

void ChaseMpc::project(std::span<const ChaseAim> aims) {
  primal_ = dual_ = 0.0;
  for (int block = 0; block < kBlocks; ++block) {
    if (block == kPosition && !has_walls_) continue;
    Block& b = blocks_[static_cast<std::size_t>(block)];
    const Columns relaxed = kSolver.over_relaxation * b.value + (1.0 - kSolver.over_relaxation) * b.projected;
    Columns next = relaxed + b.multiplier;
    b.multiplier = next;
    if (block == kPosition) {
      const double firmness = config_.wall_weight / (config_.wall_weight + kSolver.block_weight[kPosition] * rho_);
      for (int k = 0; k < num_steps_; ++k) {
        const Vector3 p_m = next.row(k).transpose();
        next.row(k) += firmness * (projected_to_walls(p_m, aims[static_cast<std::size_t>(k)]) - p_m).transpose();
      }
    } else {
      for (int k = 0; k < num_steps_; ++k) project_to_unit(next.row(k));
    }
    b.multiplier -= next;
    primal_ = std::max(primal_, (b.value - next).cwiseAbs().maxCoeff());
    dual_ = std::max(dual_, (next - b.projected).cwiseAbs().maxCoeff());
    b.projected = next;
  }
}

/// Changes rho to balance the residuals; the multipliers are scaled by 1 / rho.
bool ChaseMpc::change_rho() {
  double multiplier = 0.0;
  for (const Block& block : blocks_) multiplier = std::max(multiplier, block.multiplier.cwiseAbs().maxCoeff());
  const double balance = std::sqrt(primal_ * std::max(multiplier, 1e-6) / std::max(dual_, 1e-12));
  if (balance < kSolver.unbalanced && balance * kSolver.unbalanced > 1.0) return false;
  const double change = std::clamp(balance, 1.0 / kSolver.max_change, kSolver.max_change);
  if (rho_ * change > kSolver.max_rho || rho_ * change * kSolver.max_rho < 1.0) return false;
  rho_ *= change;
  for (Block& block : blocks_) block.multiplier /= change;
  return true;
}

}  // namespace swiftlet
