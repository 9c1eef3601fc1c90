// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/relief.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/sim/world/world_support.hpp"

namespace swiftlet::sim {
namespace {

using Eigen::Vector2d;

constexpr double kWavelength_m = 16.0;

/// What an octave alone adds, in -1..1: the difference of two reliefs, each divided by its sum of weights.
double octave_at(int octave, double x_m, double y_m, double amplitude_m = 3.0) {
  const auto sum_of = [&](int octaves) {
    if (octaves == 0) return 0.0;
    const Relief relief({.amplitude_m = amplitude_m, .wavelength_m = kWavelength_m, .octaves = octaves}, 5);
    return relief.height_m(x_m, y_m) / amplitude_m * (2.0 - std::pow(0.5, octaves - 1));
  };
  return (sum_of(octave + 1) - sum_of(octave)) * std::pow(2.0, octave);
}

TEST(Relief, IsASumOfOctavesOfHalfTheWavelengthAndHalfTheHeightEach) {
  for (const int octave : {0, 1, 2, 3}) {
    const double cell_m = kWavelength_m / std::pow(2.0, octave);
    std::vector<double> lattice;
    for (int column = -10; column < 10; ++column) {
      for (int row = -10; row < 10; ++row) lattice.push_back(octave_at(octave, cell_m * column, cell_m * row));
    }
    test::expect_uniform(lattice, -1.0, 1.0);
    // Between its lattice: the blend 6 t^5 - 15 t^4 + 10 t^3 along both axes.
    const Random random(3, "test.relief");
    for (std::uint32_t i = 0; i < 40; ++i) {
      const double x = random.uniform(-9.0, 9.0, i, 0), y = random.uniform(-9.0, 9.0, i, 1);
      const double u = x - std::floor(x), v = y - std::floor(y);
      const auto blend = [](double t) { return 6.0 * std::pow(t, 5) - 15.0 * std::pow(t, 4) + 10.0 * std::pow(t, 3); };
      double expected = 0.0;
      for (const int dx : {0, 1}) {
        for (const int dy : {0, 1}) {
          expected += (dx == 1 ? blend(u) : 1.0 - blend(u)) * (dy == 1 ? blend(v) : 1.0 - blend(v)) *
                      octave_at(octave, cell_m * (std::floor(x) + dx), cell_m * (std::floor(y) + dy));
        }
      }
      EXPECT_NEAR(octave_at(octave, cell_m * x, cell_m * y), expected, 1e-9);
    }
  }
}

TEST(Relief, OctavesHaveNothingInCommonAndTheAmplitudeScalesThem) {
  double product = 0.0, n = 0.0;
  for (int column = -15; column < 15; ++column) {
    for (int row = -15; row < 15; ++row, n += 1.0) {
      product += octave_at(0, kWavelength_m * column, kWavelength_m * row) *
                 octave_at(1, 0.5 * kWavelength_m * column, 0.5 * kWavelength_m * row);
    }
  }
  EXPECT_NEAR(product / n, 0.0, 5.0 / 3.0 / std::sqrt(n));
  EXPECT_NEAR(octave_at(0, 3.0, 7.0, 1.0), octave_at(0, 3.0, 7.0, 5.0), 1e-9);
  EXPECT_EQ(Relief({.amplitude_m = 0.0}, 1).height_m(3.0, 4.0), 0.0);
}

std::set<float> lines_of(const Mesh& mesh, int axis) {
  std::set<float> lines;
  for (const Eigen::Vector3f& vertex : mesh.vertices_mesh_m) lines.insert(vertex[axis]);
  return lines;
}

TEST(Relief, GroundHasTheFewestEvenCellsNoLargerThanToldAndItsHeightsAreThoseOfTheRelief) {
  const Relief hills({.amplitude_m = 2.0, .wavelength_m = 12.0, .octaves = 3}, 4);
  struct Case {
    double cell_m;
    std::size_t across, along;
  };
  for (const auto& [cell_m, across, along] : {Case{2.5, 4, 3}, {2.49, 5, 4}, {3.4, 3, 3}, {50.0, 1, 1}}) {
    const Mesh ground = make_ground(hills, false, {-4.0, 3.0}, {6.0, 10.5}, cell_m);
    EXPECT_EQ(lines_of(ground, 0).size(), across + 1) << cell_m;
    EXPECT_EQ(lines_of(ground, 1).size(), along + 1) << cell_m;
    EXPECT_EQ(ground.triangles.size(), 2 * across * along);
    for (const Eigen::Vector3f& vertex : ground.vertices_mesh_m)
      EXPECT_NEAR(vertex.z(), hills.height_m(vertex.x(), vertex.y()), 1e-4);
  }
  EXPECT_EQ(make_ground(hills, true, {-4.0, 3.0}, {6.0, 10.5}, 0.5).triangles.size(), 2U)
      << "flat ground is a rectangle";
}

TEST(Relief, SurroundingsMeetTheGroundInTheSameCornersAndGrowByAQuarterUpToEightMeters) {
  const Relief hills({.amplitude_m = 2.0, .wavelength_m = 12.0, .octaves = 3}, 4);
  const Vector2d low(-4.1, 3.3), high(6.2, 10.7);
  for (const double cell_m : {0.7, 3.1}) {
    const double width_m = 70.0;
    const Mesh ground = make_ground(hills, false, low, high, cell_m);
    const Mesh around = make_ground_around(hills, false, low, high, cell_m, width_m);
    std::set<std::array<float, 3>> corners;
    for (const Eigen::Vector3f& v : around.vertices_mesh_m) {
      corners.insert({v.x(), v.y(), v.z()});
      EXPECT_NEAR(v.z(), hills.height_m(v.x(), v.y()), 1e-3);
    }
    EXPECT_EQ(corners.size(), around.vertices_mesh_m.size()) << "no corner is there twice";
    const auto box = Eigen::AlignedBox2f(low.cast<float>(), high.cast<float>());
    for (const Eigen::Vector3f& v : ground.vertices_mesh_m) {
      const bool inside = v.x() > box.min().x() + 1e-3F && v.x() < box.max().x() - 1e-3F &&
                          v.y() > box.min().y() + 1e-3F && v.y() < box.max().y() - 1e-3F;
      EXPECT_EQ(corners.contains({v.x(), v.y(), v.z()}), !inside);  // bit by bit
    }
    for (const int axis : {0, 1}) {
      const std::set<float> inner = lines_of(ground, axis), all = lines_of(around, axis);
      std::vector<float> steps(all.upper_bound(*inner.rbegin()), all.end());
      float before = *inner.rbegin();
      double step = (high[axis] - low[axis]) / static_cast<double>(inner.size() - 1), out = 0.0;
      for (const float line : steps) {
        out = std::min(out + step, width_m);
        EXPECT_NEAR(line - *inner.rbegin(), out, 1e-3) << axis;
        EXPECT_GT(line, before);
        before = line;
        step = std::min(1.25 * step, 8.0);
      }
      EXPECT_NEAR(before - *inner.rbegin(), width_m, 1e-3);
      // And mirrored on the other side.
      std::vector<float> mirrored(all.begin(), all.lower_bound(*inner.begin()));
      ASSERT_EQ(mirrored.size(), steps.size());
      for (std::size_t i = 0; i < steps.size(); ++i) {
        EXPECT_NEAR(*inner.begin() - mirrored[mirrored.size() - 1 - i], steps[i] - *inner.rbegin(), 1e-3);
      }
    }
  }
  // Cells that are larger than 8 m already stay as they are; flat ground has one step.
  const Mesh coarse = make_ground_around(hills, false, {0, 0}, {40, 40}, 10.0, 30.0);
  EXPECT_EQ(lines_of(coarse, 0), (std::set<float>{-30, -20, -10, 0, 10, 20, 30, 40, 50, 60, 70}));
  const Mesh flat = make_ground_around(hills, true, {0, 0}, {40, 40}, 10.0, 30.0);
  EXPECT_EQ(lines_of(flat, 0), (std::set<float>{-30, 0, 40, 70}));
  EXPECT_EQ(flat.triangles.size(), 16U);
}

}  // namespace
}  // namespace swiftlet::sim
