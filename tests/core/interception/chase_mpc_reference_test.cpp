// SPDX-License-Identifier: BSD-3-Clause
// The solver beside the method of multipliers written out with dense matrices [Boyd 2011, sec. 3], iteration by
// iteration; the planner beside the aims that it is to set.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/interception/chase_planner.hpp"
#include "swiftlet/core/interception/chase_mpc.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

using Eigen::MatrixXd;

constexpr MotionLimits kChase{8.0, 4.0, 60.0, 4.0, 2.0, 60.0, 2.0, 2.0};

class ChaseDraws {
 public:
  ChaseDraws(std::uint64_t seed, std::uint32_t round) : random_(seed, "test.chase-reference"), round_(round) {}
  double between(double min, double max) { return random_.uniform(min, max, round_, index_++); }
  int below(int end) { return static_cast<int>(end * between(0.0, 1.0)); }
  Vector3 vector(double half) {
    const double x = between(-half, half), y = between(-half, half);
    return {x, y, between(-half, half)};
  }

 private:
  Random random_;
  std::uint32_t round_, index_ = 0;
};

/// Something that is constrained, A u + free in units of its limit; its copy within the limits, and the multiplier.
struct Part {
  double weight = 1.0;
  Vector3 unit = Vector3::Ones();
  MatrixXd of_jerks, free, copy, multiplier;

  MatrixXd value(const MatrixXd& u) const { return free + of_jerks * u * unit.asDiagonal(); }
};

class PlainMpc {
 public:
  PlainMpc(const ChaseMpcConfig& config, const MotionLimits& limits) : config_(config) {
    const auto both = [](double level, double upright) { return Vector3(1.0 / level, 1.0 / level, 1.0 / upright); };
    parts_[0].weight = 0.3;
    parts_[0].unit = both(limits.horizontal_jerk_mps3, limits.vertical_jerk_mps3);
    parts_[1].weight = 1.0;
    parts_[1].unit = both(limits.horizontal_acceleration_mps2, limits.vertical_acceleration_mps2);
    parts_[2].weight = 4.0;
    parts_[2].unit = both(limits.horizontal_speed_mps, limits.vertical_speed_mps);
    parts_[3].weight = 0.1;
  }
  void forget() { is_known_ = false; }

  /// Jerks of all steps; how many changes of rho it took is told in `num_changes`.
  MatrixXd solve(const PointState& start, const std::vector<ChaseAim>& aims, double h) {
    const auto n = static_cast<Eigen::Index>(aims.size());
    if (h != step_s_) is_known_ = false;
    step_s_ = h;
    for (Part& part : parts_) {
      part.of_jerks.setZero(n, n);
      part.free.resize(n, 3);
    }
    parts_[0].of_jerks.setIdentity();
    parts_[0].free.setZero();
    MatrixXd aim_p(n, 3), aim_v(n, 3);
    Eigen::VectorXd weight(n), velocity_weight(n);
    bool walled = false;
    for (Eigen::Index k = 0; k < n; ++k) {
      // The response to a jerk of 1 in step i, from the equations of motion.
      for (Eigen::Index i = 0; i <= k; ++i) {
        const double after_s = h * static_cast<double>(k - i);
        parts_[1].of_jerks(k, i) = h;
        parts_[2].of_jerks(k, i) = h * h / 2.0 + h * after_s;
        parts_[3].of_jerks(k, i) = h * h * h / 6.0 + h * h / 2.0 * after_s + h * after_s * after_s / 2.0;
      }
      const ChaseAim& aim = aims[static_cast<std::size_t>(k)];
      const double t_s = h * static_cast<double>(k + 1);
      parts_[1].free.row(k) = start.a_mps2.transpose() * parts_[1].unit.asDiagonal();
      parts_[2].free.row(k) = (start.v_mps + t_s * start.a_mps2).transpose() * parts_[2].unit.asDiagonal();
      parts_[3].free.row(k) = (start.p_m + t_s * start.v_mps + t_s * t_s / 2.0 * start.a_mps2).transpose();
      aim_p.row(k) = aim.p_m.transpose();
      aim_v.row(k) = aim.v_mps.transpose();
      weight[k] = aim.weight;
      velocity_weight[k] = aim.velocity_weight;
      walled = walled || aim.num_walls > 0;
    }
    const MatrixXd &P = parts_[3].of_jerks, &V = parts_[2].of_jerks;
    const MatrixXd free_v = parts_[2].free * parts_[2].unit.cwiseInverse().asDiagonal();
    const MatrixXd H = P.transpose() * weight.asDiagonal() * P + V.transpose() * velocity_weight.asDiagonal() * V;
    const MatrixXd gradient = P.transpose() * weight.asDiagonal() * (parts_[3].free - aim_p) +
                              V.transpose() * velocity_weight.asDiagonal() * (free_v - aim_v);
    std::array<MatrixXd, 3> cost, constraints;
    for (int axis = 0; axis < 3; ++axis) {
      const double per_jerk = parts_[0].unit[axis];
      cost[axis] = H + config_.jerk_weight * per_jerk * per_jerk * MatrixXd::Identity(n, n);
      constraints[axis] = MatrixXd::Zero(n, n);
      for (int i = 0; i < (walled ? 4 : 3); ++i) {
        const Part& part = parts_[static_cast<std::size_t>(i)];
        constraints[axis] +=
            part.weight * part.unit[axis] * part.unit[axis] * part.of_jerks.transpose() * part.of_jerks;
      }
    }
    if (!is_known_) {
      rho_ = 5.0 * cost[0].trace() / constraints[0].trace();
      for (std::size_t i = 0; i < 4; ++i) {
        parts_[i].multiplier = MatrixXd::Zero(n, 3);
        parts_[i].copy = i < 3 ? within_unit(parts_[i].free) : parts_[i].free;
      }
    }
    is_known_ = true;

    MatrixXd u(n, 3);
    int next_change = 10;
    for (int iteration = 1; iteration <= config_.iterations; ++iteration) {
      for (int axis = 0; axis < 3; ++axis) {
        Eigen::VectorXd right = -gradient.col(axis);
        for (int i = 0; i < (walled ? 4 : 3); ++i) {
          const Part& part = parts_[static_cast<std::size_t>(i)];
          right += rho_ * part.weight * part.unit[axis] * part.of_jerks.transpose() *
                   (part.copy - part.multiplier - part.free).col(axis);
        }
        u.col(axis) = (cost[axis] + rho_ * constraints[axis]).llt().solve(right);
      }
      double primal = 0.0, dual = 0.0, multiplier = 0.0;
      for (std::size_t i = 0; i < 4; ++i) {
        Part& part = parts_[i];
        if (i < 3 || walled) {
          const MatrixXd value = part.value(u);
          const MatrixXd wanted = 1.6 * value - 0.6 * part.copy + part.multiplier;  // over-relaxed
          const MatrixXd next = i < 3 ? within_unit(wanted) : before_walls(wanted, aims);
          part.multiplier = wanted - next;
          primal = std::max(primal, (value - next).cwiseAbs().maxCoeff());
          dual = std::max(dual, (next - part.copy).cwiseAbs().maxCoeff());
          part.copy = next;
        }
        multiplier = std::max(multiplier, part.multiplier.cwiseAbs().maxCoeff());
      }
      residual = primal;
      if (iteration % 10 != 0) continue;
      if (std::max(primal, dual) < config_.tolerance) break;
      if (iteration < next_change) continue;
      next_change *= 2;
      const double balance = std::sqrt(primal * std::max(multiplier, 1e-6) / std::max(dual, 1e-12));
      if (balance > 0.25 && balance < 4.0) continue;
      const double change = std::min(std::max(balance, 0.1), 10.0);
      if (rho_ * change > 1e8 || rho_ * change < 1e-8) continue;
      rho_ *= change;
      for (Part& part : parts_) part.multiplier /= change;
      ++num_changes;
    }
    return parts_[0].copy * parts_[0].unit.cwiseInverse().asDiagonal();
  }

  double residual = 0.0;
  int num_changes = 0;

 private:
  static MatrixXd within_unit(MatrixXd rows) {
    for (Eigen::Index k = 0; k < rows.rows(); ++k) {
      const double length = rows.row(k).head<2>().norm();
      if (length > 1.0) rows.row(k).head<2>() /= length;
      rows(k, 2) = std::max(-1.0, std::min(1.0, rows(k, 2)));
    }
    return rows;
  }
  /// A share of the way before the walls, the larger the more they cost; twice around where there are several.
  MatrixXd before_walls(MatrixXd rows, const std::vector<ChaseAim>& aims) const {
    const double share = config_.wall_weight / (config_.wall_weight + 0.1 * rho_);
    for (Eigen::Index k = 0; k < rows.rows(); ++k) {
      const ChaseAim& aim = aims[static_cast<std::size_t>(k)];
      Vector3 p_m = rows.row(k).transpose();
      for (int i = 0; i < (aim.num_walls > 1 ? 2 : 1) * aim.num_walls; ++i) {
        const Wall& wall = aim.walls[static_cast<std::size_t>(i % aim.num_walls)];
        const double beyond_m = wall.normal.dot(p_m) - wall.offset_m;
        if (beyond_m > 0.0) p_m -= beyond_m * wall.normal;
      }
      rows.row(k) += share * (p_m.transpose() - rows.row(k));
    }
    return rows;
  }

  ChaseMpcConfig config_;
  std::array<Part, 4> parts_;
  double rho_ = 1.0, step_s_ = 0.0;
  bool is_known_ = false;
};

std::vector<ChaseAim> drawn_aims(ChaseDraws& draws, int num_steps, double step_s) {
  const Vector3 p_m = draws.vector(12.0), v_mps = draws.vector(5.0);
  const double velocity_weight = draws.below(2) == 0 ? 0.0 : draws.between(0.02, 0.5);
  const int num_walls = std::max(0, draws.below(7) - 2);
  std::vector<ChaseAim> aims(static_cast<std::size_t>(num_steps));
  std::array<Wall, 4> walls;
  for (Wall& wall : walls) wall = {draws.vector(1.0).normalized(), draws.between(0.0, 5.0)};
  for (std::size_t k = 0; k < aims.size(); ++k) {
    aims[k].p_m = p_m + static_cast<double>(k + 1) * step_s * v_mps;
    aims[k].v_mps = v_mps;
    aims[k].weight = draws.between(0.02, 1.0);
    aims[k].velocity_weight = velocity_weight;
    aims[k].num_walls = k % 3 == 2 ? 0 : num_walls;
    aims[k].walls = walls;
  }
  return aims;
}

TEST(ChaseMpcReference, EveryPlanIsWhatTheMethodFindsInAsManyIterations) {
  int num_changes = 0;
  for (std::uint32_t round = 0; round < 90; ++round) {
    ChaseDraws draws(1, round);
    ChaseMpcConfig config;
    config.iterations = std::array{1, 9, 10, 11, 35, 80, 200}[round % 7];
    config.tolerance = std::array{1e-3, 0.05, 1e-6}[round % 3];
    config.jerk_weight = draws.between(1e-4, 1e-1);
    config.wall_weight = draws.between(5.0, 300.0);
    const int n = 2 + draws.below(10);
    ChaseMpc mpc(config, kChase, n);
    PlainMpc plain(config, kChase);
    double step_s = draws.between(0.05, 0.25);
    for (int plan = 0; plan < 4; ++plan) {
      // Warm, with another step, or told to forget.
      if (plan == 2) step_s *= draws.below(2) == 0 ? 1.0 : 1.3;
      if (plan == 3 && draws.below(2) == 0) {
        mpc.forget();
        plain.forget();
      }
      const PointState start{draws.vector(8.0), draws.vector(6.0), draws.vector(4.0)};
      const std::vector<ChaseAim> aims = drawn_aims(draws, n, step_s);
      mpc.solve(start, aims, step_s);
      const MatrixXd expected = plain.solve(start, aims, step_s);
      PointState then = start;
      for (int k = 0; k < n; ++k) {
        const Vector3 jerk = expected.row(k).transpose();
        ASSERT_LT((mpc.jerk_mps3(k) - jerk).norm(), 1e-5) << round << ", plan " << plan;
        for (const double share : {0.0, 0.4, 0.999}) {
          const double t_s = share * step_s;
          const PointState got = mpc.at((k + share) * step_s);
          const Vector3 a = then.a_mps2 + t_s * jerk;
          ASSERT_LT((got.a_mps2 - a).norm(), 1e-5);
          ASSERT_LT((got.v_mps - then.v_mps - t_s / 2.0 * (then.a_mps2 + a)).norm(), 1e-5);
          ASSERT_LT((got.p_m - then.p_m - t_s * then.v_mps - t_s * t_s / 6.0 * (2.0 * then.a_mps2 + a)).norm(), 1e-5);
        }
        then = then.after(jerk, step_s);
      }
      const PointState beyond = mpc.at(n * step_s + 0.7);
      ASSERT_LT((beyond.p_m - then.p_m - 0.7 * then.v_mps).norm(), 1e-5) << "it flies on as fast as at the end";
      ASSERT_LT((beyond.v_mps - then.v_mps).norm(), 1e-5);
      ASSERT_EQ(beyond.a_mps2, Vector3(0, 0, 0));
      ASSERT_NEAR(mpc.residual(), plain.residual, 1e-7);
      ASSERT_EQ(mpc.step_s(), step_s);
      ASSERT_EQ(mpc.at(-1.0).p_m, start.after(mpc.jerk_mps3(0), -1.0).p_m);
    }
    num_changes += plain.num_changes;
  }
  EXPECT_GT(num_changes, 50);
}

// ---- planner

Surroundings walled_sky() {
  Surroundings around;
  GeofenceConfig config;
  config.min_m = {-60.0, -60.0, 1.0};
  config.max_m = {12.0, 60.0, 60.0};
  around.fence = Geofence(config, FrameChange());
  return around;
}

/// When a target can be within reach: in steps of 50 ms, by speed over the whole way and by what acceleration adds.
double plain_time_to_go_s(const MotionLimits& limits, double reach_m, double longest_s, const PointState& self,
                          const TargetPrediction& target, const Vector3& to_target_m) {
  const auto reaches = [](double way_m, double speed_mps, double t_s, double most_mps, double acceleration,
                          double jerk) {
    // Full jerk takes a / j to full acceleration: as if that began half of it later.
    const double late_s = std::max(0.0, t_s - acceleration / jerk / 2.0);
    return way_m <= t_s * most_mps && speed_mps <= acceleration / 2.0 * late_s * late_s;
  };
  for (double t_s = 0.05; t_s < longest_s - 0.05 + 1e-9; t_s += 0.05) {
    const Vector3 way_m = target.at(t_s).p_m - to_target_m - self.p_m, missing_m = way_m - t_s * self.v_mps;
    if (reaches(way_m.head<2>().norm() - reach_m, missing_m.head<2>().norm() - reach_m, t_s,
                limits.horizontal_speed_mps, limits.horizontal_acceleration_mps2, limits.horizontal_jerk_mps3) &&
        reaches(std::abs(way_m.z()), std::abs(missing_m.z()), t_s, limits.vertical_speed_mps,
                limits.vertical_acceleration_mps2, limits.vertical_jerk_mps3))
      return t_s;
  }
  return longest_s;
}

TEST(ChasePlannerReference, EveryPlanIsThatOfTheAims) {
  int at_bounds = 0, walled = 0, crossings = 0;
  for (std::uint32_t round = 0; round < 40; ++round) {
    ChaseDraws draws(2, round);
    ChasePlanConfig config;
    config.steps = 5 + draws.below(16);
    config.horizon_min_s = draws.between(0.5, 1.5);
    config.horizon_max_s = draws.between(1.6, 4.0);
    config.weight_before = draws.between(0.0, 0.5);
    config.weight_after = draws.between(0.0, 0.5);
    config.meeting_s = draws.between(0.02, 0.6);
    config.velocity_weight = draws.below(2) == 0 ? 0.0 : 0.2;
    config.hold_m = draws.between(0.1, 1.0);
    config.through_m = draws.between(0.1, 1.0);
    config.crossing_mps = draws.between(0.2, 3.0);
    config.crossing_delay_s = draws.between(0.0, 0.4);
    const double reach_m = draws.between(0.2, 1.5);
    MotionLimits slower = kChase;  // so that the governor follows it as it is
    for (double MotionLimits::*limit :
         {&MotionLimits::horizontal_speed_mps, &MotionLimits::horizontal_acceleration_mps2,
          &MotionLimits::horizontal_jerk_mps3, &MotionLimits::vertical_speed_mps,
          &MotionLimits::vertical_acceleration_mps2, &MotionLimits::vertical_jerk_mps3})
      slower.*limit *= 0.985;
    ChasePlanner planner(config, kChase, reach_m);
    ChaseMpc plain(config.solver, slower, config.steps);
    const Surroundings around = walled_sky();
    PointState self{Vector3(0, 0, 8) + draws.vector(6.0), draws.vector(3.0), draws.vector(1.0)};
    bool planned = false;
    double last_step_s = 0.0, amid_s = 0.0;
    Track track;
    track.position_m = Vector3(0, 0, 10) + draws.vector(draws.below(2) == 0 ? 3.0 : 18.0);
    track.velocity_mps = draws.vector(3.0);
    const Vector3 to_target_m = draws.vector(1.5);
    for (int plan = 0; plan < 6; ++plan) {
      track.position_m += 0.3 * track.velocity_mps;
      const TargetPrediction target({}, track, nullptr, 0);
      const double side = draws.below(3) - 1.0;
      if (plan == 3) {
        planner.forget();
        plain.forget();
        planned = false;
      }
      planner.plan(self, target, to_target_m, side, around, 0.3);

      const double go_s = plain_time_to_go_s(slower, reach_m, config.horizon_max_s, self, target, to_target_m);
      ASSERT_NEAR(planner.time_to_go_s(), go_s, 1e-9) << round << ", " << plan;
      const double horizon_s = std::clamp(1.3 * go_s, config.horizon_min_s, config.horizon_max_s);
      at_bounds += horizon_s != 1.3 * go_s;
      const double step_s = 0.0125 * std::ceil(horizon_s / config.steps / 0.0125 - 1e-9);
      ASSERT_NEAR(planner.horizon_s(), config.steps * step_s, 1e-9);
      const double meeting_s = std::min(planner.time_to_go_s(), (config.steps - 1) * step_s);
      // When the target is amid the disc as planned 0.3 s ago.
      amid_s = planned ? amid_s + 0.3 : 0.0;
      std::optional<double> crosses_s;
      std::vector<double> amid_at_s;
      for (int i = 0; planned && 0.025 * i <= config.steps * last_step_s - 0.3 + 1e-9; ++i) {
        const Vector3 off_m = target.at(0.025 * i).p_m - to_target_m - plain.at(0.025 * i + 0.3).p_m;
        const bool amid = std::hypot(off_m.x(), off_m.y()) < reach_m;
        if (i == 0 && !amid) amid_s = 0.0;
        if (amid) amid_at_s.push_back(0.025 * i);
        if (!amid && !amid_at_s.empty()) break;
      }
      if (!amid_at_s.empty()) {
        const double from_s = amid_at_s.front() > 0.0 ? amid_at_s.front() : -amid_s;
        crosses_s = std::min(0.5 * (from_s + amid_at_s.back()), from_s + config.crossing_delay_s);
      }
      crossings += crosses_s.has_value();
      std::vector<ChaseAim> aims(static_cast<std::size_t>(config.steps));
      for (int k = 0; k < config.steps; ++k) {
        ChaseAim& aim = aims[static_cast<std::size_t>(k)];
        const double t_s = (k + 1) * step_s;
        aim.p_m = target.at(t_s).p_m - to_target_m;
        aim.v_mps = target.at(t_s).v_mps;
        const bool before = t_s < meeting_s;
        const bool meets = !before && t_s < meeting_s + std::max(config.meeting_s, 1.01 * step_s);
        const double rises_m = crosses_s ? config.crossing_mps * (*crosses_s - t_s) : config.hold_m;
        aim.p_m.z() += side * std::max(-config.through_m, std::min(config.hold_m, rises_m));
        aim.weight = before ? config.weight_before : meets ? 1.0 : config.weight_after;
        if (meets) aim.velocity_weight = config.velocity_weight;
        Vector3 there_m = self.p_m + std::min(1.0, t_s / std::max(meeting_s, step_s)) * (aim.p_m - self.p_m);
        if (planned && t_s + 0.3 < config.steps * last_step_s) there_m = plain.at(t_s + 0.3).p_m;
        around.walls(there_m, t_s, aim);
        walled += aim.num_walls > 0;
      }
      plain.solve(self, aims, step_s);
      for (double t_s = 0.0; t_s < planner.horizon_s() + 0.5; t_s += 0.07)
        ASSERT_LT((planner.at(t_s).p_m - plain.at(t_s).p_m).norm(), 1e-9) << round << ", " << plan << ": " << t_s;
      planned = true;
      last_step_s = step_s;
      self = plain.at(0.3);
    }
  }
  EXPECT_GT(at_bounds, 20);
  EXPECT_GT(walled, 100);
  EXPECT_GT(crossings, 50);
}

}  // namespace
}  // namespace swiftlet
