// SPDX-License-Identifier: BSD-3-Clause
// Grids of probability against closed forms.
#include "core/slam/matching/hybrid_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/slam/matching/grid_submaps.hpp"

namespace swiftlet {
namespace {

double odds(double p) { return p / (1.0 - p); }

TEST(GridValue, SpansItsProbabilitiesEvenly) {
  EXPECT_EQ(grid_value::value_of(0.0), grid_value::value_of(0.1));
  EXPECT_EQ(grid_value::value_of(1.0), grid_value::value_of(0.9));
  EXPECT_EQ(grid_value::probability_of(grid_value::kUnknown), 0.1);
  for (int value = 1; value <= 32767; ++value) {
    const auto v = static_cast<std::uint16_t>(value);
    EXPECT_EQ(grid_value::value_of(grid_value::probability_of(v)), value);
  }
}

// After n hits the odds are those of one hit to the power n, within the range of values.
TEST(OddsTable, MultipliesOdds) {
  for (const double p : {0.55, 0.49, 0.7, 0.3}) {
    const OddsTable table(p);
    std::uint16_t value = grid_value::kUnknown;
    for (int n = 1; n <= 60; ++n) {
      value = table.after(value);
      const double expected = std::pow(odds(p), n) / (1.0 + std::pow(odds(p), n));
      EXPECT_NEAR(grid_value::probability_of(value), std::clamp(expected, 0.1, 0.9), 2e-5 * n) << p << " " << n;
    }
  }
}

TEST(HybridGrid, CentersCellsAtMultiplesOfResolution) {
  const HybridGrid grid(0.45);
  EXPECT_EQ(grid.cell_at({0.0, 0.22, -0.22}), Eigen::Vector3i::Zero());
  EXPECT_EQ(grid.cell_at({0.23, -0.23, 0.67}), Eigen::Vector3i(1, -1, 1));
  EXPECT_EQ(grid.center_m({2, -1, 0}), Vector3(0.9, -0.45, 0.0));
}

TEST(HybridGrid, IsIndependentOfPointOrder) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal(0.0, 2.0);
  std::vector<Vector3> points_m(3000);
  for (Vector3& p_m : points_m) p_m = {normal(random), normal(random), normal(random)};
  std::vector<Vector3> shuffled_m = points_m;
  std::shuffle(shuffled_m.begin(), shuffled_m.end(), random);
  const OddsTable hit(0.55), miss(0.49);
  HybridGrid one(0.2), other(0.2);
  for (int scan = 0; scan < 3; ++scan) {
    one.insert(points_m, {0, 0, 0}, hit, miss, 2);
    other.insert(shuffled_m, {0, 0, 0}, hit, miss, 2);
  }
  for (int x = -40; x <= 40; ++x) {
    for (int y = -40; y <= 40; ++y) {
      for (int z = -40; z <= 40; ++z) ASSERT_EQ(one.value({x, y, z}), other.value({x, y, z}));
    }
  }
}

TEST(HybridGrid, IsEmptyAfterItWasCleared) {
  HybridGrid grid(0.2);
  const OddsTable hit(0.55), miss(0.49);
  const std::vector<Vector3> points_m{{1, 2, 3}, {-1, 0, 5}};
  grid.insert(points_m, {0, 0, 0}, hit, miss, 2);
  EXPECT_EQ(grid.value({5, 10, 15}), grid_value::value_of(0.55));
  grid.clear();
  EXPECT_EQ(grid.value({5, 10, 15}), grid_value::kUnknown);
  EXPECT_EQ(grid.num_blocks(), 0U);
  grid.insert(points_m, {0, 0, 0}, hit, miss, 2);
  EXPECT_EQ(grid.value({5, 10, 15}), grid_value::value_of(0.55));
}

HybridGrid random_grid(double resolution_m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  HybridGrid grid(resolution_m);
  const OddsTable hit(0.7), miss(0.4);
  for (int scan = 0; scan < 6; ++scan) {
    std::vector<Vector3> points_m(1500);
    for (Vector3& p_m : points_m) p_m = {uniform(random), uniform(random), uniform(random)};
    grid.insert(points_m, {0, 0, 0}, hit, miss, 2);
  }
  return grid;
}

TEST(HybridGrid, InterpolatesCellCentersExactlyWithoutSlope) {
  const HybridGrid grid = random_grid(0.25, 5);
  for (int x = -9; x <= 9; ++x) {
    for (int y = -9; y <= 9; ++y) {
      for (int z = -9; z <= 9; ++z) {
        const HybridGrid::Interpolated at = grid.interpolate(grid.center_m({x, y, z}));
        ASSERT_NEAR(at.probability, grid.probability({x, y, z}), 1e-12);
        ASSERT_LT(at.slope_1_m.norm(), 1e-9);
      }
    }
  }
}

TEST(HybridGrid, InterpolatesSmoothlyWithConsistentSlope) {
  const HybridGrid grid = random_grid(0.25, 6);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-2.2, 2.2);
  constexpr double kStep_m = 1e-5;
  for (int trial = 0; trial < 2000; ++trial) {
    Vector3 p_m(uniform(random), uniform(random), uniform(random));
    // Half of them within a step of the border between two polynomials.
    if (trial % 2 == 0) p_m(trial / 2 % 3) = 0.25 * std::round(p_m(trial / 2 % 3) / 0.25) + 0.3 * kStep_m;
    const HybridGrid::Interpolated at = grid.interpolate(p_m);
    EXPECT_GE(at.probability, 0.1);
    EXPECT_LE(at.probability, 0.9);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 step_m = kStep_m * Vector3::Unit(axis);
      const double numeric =
          (grid.interpolate(p_m + step_m).probability - grid.interpolate(p_m - step_m).probability) / (2.0 * kStep_m);
      EXPECT_NEAR(at.slope_1_m(axis), numeric, 3e-3) << "the second derivative is up to 6 x 0.8 / 0.25^2 = 77 per m^2";
    }
  }
}

// ---- submaps

std::vector<Vector3> around(const Vector3& middle_m, double range_m, int num = 200) {
  std::vector<Vector3> points_m;
  for (int i = 0; i < num; ++i) {
    const double angle = 2.0 * M_PI * i / num;
    points_m.push_back(middle_m + range_m * Vector3(std::cos(angle), std::sin(angle), 0.01));
  }
  return points_m;
}

TEST(GridSubmaps, FillBothAndMatchTheOlder) {
  GridSubmapConfig config;
  config.scans = 4;
  GridSubmaps submaps(config);
  EXPECT_TRUE(submaps.empty());
  std::vector<int> of_older, num_active;
  std::vector<double> begun_at_m;
  for (int scan = 1; scan <= 14; ++scan) {
    const Vector3 at_m(scan, 0, 0);
    submaps.insert(around(at_m, 3.0), at_m);
    of_older.push_back(submaps.older().num_scans);
    num_active.push_back(submaps.num_active());
    begun_at_m.push_back(submaps.older().origin_local_m.x());
  }
  EXPECT_EQ(of_older, (std::vector<int>{1, 2, 3, 4, 5, 6, 7, 8, 5, 6, 7, 8, 5, 6}));
  EXPECT_EQ(num_active, (std::vector<int>{1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2}));
  EXPECT_EQ(begun_at_m, (std::vector<double>{1, 1, 1, 1, 1, 1, 1, 1, 5, 5, 5, 5, 9, 9}));
  EXPECT_EQ(submaps.newer().num_scans, 2);
  EXPECT_EQ(submaps.newer().origin_local_m.x(), 13.0);
}

TEST(GridSubmaps, RestrictFarPointsToCoarseGrid) {
  GridSubmaps submaps(GridSubmapConfig{});
  const Vector3 at_m(5, 0, 0);
  std::vector<Vector3> points_m{{5, 19.9, 0}, {5, 20.1, 0}};
  submaps.insert(points_m, at_m);
  const GridSubmap& submap = submaps.older();
  const auto known = [&](const HybridGrid& grid, const Vector3& p_local_m) {
    return grid.value(grid.cell_at(p_local_m - submap.origin_local_m)) != grid_value::kUnknown;
  };
  EXPECT_TRUE(known(submap.high, points_m[0]));
  EXPECT_FALSE(known(submap.high, points_m[1]));
  EXPECT_TRUE(known(submap.low, points_m[0]));
  EXPECT_TRUE(known(submap.low, points_m[1]));
}

TEST(GridSubmaps, KeepMemoryBoundedOverDistance) {
  GridSubmapConfig config;
  config.scans = 10;
  GridSubmaps submaps(config);
  std::size_t early = 0;
  for (int scan = 0; scan < 400; ++scan) {
    const Vector3 at_m(0.5 * scan, 0, 0);
    submaps.insert(around(at_m, 8.0), at_m);
    if (scan == 40) early = submaps.bytes();
  }
  EXPECT_LE(submaps.bytes(), 2 * early);
}

}  // namespace
}  // namespace swiftlet
