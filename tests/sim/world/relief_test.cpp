// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/relief.hpp"

#include <gtest/gtest.h>

#include <set>

#include "swiftlet/sim/world/mesh_builder.hpp"

namespace swiftlet::sim {
namespace {

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

TEST(Relief, IsSmoothWithinItsAmplitude) {
  const Relief relief({.amplitude_m = 2.0, .wavelength_m = 20.0, .octaves = 4}, 3);
  double lowest = 1e9, highest = -1e9, steepest = 0;
  for (double x = -60; x < 60; x += 0.7) {
    for (double y = -60; y < 60; y += 0.9) {
      const double z = relief.height_m(x, y);
      lowest = std::min(lowest, z), highest = std::max(highest, z);
      steepest = std::max(steepest, std::abs(relief.height_m(x + 1e-3, y) - z) / 1e-3);
    }
  }
  EXPECT_GE(lowest, -2.0);
  EXPECT_LE(highest, 2.0);
  EXPECT_GT(highest - lowest, 1.0);
  EXPECT_EQ(Relief({.amplitude_m = 0.0}, 1).height_m(3.0, 4.0), 0.0);
  // An octave of height a and wavelength w rises by at most 2 a 15/8 / w; four octaves of halves add up to 4 times that
  // over the sum of their weights, 15/8.
  EXPECT_LE(steepest, 4 * 2.0 * 2.0 * (15.0 / 8.0) / 20.0 / (15.0 / 8.0) + 1e-3);
}

TEST(Relief, CoversRectangleAndSurroundingRing) {
  const Relief flat_relief({.amplitude_m = 0.0}, 1), hills({.amplitude_m = 2.0}, 1);
  const Eigen::Vector2d low(-10.0, -6.5), high(10.0, 6.5);
  constexpr double kWidth_m = 40.0;
  for (const bool flat : {true, false}) {
    const Mesh ground = make_ground(flat ? flat_relief : hills, flat, low, high, 1.3);
    const Mesh around = make_ground_around(flat ? flat_relief : hills, flat, low, high, 1.3, kWidth_m);
    // Seen from above.
    const auto covered_m2 = [](const Mesh& mesh) {
      double sum_m2 = 0.0;
      for (const auto& [a, b, c] : mesh.triangles) {
        const float twice_m2 = (mesh.vertices_mesh_m[b] - mesh.vertices_mesh_m[a])
                                   .cross(mesh.vertices_mesh_m[c] - mesh.vertices_mesh_m[a])
                                   .z();
        EXPECT_GT(twice_m2, 0.0F);
        sum_m2 += 0.5 * twice_m2;
      }
      return sum_m2;
    };
    const double inner_m2 = 20.0 * 13.0, outer_m2 = (20.0 + 2 * kWidth_m) * (13.0 + 2 * kWidth_m);
    EXPECT_NEAR(covered_m2(ground), inner_m2, 1e-2);
    EXPECT_NEAR(covered_m2(around), outer_m2 - inner_m2, 0.1);
    EXPECT_TRUE(bounds_m(ground).min().head<2>().isApprox(low.cast<float>()));
    EXPECT_TRUE(bounds_m(ground).max().head<2>().isApprox(high.cast<float>()));
    EXPECT_TRUE(bounds_m(around).min().head<2>().isApprox((low.array() - kWidth_m).matrix().cast<float>()));
    EXPECT_TRUE(bounds_m(around).max().head<2>().isApprox((high.array() + kWidth_m).matrix().cast<float>()));
    std::vector<bool> is_used(around.vertices_mesh_m.size());
    for (const auto& triangle : around.triangles) {
      for (const std::uint32_t corner : triangle) is_used.at(corner) = true;
    }
    EXPECT_EQ(std::count(is_used.begin(), is_used.end(), false), 0);
  }
}

}  // namespace
}  // namespace swiftlet::sim
