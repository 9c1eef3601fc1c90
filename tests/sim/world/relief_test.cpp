// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/relief.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/sim/world/world_support.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kWavelength_m = 16.0;

/// Contribution of one octave, in -1..1: the difference of two reliefs, each divided by its sum of weights.
double octave_at(int octave, double x_m, double y_m, double amplitude_m = 3.0) {
  const auto sum_of = [&](int octaves) {
    if (octaves == 0) return 0.0;
    const Relief relief({.amplitude_m = amplitude_m, .wavelength_m = kWavelength_m, .octaves = octaves}, 5);
    return relief.height_m(x_m, y_m) / amplitude_m * (2.0 - std::pow(0.5, octaves - 1));
  };
  return (sum_of(octave + 1) - sum_of(octave)) * std::pow(2.0, octave);
}

TEST(Relief, SumsOctavesHalvingWavelengthAndHeight) {
  for (const int octave : {0, 1, 2, 3}) {
    const double cell_m = kWavelength_m / std::pow(2.0, octave);
    std::vector<double> lattice;
    for (int column = -10; column < 10; ++column) {
      for (int row = -10; row < 10; ++row) lattice.push_back(octave_at(octave, cell_m * column, cell_m * row));
    }
    test::expect_uniform(lattice, -1.0, 1.0);
    // Between lattice points: the blend 6 t^5 - 15 t^4 + 10 t^3 along both axes.
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

TEST(Relief, AmplitudeScalesIndependentOctaves) {
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

TEST(Relief, GroundCellsMatchTheRelief) {
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

}  // namespace
}  // namespace swiftlet::sim
