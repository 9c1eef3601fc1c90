// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "core/interception/chase_mpc.hpp"

namespace swiftlet::testing {

/// The chase as one dense convex problem over all jerks, solved by Newton's method with a logarithmic barrier (Boyd and
/// Vandenberghe, Convex Optimization, ch. 11). Independent of the condensed problem: states result from stepping the
/// motion with unit jerks.
class DenseChase {
 public:
  DenseChase(const ChaseMpcConfig& config, const MotionLimits& limits, const PointState& start,
             std::span<const ChaseAim> aims, double step_s)
      : config_(config), start_(start), aims_(aims.begin(), aims.end()), step_s_(step_s) {
    n_ = 3 * static_cast<int>(aims.size());
    jerk_ = {limits.horizontal_jerk_mps3, limits.horizontal_jerk_mps3, limits.vertical_jerk_mps3};
    const auto axes = [](double h, double v) { return Vector3(h, h, v); };
    limit_[0] = axes(limits.horizontal_jerk_mps3, limits.vertical_jerk_mps3);
    limit_[1] = axes(limits.horizontal_acceleration_mps2, limits.vertical_acceleration_mps2);
    limit_[2] = axes(limits.horizontal_speed_mps, limits.vertical_speed_mps);
    const int k_max = steps();
    response_.assign(static_cast<std::size_t>(k_max * k_max), {});
    for (int i = 0; i < k_max; ++i) {
      PointState state;  // state of one axis; all three are alike
      for (int k = i; k < k_max; ++k) {
        state = state.after(Vector3(k == i ? 1.0 : 0.0, 0.0, 0.0), step_s);
        response_[static_cast<std::size_t>(k * k_max + i)] = {state.p_m.x(), state.v_mps.x(), state.a_mps2.x()};
      }
    }
  }

  int steps() const { return n_ / 3; }

  double cost(const std::vector<double>& u) const {
    const std::vector<PointState> states = roll_out(u);
    double sum = 0.0;
    for (int k = 0; k < steps(); ++k) {
      const ChaseAim& aim = aims_[static_cast<std::size_t>(k)];
      const PointState& s = states[static_cast<std::size_t>(k)];
      sum += 0.5 * aim.weight * (s.p_m - aim.p_m).squaredNorm();
      sum += 0.5 * aim.velocity_weight * (s.v_mps - aim.v_mps).squaredNorm();
      for (int axis = 0; axis < 3; ++axis) {
        const double share = u[static_cast<std::size_t>(3 * k + axis)] / jerk_[axis];
        sum += 0.5 * config_.jerk_weight * share * share;
      }
      for (int w = 0; w < aim.num_walls; ++w) {
        const double excess_m = std::max(0.0, aim.walls[static_cast<std::size_t>(w)].excess_m(s.p_m));
        sum += 0.5 * config_.wall_weight * excess_m * excess_m;
      }
    }
    return sum;
  }

  /// Greatest length of a jerk, acceleration or velocity, as a share of its limit.
  double greatest_share(const std::vector<double>& u) const {
    const std::vector<PointState> states = roll_out(u);
    double greatest = 0.0;
    for (int k = 0; k < steps(); ++k) {
      for (int block = 0; block < 3; ++block) {
        const Vector3 y = constrained(block, k, u, states);
        greatest = std::max({greatest, y.head<2>().norm(), std::abs(y.z())});
      }
    }
    return greatest;
  }

  /// Starts from jerks strictly within the limits; returns the least cost to within `gap`, relative to the cost + 1.
  std::vector<double> solve(std::vector<double> u, double gap) const {
    const double num_barriers = 6.0 * steps();
    for (double t = 1.0;; t *= 20.0) {
      for (int newton = 0; newton < 400 && newton_step(u, t); ++newton) {
      }
      if (num_barriers / t < gap) return u;
    }
  }

 private:
  struct Response {
    double p = 0.0, v = 0.0, a = 0.0;
  };

  std::vector<PointState> roll_out(const std::vector<double>& u) const {
    std::vector<PointState> states;
    states.reserve(static_cast<std::size_t>(steps()));
    PointState state = start_;
    for (int k = 0; k < steps(); ++k) {
      const auto i = static_cast<std::size_t>(3 * k);
      state = state.after({u[i], u[i + 1], u[i + 2]}, step_s_);
      states.push_back(state);
    }
    return states;
  }

  Vector3 constrained(int block, int k, const std::vector<double>& u, const std::vector<PointState>& states) const {
    const auto i = static_cast<std::size_t>(k);
    const Vector3 y = block == 0   ? Vector3(u[3 * i], u[3 * i + 1], u[3 * i + 2])
                      : block == 1 ? states[i].a_mps2
                                   : states[i].v_mps;
    return y.cwiseQuotient(limit_[block]);
  }
  double gain(int block, int k, int i) const {
    if (block == 0) return i == k ? 1.0 : 0.0;
    const Response& r = response_[static_cast<std::size_t>(k * steps() + i)];
    return block == 1 ? r.a : r.v;
  }

  /// Infinite outside of the limits.
  double barrier(const std::vector<double>& u) const {
    const std::vector<PointState> states = roll_out(u);
    double sum = 0.0;
    for (int k = 0; k < steps(); ++k) {
      for (int block = 0; block < 3; ++block) {
        const Vector3 y = constrained(block, k, u, states);
        const double disc = 1.0 - y.head<2>().squaredNorm(), interval = 1.0 - y.z() * y.z();
        if (!(disc > 0.0 && interval > 0.0)) return std::numeric_limits<double>::infinity();
        sum -= std::log(disc) + std::log(interval);
      }
    }
    return sum;
  }

  bool newton_step(std::vector<double>& u, double t) const {
    const int n = n_;
    Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
    const std::vector<PointState> states = roll_out(u);
    // Adds the curvature `C` and the slope `d` of a function of the three components y_k = sum_i gain(k, i) u_i.
    const auto add = [&](int k, const Matrix3& C, const Vector3& d, const auto& gain_of) {
      for (int i = 0; i <= k; ++i) {
        const double gi = gain_of(i);
        if (gi == 0.0) continue;
        for (int a = 0; a < 3; ++a) g[3 * i + a] += gi * d[a];
        for (int j = 0; j <= k; ++j) {
          const double gij = gi * gain_of(j);
          if (gij == 0.0) continue;
          for (int a = 0; a < 3; ++a) {
            for (int b = 0; b < 3; ++b) H(3 * i + a, 3 * j + b) += gij * C(a, b);
          }
        }
      }
    };
    for (int k = 0; k < steps(); ++k) {
      const ChaseAim& aim = aims_[static_cast<std::size_t>(k)];
      const PointState& s = states[static_cast<std::size_t>(k)];
      Matrix3 C = aim.weight * Matrix3::Identity();
      Vector3 d = aim.weight * (s.p_m - aim.p_m);
      for (int w = 0; w < aim.num_walls; ++w) {
        const Wall& wall = aim.walls[static_cast<std::size_t>(w)];
        if (wall.excess_m(s.p_m) <= 0.0) continue;
        C += config_.wall_weight * wall.normal * wall.normal.transpose();
        d += config_.wall_weight * wall.excess_m(s.p_m) * wall.normal;
      }
      add(k, t * C, t * d, [&](int i) { return response_[static_cast<std::size_t>(k * steps() + i)].p; });
      add(k, t * aim.velocity_weight * Matrix3::Identity(), t * aim.velocity_weight * (s.v_mps - aim.v_mps),
          [&](int i) { return gain(2, k, i); });
      const Vector3 per_jerk = jerk_.cwiseProduct(jerk_).cwiseInverse() * config_.jerk_weight;
      const auto at = static_cast<std::size_t>(3 * k);
      add(k, t * Matrix3(per_jerk.asDiagonal()), t * per_jerk.cwiseProduct(Vector3(u[at], u[at + 1], u[at + 2])),
          [&](int i) { return gain(0, k, i); });
      for (int block = 0; block < 3; ++block) {
        const Vector3 y = constrained(block, k, u, states);
        const Vector3 scale = limit_[block].cwiseInverse();
        const double disc = 1.0 - y.head<2>().squaredNorm(), interval = 1.0 - y.z() * y.z();
        Vector3 slope(2.0 * y.x() / disc, 2.0 * y.y() / disc, 2.0 * y.z() / interval);
        Matrix3 curvature = Matrix3::Zero();
        curvature.topLeftCorner<2, 2>() =
            2.0 / disc * Eigen::Matrix2d::Identity() + 4.0 / (disc * disc) * y.head<2>() * y.head<2>().transpose();
        curvature(2, 2) = 2.0 / interval + 4.0 * y.z() * y.z() / (interval * interval);
        slope = slope.cwiseProduct(scale);
        curvature = scale.asDiagonal() * curvature * scale.asDiagonal();
        add(k, curvature, slope, [&](int i) { return gain(block, k, i); });
      }
    }
    const Eigen::VectorXd step = -H.ldlt().solve(g);
    const double slope = g.dot(step);
    if (!(slope < -1e-9)) return false;
    const double now = t * cost(u) + barrier(u);
    for (double length = 1.0; length > 1e-9; length *= 0.5) {
      std::vector<double> tried = u;
      for (int i = 0; i < n; ++i) tried[static_cast<std::size_t>(i)] += length * step[i];
      const double value = t * cost(tried) + barrier(tried);
      if (!(value <= now + 0.1 * length * slope)) continue;
      u = tried;
      return true;
    }
    return false;
  }

  ChaseMpcConfig config_;
  PointState start_;
  std::vector<ChaseAim> aims_;
  double step_s_;
  int n_ = 0;
  Vector3 jerk_;
  std::array<Vector3, 3> limit_;    // limits of jerk, acceleration, velocity
  std::vector<Response> response_;  // [step][jerk of step]
};

}  // namespace swiftlet::testing
