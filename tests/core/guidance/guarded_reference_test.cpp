// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/separation/guarded_reference.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

constexpr double kPeriod_s = 0.1, kTick_s = 0.02, kSpeed_mps = 4.0;

Reference at(const Vector3& p_m) {
  Reference reference;
  reference.position_m = p_m;
  return reference;
}

/// A corridor along x, 4 m wide and closed at x = 12 m, seen from a place in it.
std::array<HalfSpace, 3> corridor_from(const Vector3& p_m) {
  return {{{Vector3::UnitX(), 12.0 - p_m.x()},
           {Vector3::UnitY(), 2.0 - p_m.y()},
           {Vector3(-Vector3::UnitY()), 2.0 + p_m.y()}}};
}

/// Largest distance outside the corridor when goals jump to any place in it, ten times a second.
double farthest_out_m(bool guarded, std::uint64_t seed) {
  const Random random(seed, "guarded-reference");
  MotionLimits limits;
  limits.horizontal_jerk_mps3 = 10.0;
  GuardedReference reference(limits);
  Vector3 p_m = Vector3::Zero();
  reference.reset(at(p_m));
  double farthest_m = -std::numeric_limits<double>::infinity();
  Vector3 last_m = p_m;
  for (std::uint32_t update = 0; update < 300; ++update) {
    const double y_m = random.uniform(-2.0, 2.0, update, 0);
    const double x_m = random.uniform(0.0, 12.0, update / 20, 1);
    const auto walls = corridor_from(p_m);
    const std::span<const HalfSpace> planes =
        guarded ? std::span<const HalfSpace>(walls) : std::span<const HalfSpace>();
    const Vector3 goal_m = reference.admit(last_m, {x_m, y_m, 0.0}, planes, p_m, kPeriod_s, kSpeed_mps);
    for (int tick = 1; tick <= 5; ++tick) {
      const Vector3 gliding_m = last_m + 0.2 * tick * (goal_m - last_m);
      p_m = reference.step(at(gliding_m), kTick_s, kSpeed_mps).position_m;
      for (const HalfSpace& wall : corridor_from(p_m)) farthest_m = std::max(farthest_m, -wall.offset_m);
    }
    last_m = goal_m;
  }
  return farthest_m;
}

TEST(GuardedReference, StaysBehindPlanesDuringBrakingTurns) {
  double unguarded_m = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    EXPECT_LT(farthest_out_m(true, seed), 0.02) << seed;
    unguarded_m = std::max(unguarded_m, farthest_out_m(false, seed));
  }
  EXPECT_GT(unguarded_m, 0.1) << "goals in the corridor alone do not keep the vehicle there";
}

TEST(GuardedReference, KeepsTheGoalWithoutObstructingPlanes) {
  GuardedReference reference{MotionLimits{}};
  reference.reset(at(Vector3::Zero()));
  const std::array<HalfSpace, 1> far_away{{{Vector3::UnitX(), 50.0}}};
  const Vector3 goal_m(3.0, 2.0, 1.0);
  EXPECT_EQ(reference.admit(Vector3::Zero(), goal_m, far_away, Vector3::Zero(), kPeriod_s, kSpeed_mps), goal_m);
  EXPECT_EQ(reference.admit(Vector3::Zero(), goal_m, {}, Vector3::Zero(), kPeriod_s, kSpeed_mps), goal_m);
}

TEST(GuardedReference, ComesToRestAsPredicted) {
  GuardedReference reference{MotionLimits{}};
  Reference start = at(Vector3::Zero());
  start.velocity_mps = {3.0, 0.0, -1.0};
  reference.reset(start);
  const Vector3 rest_m = reference.rest_local_m();
  EXPECT_NEAR(rest_m.x(), 9.0 / 4.0, 0.6);  // v^2 / 2a, and what jerk and the last decimeters take
  EXPECT_LT(rest_m.z(), -0.5);
  // A plane right before the vehicle: it brakes.
  const std::array<HalfSpace, 1> wall{{{Vector3::UnitX(), 0.1}}};
  Vector3 p_m = Vector3::Zero();
  for (int update = 0; update < 50; ++update) {
    const Vector3 goal_m = reference.admit(p_m, {20.0, 0.0, 0.0}, wall, Vector3::Zero(), kPeriod_s, kSpeed_mps);
    for (int tick = 0; tick < 5; ++tick) p_m = reference.step(at(goal_m), kTick_s, kSpeed_mps).position_m;
  }
  EXPECT_NEAR(p_m.x(), rest_m.x(), 0.1);
}

TEST(GuardedReference, PermitsRemainingAtAPlane) {
  // The vehicle stands on the plane, up to rounding and the residual of the governor.
  GuardedReference reference{MotionLimits{}};
  for (const double beyond_m : {0.0, 1e-4, -1e-4}) {
    reference.reset(at(Vector3(beyond_m, 0.0, 0.0)));
    const std::array<HalfSpace, 1> here{{{Vector3::UnitX(), 0.0}}};
    const Vector3 along_m(0.0, 1.0, 0.0);
    EXPECT_EQ(reference.admit(Vector3::Zero(), along_m, here, Vector3::Zero(), kPeriod_s, kSpeed_mps), along_m)
        << beyond_m;
  }
}

}  // namespace
}  // namespace swiftlet
