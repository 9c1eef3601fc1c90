// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/ray_lengths.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "swiftlet/core/math/random.hpp"
#include "tests/bench/reference_detection.hpp"

namespace swiftlet {
namespace {

using Lengths = std::map<std::array<int, 3>, double>;

Lengths walked(const Vector3& origin, const Vector3& direction, double length_m, double edge_m) {
  Lengths out;
  reference::walk(origin, direction, length_m, edge_m, [&](const Eigen::Vector3i& cell, double length) {
    out[{cell.x(), cell.y(), cell.z()}] += length;
  });
  return out;
}

double total(const RayLengths& rays) {
  double sum = 0.0;
  for (const Cell& cell : rays.cells()) sum += rays.length_m(cell);
  return sum;
}

Vector3 random_direction(const Random& random, std::uint32_t i) {
  const auto n = random.normal3(i, 0);
  return Vector3(n[0], n[1], n[2]).normalized();
}

Eigen::AlignedBox3d box_around(const Vector3& p) { return {Vector3(p.array() - 0.5), Vector3(p.array() + 0.5)}; }

TEST(RayLengths, MatchVoxelTraversalInEveryVoxel) {
  const Random random(2, "rays");
  RayLengths rays;
  for (std::uint32_t i = 0; i < 500; ++i) {
    const Vector3 origin(random.uniform(i, 1) - 0.5, random.uniform(i, 2) - 0.5, random.uniform(i, 3) - 0.5);
    const Vector3 direction = random_direction(random, i);
    const double edge_m = i % 2 == 0 ? 0.25 : 0.1, length_m = 3.0 * random.uniform(i, 4);
    rays.begin(Eigen::AlignedBox3d(origin), length_m, edge_m);
    rays.add(origin, direction, length_m);
    Lengths expected = walked(origin, direction, length_m, edge_m);
    for (const Cell& cell : rays.cells()) expected.try_emplace({cell.x(), cell.y(), cell.z()}, 0.0);
    for (const auto& [cell, length] : expected) {
      ASSERT_NEAR(rays.length_m({cell[0], cell[1], cell[2]}), length, 1e-4) << "ray " << i;
    }
  }
}

TEST(RayLengths, AreExactAlongAxesAndDiagonals) {
  RayLengths rays;
  const Vector3 origin(0.1, 0.1, 0.1);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      rays.begin(box_around(origin), 5.0, 0.25);
      rays.add(origin, sign * Vector3::Unit(axis), 1.0);
      Cell cell = Cell::Zero();
      EXPECT_NEAR(rays.length_m(cell), sign > 0.0 ? 0.15 : 0.1, 1e-6);
      cell[axis] += static_cast<int>(sign);
      EXPECT_NEAR(rays.length_m(cell), 0.25, 1e-6);
      EXPECT_NEAR(total(rays), 1.0, 1e-6);
    }
  }
  // Along the diagonal of the lattice a voxel is crossed corner to corner.
  rays.begin(box_around(Vector3::Zero()), 5.0, 0.25);
  rays.add(Vector3::Constant(0.0), Vector3::Constant(1.0 / std::sqrt(3.0)), 3.0);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(rays.length_m(Cell::Constant(i)), 0.25 * std::sqrt(3.0), 1e-5);
}

// Rays of a long-range sensor in a map that ends before them: the same lengths, in the map.
TEST(RayLengths, IgnoreCellsOutsideTheMap) {
  const Random random(4, "rays");
  const VoxelGrid map = VoxelGrid::covering({1.0, -2.0, 0.5}, {14.0, 9.0, 4.0}, 0.25);
  const Vector3 origin(0.3, -0.2, 1.0);
  RayLengths cut, whole;
  cut.begin(box_around(origin), 30.0, 0.25, &map);
  whole.begin(box_around(origin), 30.0, 0.25);
  for (std::uint32_t i = 0; i < 3000; ++i) {
    const Vector3 from = origin + 0.4 * Vector3(random.uniform(i, 1), random.uniform(i, 2), random.uniform(i, 3));
    Vector3 direction = random_direction(random, i);
    if (i < 6) direction = (i < 3 ? 1.0 : -1.0) * Vector3::Unit(i % 3);
    const double length_m = 30.0 * random.uniform(i, 7);
    cut.add(from, direction, length_m);
    whole.add(from, direction, length_m);
  }
  for (std::ptrdiff_t i = 0; i < map.num_cells(); ++i) {
    ASSERT_EQ(cut.length_m(map.cell(i)), whole.length_m(map.cell(i))) << map.cell(i).transpose();
  }
  EXPECT_LT(cut.window().num_cells(), 2 * map.num_cells());
}

// An origin may lie beside the map, as that of a beam does when the sensor flies at its border.
TEST(RayLengths, FollowRaysEnteringFromOutside) {
  const VoxelGrid map = VoxelGrid::covering({5.0, 0.0, 0.0}, {8.0, 4.0, 4.0}, 0.25);
  RayLengths rays;
  const Vector3 origin(-3.0, 0.1, 0.1);
  rays.begin(box_around(origin), 20.0, 0.25, &map);
  rays.add(origin, Vector3::UnitX(), 20.0);
  EXPECT_NEAR(rays.length_m({8, 0, 0}), 0.25, 1e-5);
  EXPECT_NEAR(rays.length_m({35, 0, 0}), 0.25, 1e-5);
}

TEST(RayLengths, ManyRaysAddUp) {
  const Random random(3, "rays");
  RayLengths rays;
  const Vector3 origin(0.3, -0.2, 5.0);
  rays.begin(box_around(origin), 20.0, 0.25);
  double sum = 0.0;
  Lengths expected;
  for (std::uint32_t i = 0; i < 5000; ++i) {
    const double length_m = 20.0 * random.uniform(i, 7);
    rays.add(origin, random_direction(random, i), length_m);
    sum += length_m;
    reference::walk(origin, random_direction(random, i), length_m, 0.25, [&](const Eigen::Vector3i& c, double length) {
      expected[{c.x(), c.y(), c.z()}] += length;
    });
  }
  EXPECT_NEAR(total(rays), sum, 1e-4 * sum);
  for (const auto& [cell, length] : expected) {
    ASSERT_NEAR(rays.length_m({cell[0], cell[1], cell[2]}), length, 1e-3 + 1e-4 * length);
  }
}

TEST(RayLengths, UpdateTheMapByEquation22) {
  VoxelMapConfig config;
  config.extent = VoxelMapConfig::Extent::kBounded;
  config.size_m = {4.0, 4.0, 4.0};
  VoxelMap map(config);
  RayLengths rays;
  const Vector3 origin(0.1, 0.1, 0.1);
  rays.begin(box_around(origin), 20.0, 0.25);
  for (int i = 0; i < 10; ++i) rays.add(origin, Vector3::UnitX(), 20.0);  // leaves the map
  rays.apply(0.1, map);
  const double n = 0.1 * 10.0 * 0.25 / 0.25;
  for (std::ptrdiff_t i = 0; i < map.grid().num_cells(); ++i) {
    const Cell cell = map.grid().cell(i);
    const bool on_ray = cell.y() == 0 && cell.z() == 0 && cell.x() >= 1;
    if (cell == Cell::Zero()) continue;
    EXPECT_NEAR(map.value(i), on_ray ? std::exp2(-n) * -740.0 - (1.0 - std::exp2(-n)) * 1000.0 : -740.0, 1e-3);
  }
  rays.begin(box_around(origin), 20.0, 0.25);
  EXPECT_TRUE(rays.cells().empty());  // a sweep starts from nothing
}

TEST(RayLengths, IgnoreDegenerateRays) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  RayLengths rays;
  rays.add(Vector3::Zero(), Vector3::UnitX(), 1.0);  // before any sweep
  rays.begin(box_around(Vector3::Zero()), 20.0, 0.25);
  for (const double bad : {kNaN, kInf, -kInf}) {
    rays.add({bad, 0.0, 0.0}, Vector3::UnitX(), 1.0);
    rays.add(Vector3::Zero(), {0.0, bad, 0.0}, 1.0);
    rays.add(Vector3::Zero(), Vector3::UnitX(), bad);
  }
  rays.add(Vector3::Zero(), Vector3::UnitX(), -1.0);
  rays.add(Vector3::Zero(), Vector3::UnitX(), 0.0);
  rays.add(Vector3::Zero(), Vector3::Zero(), 1.0);
  rays.add(Vector3::Zero(), Vector3::UnitX(), 21.0);
  rays.add({9.0, 0.0, 0.0}, Vector3::UnitX(), 1.0);
  EXPECT_TRUE(rays.cells().empty());
}

}  // namespace
}  // namespace swiftlet
