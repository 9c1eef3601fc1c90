// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/uniform_spline.hpp"

#include <gtest/gtest.h>

namespace swiftlet {
namespace {

const std::vector<Vector3> kCurve = {{0, 0, 2}, {1, 0, 2}, {2, 0, 2}, {2, 1, 2.5}, {2, 2, 3}, {2, 3, 3}};

TEST(UniformSpline, BeginsAndEndsAtRestInItsFirstAndLastPoint) {
  const UniformSpline spline(kCurve, 0.5);
  EXPECT_DOUBLE_EQ(spline.duration_s(), 0.5 * 7);
  for (const double t_s : {0.0, spline.duration_s()}) {
    const auto state = spline.at(t_s);
    EXPECT_LT((state.p_m - (t_s == 0.0 ? kCurve.front() : kCurve.back())).norm(), 1e-12);
    EXPECT_LT(state.v_mps.norm(), 1e-12);
    EXPECT_LT(state.a_mps2.norm(), 1e-12);
  }
  EXPECT_EQ(spline.at(-1.0).p_m, spline.at(0.0).p_m);
  EXPECT_EQ(spline.at(99.0).p_m, spline.at(spline.duration_s()).p_m);
}

TEST(UniformSpline, ReproducesAStraightLineAtConstantSpeed) {
  std::vector<Vector3> line;
  for (int i = 0; i < 10; ++i) line.emplace_back(0.6 * i, -0.3 * i, 1.0);
  const UniformSpline spline(line, 0.2);
  const Vector3 v(3.0, -1.5, 0.0);
  for (double t_s = 0.45; t_s < 1.75; t_s += 0.05) {
    const auto state = spline.at(t_s);
    // Two more knots at the beginning: the curve is one interval behind its control points.
    EXPECT_LT((state.p_m - (line[0] + v * (t_s - 0.2))).norm(), 1e-12) << t_s;
    EXPECT_LT((state.v_mps - v).norm(), 1e-12) << t_s;
    EXPECT_LT(state.a_mps2.norm(), 1e-11) << t_s;
  }
}

TEST(UniformSpline, DerivativesAreThoseOfThePosition) {
  const UniformSpline spline(kCurve, 0.4);
  constexpr double kStep = 1e-5;
  for (double t_s = 0.01; t_s < spline.duration_s() - 0.01; t_s += 0.0371) {
    const auto before = spline.at(t_s - kStep), here = spline.at(t_s), after = spline.at(t_s + kStep);
    EXPECT_LT(((after.p_m - before.p_m) / (2 * kStep) - here.v_mps).norm(), 1e-6) << t_s;
    EXPECT_LT(((after.v_mps - before.v_mps) / (2 * kStep) - here.a_mps2).norm(), 1e-4) << t_s;
  }
}

TEST(UniformSpline, LeastDistanceIsThatOfTheClosestApproach) {
  std::vector<Vector3> a, b;
  for (int i = 0; i <= 50; ++i) {
    a.emplace_back(0.4 * i, 0, 2);
    b.emplace_back(20 - 0.4 * i, 1.5, 2);
  }
  EXPECT_NEAR(least_distance_m({a, 0.2}, {b, 0.2}), 1.5, 1e-6);
  // The second one waits at its start; the first comes by.
  EXPECT_NEAR(least_distance_m({a, 0.2}, {{{7.3, 0, 4.5}}, 0.2}), 2.5, 1e-3);
  // In the middle between two of the instants that are looked at.
  EXPECT_NEAR(least_distance_m({a, 0.2}, {{{7.35, 0, 4.5}}, 0.2}), 2.5, 1e-6);
}

}  // namespace
}  // namespace swiftlet
