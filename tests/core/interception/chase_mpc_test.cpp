// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/chase_mpc.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "swiftlet/core/math/random.hpp"
#include "tests/core/interception/chase_reference.hpp"
#include "tests/support/allocation_counter.hpp"

namespace swiftlet {
namespace {

const MotionLimits kLimits{8.0, 4.0, 60.0, 4.0, 2.0, 60.0, 2.0, 2.0};

struct Problem {
  PointState start;
  std::vector<ChaseAim> aims;
  double step_s = 0.1;
};

/// A start from which full braking keeps the limits, an aim that flies past, and perhaps walls.
Problem random_problem(const Random& random, std::uint32_t number, int num_steps) {
  std::uint32_t index = 0;
  const auto draw = [&](double min, double max) { return random.uniform(min, max, number, index++); };
  const auto vector = [&](double horizontal, double vertical) {
    return Vector3(draw(-horizontal, horizontal), draw(-horizontal, horizontal), draw(-vertical, vertical));
  };
  Problem problem;
  problem.step_s = draw(0.05, 0.25);
  problem.start = {vector(10.0, 5.0), vector(4.0, 3.0), vector(1.5, 1.0)};
  const Vector3 p_m = vector(15.0, 5.0), v_mps = vector(6.0, 2.0);
  const bool matches_velocity = draw(0.0, 1.0) < 0.3, has_wall = draw(0.0, 1.0) < 0.5, has_floor = draw(0.0, 1.0) < 0.5;
  const Vector3 normal = vector(1.0, 1.0).normalized();
  const double offset_m = draw(0.0, 8.0);
  for (int k = 0; k < num_steps; ++k) {
    ChaseAim aim;
    aim.p_m = p_m + (k + 1) * problem.step_s * v_mps;
    aim.v_mps = v_mps;
    aim.weight = k < num_steps / 2 ? draw(0.05, 1.0) : 1.0;
    aim.velocity_weight = matches_velocity ? 0.1 : 0.0;
    // Orthogonal, like walls and floors.
    if (has_wall) aim.walls[static_cast<std::size_t>(aim.num_walls++)] = {normal, offset_m};
    if (has_floor && !has_wall) aim.walls[static_cast<std::size_t>(aim.num_walls++)] = {-Vector3::UnitZ(), 3.0};
    problem.aims.push_back(aim);
  }
  return problem;
}

std::vector<double> jerks_of(const ChaseMpc& mpc) {
  std::vector<double> u;
  for (int k = 0; k < mpc.num_steps(); ++k) {
    for (int axis = 0; axis < 3; ++axis) u.push_back(mpc.jerk_mps3(k)[axis]);
  }
  return u;
}

/// Jerks that level off the acceleration within two steps or so: strictly within the limits, or none.
std::vector<double> levelling_off(const testing::DenseChase& dense, const Problem& problem) {
  const auto steps = static_cast<std::size_t>(dense.steps());
  std::vector<double> u(3 * steps, 0.0);
  const Vector3 jerk = -problem.start.a_mps2 / (2.0 * problem.step_s);
  for (std::size_t k = 0; k < std::min<std::size_t>(2, steps); ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) u[3 * k + axis] = jerk[static_cast<int>(axis)];
  }
  if (!(dense.greatest_share(u) < 1.0)) u.clear();
  return u;
}

struct Comparison {
  int problems = 0;
  double cost_excess = 0.0;   // greatest, relative to the least cost + 1
  double cost_short = 0.0;    // greatest by which it lies below: bought by breaking limits
  double limit_excess = 0.0;  // greatest, as a share of the limit
};

Comparison compare(const ChaseMpcConfig& config, int num_problems, std::uint64_t seed,
                   const std::vector<int>& num_steps) {
  const Random random(seed, "test.chase");
  Comparison result;
  for (std::uint32_t number = 0; result.problems < num_problems; ++number) {
    const int steps = num_steps[number % num_steps.size()];
    const Problem problem = random_problem(random, number, steps);
    const testing::DenseChase dense(config, kLimits, problem.start, problem.aims, problem.step_s);
    const std::vector<double> strictly_inside = levelling_off(dense, problem);
    if (strictly_inside.empty()) continue;
    ++result.problems;
    const double least = dense.cost(dense.solve(strictly_inside, 1e-6));
    ChaseMpc mpc(config, kLimits, steps);
    mpc.solve(problem.start, problem.aims, problem.step_s);
    const std::vector<double> u = jerks_of(mpc);
    const double excess = (dense.cost(u) - least) / (1.0 + least);
    result.cost_excess = std::max(result.cost_excess, excess);
    result.cost_short = std::max(result.cost_short, -excess);
    result.limit_excess = std::max(result.limit_excess, dense.greatest_share(u) - 1.0);
  }
  return result;
}

ChaseMpcConfig until_converged() {
  ChaseMpcConfig config;
  config.iterations = 20000;
  config.tolerance = 1e-7;
  return config;
}

TEST(ChaseMpc, MatchesCostOfADenseSolver) {
  for (const bool long_plans : {false, true}) {
    const Comparison result =
        long_plans ? compare(until_converged(), 20, 2, {20}) : compare(until_converged(), 2000, 1, {1, 2, 3, 4});
    const double bound = long_plans ? 1e-3 : 1e-4;
    EXPECT_LT(result.cost_excess, bound);
    EXPECT_LT(result.cost_short, bound);
    EXPECT_LT(result.limit_excess, bound);
  }
}

TEST(ChaseMpc, MatchesTheDenseSolverInFull) {
  const Comparison result = compare(until_converged(), 100'000, 3, {1, 2, 3, 4});
  EXPECT_LT(result.cost_excess, 5e-4);
  EXPECT_LT(result.cost_short, 5e-4);
  EXPECT_LT(result.limit_excess, 5e-4);
}

// The vehicle flies plans of as many iterations as there is time for.
TEST(ChaseMpc, NearsTheOptimumInFewIterations) {
  const Comparison result = compare({}, 60, 4, {20});
  EXPECT_LT(result.cost_excess, 0.03);
  EXPECT_LT(result.limit_excess, 0.05);
}

TEST(ChaseMpc, SettlesAtAnAimAtRest) {
  ChaseMpc mpc({}, kLimits, 20);
  std::vector<ChaseAim> aims(20);
  for (ChaseAim& aim : aims) aim.p_m = {3.0, -2.0, 1.0};
  PointState state;
  for (int replan = 0; replan < 200; ++replan) {
    mpc.solve(state, aims, 0.1);
    state = mpc.at(0.05);
  }
  EXPECT_LT((state.p_m - aims.front().p_m).norm(), 0.02);
  EXPECT_LT(state.v_mps.norm(), 0.02);
}

// Full jerk, full acceleration, full speed, and back: the time of the closed form, to within a step.
TEST(ChaseMpc, IsNearlyTimeOptimal) {
  ChaseMpc mpc({}, kLimits, 20);
  const double way_m = 14.0, a = kLimits.horizontal_acceleration_mps2, v = kLimits.horizontal_speed_mps;
  std::vector<ChaseAim> aims(20);
  for (ChaseAim& aim : aims) aim.p_m = {way_m, 0.0, 0.0};
  PointState state;
  double t_s = 0.0;
  while (state.p_m.x() < 0.5 * way_m) {
    mpc.solve(state, aims, 0.1);
    state = mpc.at(0.05);
    t_s += 0.05;
    ASSERT_LT(t_s, 10.0);
  }
  const double least_s = std::sqrt(2.0 * 0.5 * way_m / a) + 0.5 * a / kLimits.horizontal_jerk_mps3;
  ASSERT_LT(a * least_s, v) << "full speed is not reached on half the way";
  EXPECT_LT(t_s, least_s + 0.06);
}

TEST(ChaseMpc, StaysBeforeAWall) {
  ChaseMpc mpc({}, kLimits, 20);
  std::vector<ChaseAim> aims(20);
  for (ChaseAim& aim : aims) {
    aim.p_m = {10.0, 0.0, 0.0};
    aim.num_walls = 1;
    aim.walls[0] = {Vector3::UnitX(), 4.0};
  }
  PointState state;
  double farthest_m = 0.0;
  for (int replan = 0; replan < 120; ++replan) {
    mpc.solve(state, aims, 0.1);
    state = mpc.at(0.05);
    farthest_m = std::max(farthest_m, state.p_m.x());
  }
  EXPECT_GT(state.p_m.x(), 3.9);
  EXPECT_LT(farthest_m, 4.25);
}

TEST(ChaseMpc, IsDeterministicAndNeverAllocates) {
  const Problem problem = random_problem(Random(5, "test.chase"), 0, 20);
  ChaseMpc a({}, kLimits, 20), b({}, kLimits, 20);
  a.solve(problem.start, problem.aims, problem.step_s);
  b.solve({}, problem.aims, 0.3);
  b.forget();
  const auto before = test::num_allocations();
  b.solve(problem.start, problem.aims, problem.step_s);
  EXPECT_EQ(test::num_allocations(), before);
  for (int k = 0; k < 20; ++k) EXPECT_EQ(a.jerk_mps3(k), b.jerk_mps3(k));
}

}  // namespace
}  // namespace swiftlet
