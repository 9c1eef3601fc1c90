// SPDX-License-Identifier: BSD-3-Clause
// Times along paths and curves, written down once more.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/planning/path_timing.hpp"

namespace swiftlet {
namespace {

using WayPoints = std::vector<Vector3>;

/// A point every 0.1 m or less, then three averages over as many points on both sides as there are.
WayPoints plain_rounded(const WayPoints& corners, double sigma_m) {
  WayPoints points;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const double length_m = (corners[i + 1] - corners[i]).norm();
    const int parts = std::max(1, static_cast<int>(std::ceil(length_m / 0.1)));
    for (int k = 0; k < parts; ++k) points.push_back(corners[i] + (corners[i + 1] - corners[i]) * (1.0 * k / parts));
  }
  points.push_back(corners.back());
  const auto wide = static_cast<std::size_t>(std::lround(sigma_m / 0.1));
  for (int pass = 0; pass < 3; ++pass) {
    const WayPoints before = points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::size_t room = std::min({wide, i, points.size() - 1 - i});
      Vector3 sum = Vector3::Zero();
      for (std::size_t k = i - room; k <= i + room; ++k) sum += before[k];
      points[i] = sum / (2.0 * static_cast<double>(room) + 1.0);
    }
  }
  return points;
}

std::vector<double> plain_speeds(const WayPoints& points, const PathLimits& limits) {
  const std::size_t n = points.size();
  std::vector<double> v(n, limits.speed_mps), a(n, limits.acceleration_mps2);
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3 in = points[i] - points[i < 2 ? 0 : i - 2], out = points[std::min(i + 2, n - 1)] - points[i];
    const double length_m = 0.5 * (in.norm() + out.norm());
    if (length_m < 1e-9) continue;
    // How much the direction changes by the meter, in the plane and against the vertical.
    const Vector3 bend = (out.normalized() - in.normalized()) / length_m, along = (in + out).normalized();
    if (bend.head<2>().norm() > 1e-9)
      v[i] = std::min(v[i], std::sqrt(limits.acceleration_mps2 / bend.head<2>().norm()));
    if (std::abs(bend.z()) > 1e-9)
      v[i] = std::min(v[i], std::sqrt(limits.vertical_acceleration_mps2 / std::abs(bend.z())));
    if (std::abs(along.z()) > 1e-9) {
      v[i] = std::min(v[i], limits.vertical_speed_mps / std::abs(along.z()));
      a[i] = std::min(a[i], limits.vertical_acceleration_mps2 / std::abs(along.z()));
    }
  }
  v[0] = v[n - 1] = 0.0;
  for (std::size_t i = 1; i < n; ++i) {
    v[i] = std::min(v[i], std::sqrt(v[i - 1] * v[i - 1] + 2.0 * a[i] * (points[i] - points[i - 1]).norm()));
  }
  for (std::size_t i = n - 1; i-- > 0;) {
    v[i] = std::min(v[i], std::sqrt(v[i + 1] * v[i + 1] + 2.0 * a[i] * (points[i + 1] - points[i]).norm()));
  }
  return v;
}

/// Where one is every 0.2 s.
WayPoints plain_samples(const WayPoints& points, const std::vector<double>& v) {
  std::vector<double> times = {0.0};
  for (std::size_t i = 1; i < points.size(); ++i) {
    times.push_back(times.back() + (points[i] - points[i - 1]).norm() / std::max(0.5 * (v[i] + v[i - 1]), 1e-3));
  }
  WayPoints samples = {points.front()};
  std::size_t i = 1;
  for (int k = 1; 0.2 * k <= times.back(); ++k) {
    while (times[i] < 0.2 * k) ++i;
    samples.push_back(points[i - 1] +
                      (points[i] - points[i - 1]) * ((0.2 * k - times[i - 1]) / (times[i] - times[i - 1])));
  }
  samples.push_back(points.back());
  return samples;
}

TEST(PlainTiming, OfRandomWaysIsTheSame) {
  const Random random(3, "test.ways");
  for (std::uint32_t trial = 0; trial < 60; ++trial) {
    WayPoints corners = {{0, 0, 2}};
    const std::uint32_t num = 2 + trial % 4;
    for (std::uint32_t i = 1; i < num; ++i) {
      const Vector3 leg(random.uniform(-6, 6, trial, 4 * i), random.uniform(-6, 6, trial, 4 * i + 1),
                        trial % 3 == 0 ? 0.0 : random.uniform(-3, 3, trial, 4 * i + 2));
      corners.push_back(corners.back() + (trial % 5 == 0 ? 0.05 : 1.0) * leg);
    }
    const PathLimits limits{random.uniform(0.5, 4.0, trial, 100), random.uniform(0.3, 2.0, trial, 101),
                            random.uniform(0.3, 3.0, trial, 102), random.uniform(0.2, 2.0, trial, 103)};
    for (const double least_m : {0.6, 0.3, 0.0}) {
      // What is asked is where the widest roundings lead: none, the first or the first two are refused.
      const double free_m = least_m;
      const WayPoints wide = plain_rounded(corners, 0.6), narrow = plain_rounded(corners, 0.3);
      const auto is_free = [&](const Vector3& p_m) {
        const auto of = [&](const WayPoints& way) {
          return std::any_of(way.begin(), way.end(), [&](const Vector3& q) { return (q - p_m).norm() < 1e-9; });
        };
        return free_m == 0.6 ? true : free_m == 0.3 ? of(narrow) : false;
      };
      const auto found = time_path(corners, limits, is_free, least_m);
      if (free_m == 0.3 && std::all_of(wide.begin(), wide.end(), is_free)) continue;  // straight: both are one
      ASSERT_TRUE(found) << trial << " " << least_m;
      const WayPoints points = plain_rounded(corners, free_m),
                      samples = plain_samples(points, plain_speeds(points, limits));
      EXPECT_EQ(found->interval_s, 0.2);
      ASSERT_NEAR(static_cast<double>(found->control_points_m.size()), static_cast<double>(samples.size()), 1.0);
      if (found->control_points_m.size() != samples.size()) continue;  // the end at a multiple of 0.2 s
      for (std::size_t i = 0; i < samples.size(); ++i) {
        ASSERT_LT((found->control_points_m[i] - samples[i]).norm(), 1e-8) << trial << " " << least_m << " " << i;
      }
      const Vector3 leg = corners[1] - corners[0];
      EXPECT_NEAR(found->yaw_rad, std::atan2(leg.y(), leg.x()), 1e-12);
      EXPECT_FALSE(free_m < 0.6 && time_path(corners, limits, is_free, 0.6)) << "no narrower than it may";
    }
  }
}

/// Basis functions by their recursion [de Boor]; knots at whole numbers.
double basis(int i, int degree, double t) {
  if (degree == 0) return t >= i && t < i + 1 ? 1.0 : 0.0;
  return (t - i) / degree * basis(i, degree - 1, t) + (i + degree + 1 - t) / degree * basis(i + 1, degree - 1, t);
}

TEST(PlainTiming, ASplineIsTheSumOfItsBasis) {
  const Random random(4, "test.spline");
  for (std::uint32_t trial = 0; trial < 40; ++trial) {
    WayPoints points;
    for (std::uint32_t i = 0; i <= trial % 7; ++i) {
      points.emplace_back(random.uniform(-5, 5, trial, 3 * i), random.uniform(-5, 5, trial, 3 * i + 1),
                          random.uniform(-5, 5, trial, 3 * i + 2));
    }
    const double interval_s = 0.1 + 0.1 * (trial % 4);
    const UniformSpline spline(points, interval_s);
    // The first and the last three times.
    WayPoints all(2, points.front());
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
      const auto state = spline.at(t_s);
      ASSERT_LT((state.p_m - place(t_s)).norm(), 1e-12) << trial << " " << k;
      constexpr double kStep_s = 1e-4;
      const Vector3 v = (place(t_s + kStep_s) - place(t_s - kStep_s)) / (2 * kStep_s);
      const Vector3 a = (place(t_s + kStep_s) - 2.0 * place(t_s) + place(t_s - kStep_s)) / (kStep_s * kStep_s);
      ASSERT_LT((state.v_mps - v).norm(), 1e-2) << trial << " " << k;
      ASSERT_LT((state.a_mps2 - a).norm(), 1.0) << trial << " " << k;
    }
  }
}

TEST(PlainTiming, TheLeastDistanceOfTwoCurvesIsThatOfAFinerLook) {
  const Random random(5, "test.spline");
  for (std::uint32_t trial = 0; trial < 20; ++trial) {
    const auto curve = [&](std::uint32_t which, int num) {
      WayPoints points;
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
  // At its very beginning, and at the end of the longer one.
  const UniformSpline still({{0, 0, 0}}, 0.5), away({{1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, 0.5),
      toward({{5, 0, 0}, {3, 0, 0}, {1, 0, 0}}, 0.5);
  EXPECT_NEAR(least_distance_m(still, away), 1.0, 1e-9);
  EXPECT_NEAR(least_distance_m(still, toward), 1.0, 1e-9);
  EXPECT_NEAR(least_distance_m(still, still), 0.0, 1e-12);
}

}  // namespace
}  // namespace swiftlet
