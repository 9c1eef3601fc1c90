// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/uniform_spline.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

const std::vector<Vector3> kCurve = {{0, 0, 2}, {1, 0, 2}, {2, 0, 2}, {2, 1, 2.5}, {2, 2, 3}, {2, 3, 3}};

TEST(UniformSpline, RestsAtBothEndPoints) {
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

TEST(UniformSpline, DerivativesAreThoseOfThePosition) {
  const UniformSpline spline(kCurve, 0.4);
  constexpr double kStep = 1e-5;
  for (double t_s = 0.01; t_s < spline.duration_s() - 0.01; t_s += 0.0371) {
    const auto before = spline.at(t_s - kStep), here = spline.at(t_s), after = spline.at(t_s + kStep);
    EXPECT_LT(((after.p_m - before.p_m) / (2 * kStep) - here.v_mps).norm(), 1e-6) << t_s;
    EXPECT_LT(((after.v_mps - before.v_mps) / (2 * kStep) - here.a_mps2).norm(), 1e-4) << t_s;
  }
}

TEST(UniformSpline, FindsTheClosestApproach) {
  std::vector<Vector3> a, b;
  for (int i = 0; i <= 50; ++i) {
    a.emplace_back(0.4 * i, 0, 2);
    b.emplace_back(20 - 0.4 * i, 1.5, 2);
  }
  EXPECT_NEAR(least_distance_m({a, 0.2}, {b, 0.2}), 1.5, 1e-6);
  // The second one waits at its start; the first comes by.
  EXPECT_NEAR(least_distance_m({a, 0.2}, {{{7.3, 0, 4.5}}, 0.2}), 2.5, 1e-3);
  // Midway between two sampled instants.
  EXPECT_NEAR(least_distance_m({a, 0.2}, {{{7.35, 0, 4.5}}, 0.2}), 2.5, 1e-6);
}

/// Basis functions by their recursion [de Boor]; knots at whole numbers.
double basis(int i, int degree, double t) {
  if (degree == 0) return t >= i && t < i + 1 ? 1.0 : 0.0;
  return (t - i) / degree * basis(i, degree - 1, t) + (i + degree + 1 - t) / degree * basis(i + 1, degree - 1, t);
}

TEST(UniformSpline, IsTheSumOfBasisFunctions) {
  const Random random(4, "test.spline");
  for (std::uint32_t trial = 0; trial < 40; ++trial) {
    std::vector<Vector3> points;
    for (std::uint32_t i = 0; i <= trial % 7; ++i) {
      points.emplace_back(random.uniform(-5, 5, trial, 3 * i), random.uniform(-5, 5, trial, 3 * i + 1),
                          random.uniform(-5, 5, trial, 3 * i + 2));
    }
    const double interval_s = 0.1 + 0.1 * (trial % 4);
    const UniformSpline spline(points, interval_s);
    // The first and the last three times.
    std::vector<Vector3> all(2, points.front());
    all.insert(all.end(), points.begin(), points.end());
    all.insert(all.end(), 2, points.back());
    const auto n = static_cast<int>(all.size());
    EXPECT_NEAR(spline.duration_s(), (n - 3) * interval_s, 1e-12);
    const auto place = [&](double t_s) {
      Vector3 sum = Vector3::Zero();
      for (int i = 0; i < n; ++i) sum += basis(i, 3, 3.0 + t_s / interval_s) * all[static_cast<std::size_t>(i)];
      return sum;
    };
    for (int k = 0; k < 60; ++k) {
      const double t_s = spline.duration_s() * (k + 0.37) / 60.0;
      ASSERT_LT((spline.at(t_s).p_m - place(t_s)).norm(), 1e-12) << trial << " " << k;
    }
  }
}

TEST(UniformSpline, LeastDistanceMatchesDenseSampling) {
  const Random random(5, "test.spline");
  for (std::uint32_t trial = 0; trial < 20; ++trial) {
    const auto curve = [&](std::uint32_t which, int num) {
      std::vector<Vector3> points;
      for (int i = 0; i < num; ++i) {
        const std::uint32_t at = 100 * which + 3 * static_cast<std::uint32_t>(i);
        points.emplace_back(random.uniform(-3, 3, trial, at), random.uniform(-3, 3, trial, at + 1),
                            random.uniform(-1, 1, trial, at + 2));
      }
      return UniformSpline(points, 0.5);
    };
    const UniformSpline a = curve(0, 4 + static_cast<int>(trial % 4)), b = curve(1, 6);
    double least_m = 1e9;
    const double end_s = std::max(a.duration_s(), b.duration_s());
    for (double t_s = 0.0; t_s <= end_s; t_s += 2e-4)
      least_m = std::min(least_m, (a.at(t_s).p_m - b.at(t_s).p_m).norm());
    EXPECT_NEAR(least_distance_m(a, b), least_m, 1e-2) << trial;
  }
}

}  // namespace
}  // namespace swiftlet
