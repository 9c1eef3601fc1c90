// SPDX-License-Identifier: BSD-3-Clause
// Maps against lists of their cells.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/map/voxel_map.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

using Centers = std::vector<Vector3>;

Centers sorted(Centers centers) {
  std::sort(centers.begin(), centers.end(), [](const Vector3& a, const Vector3& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  });
  return centers;
}

Centers occupied_cells(const OccupancyView& view, const Vector3& half_m) {
  Centers all;
  const double edge_m = view.edge_m();
  const Eigen::Vector3i n = (half_m / edge_m).array().ceil().cast<int>();
  for (int x = -n.x(); x < n.x(); ++x) {
    for (int y = -n.y(); y < n.y(); ++y) {
      for (int z = -n.z(); z < n.z(); ++z) {
        const Vector3 c_m = edge_m * Vector3(x + 0.5, y + 0.5, z + 0.5);
        if (view.state(c_m) == CellState::kOccupied) all.push_back(c_m);
      }
    }
  }
  return all;
}

double gap_m(const Vector3& p_m, const Vector3& cell_m, double edge_m) {
  return ((p_m - cell_m).cwiseAbs().array() - 0.5 * edge_m).max(0.0).matrix().norm();
}

/// Distance from the start of a segment to a cell, negative when the segment misses it.
double distance_to_cell_m(const Vector3& from_m, const Vector3& to_m, const Vector3& cell_m, double edge_m) {
  double first = 0.0, last = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double length = to_m[axis] - from_m[axis], a = (cell_m[axis] - 0.5 * edge_m - from_m[axis]) / length,
                 b = (cell_m[axis] + 0.5 * edge_m - from_m[axis]) / length;
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first <= last ? first * (to_m - from_m).norm() : -1.0;
}

/// Every query about occupied cells, against all occupied cells one by one.
void expect_answers_of(const OccupancyView& view, const Centers& all, double half_m, std::uint32_t seed) {
  const Random random(seed, "test.questions");
  const double edge_m = view.edge_m();
  int hits = 0, misses = 0;
  for (std::uint32_t k = 0; k < 120; ++k) {
    const auto point = [&](std::uint32_t i) {
      return Vector3(random.uniform(-half_m, half_m, k, i), random.uniform(-half_m, half_m, k, i + 1),
                     random.uniform(-0.6 * half_m, 0.6 * half_m, k, i + 2));
    };
    const Vector3 p_m = point(0), q_m = point(3);
    const double radius_m = random.uniform(0.05, 0.7 * half_m, k, 6);
    Centers found, within, in_box;
    double nearest_m = radius_m, clearance_m = radius_m;
    const Vector3 own_m = ((p_m.array() / edge_m).floor() + 0.5) * edge_m;
    const Vector3 low_m = p_m.cwiseMin(q_m), high_m = p_m.cwiseMax(q_m);
    double first_m = 1e9;
    Vector3 first_cell_m = Vector3::Zero();
    for (const Vector3& c_m : all) {
      if (gap_m(p_m, c_m, edge_m) <= radius_m) within.push_back(c_m);
      nearest_m = std::min(nearest_m, gap_m(p_m, c_m, edge_m));
      clearance_m = std::min(clearance_m, (c_m - own_m).norm());
      const bool above = (c_m.array() + 0.5 * edge_m >= low_m.array()).all(),
                 below = (c_m.array() - 0.5 * edge_m <= high_m.array()).all();
      if (above && below) in_box.push_back(c_m);
      const double distance_m = distance_to_cell_m(p_m, q_m, c_m, edge_m);
      if (distance_m >= 0.0 && distance_m < first_m) {
        first_m = distance_m;
        first_cell_m = c_m;
      }
    }
    view.occupied_within(p_m, radius_m, kEver, found);
    const Centers found_within = sorted(found), expected_within = sorted(within);
    ASSERT_EQ(found_within.size(), expected_within.size()) << k;
    for (std::size_t i = 0; i < found.size(); ++i) ASSERT_LT((found_within[i] - expected_within[i]).norm(), 1e-9);
    view.occupied_in(low_m, high_m, found);
    ASSERT_EQ(found.size(), in_box.size()) << k;
    EXPECT_NEAR(view.distance_m(p_m, radius_m), nearest_m, 1e-9) << k;
    EXPECT_NEAR(view.clearance_m(p_m, radius_m), clearance_m, 1e-9) << k;
    const auto hit = view.first_hit(p_m, q_m);
    ASSERT_EQ(hit.has_value(), first_m < 1e8) << k;
    ++(hit ? hits : misses);
    if (!hit) continue;
    EXPECT_NEAR(hit->distance_m, first_m, 1e-9) << k;
    EXPECT_LT((hit->center_local_m - first_cell_m).norm(), 1e-9) << k;
  }
  EXPECT_GT(std::min(hits, misses), 1);
  const auto inside = view.first_hit(all.front(), all.front());
  EXPECT_TRUE(inside && inside->distance_m == 0.0) << "a segment within an occupied cell";
}

template <class Ray>
std::vector<Ray> returns_around(std::uint32_t seed, int num, double half_m) {
  const Random random(seed, "test.returns");
  std::vector<Ray> rays;
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(num); ++i) {
    const Vector3 end_m(random.uniform(-half_m, half_m, i, 0), random.uniform(-half_m, half_m, i, 1),
                        random.uniform(-0.6 * half_m, 0.6 * half_m, i, 2));
    rays.push_back({(0.999 * end_m).cast<float>(), end_m.cast<float>(), true});
  }
  return rays;
}

TEST(PlainMaps, OccupancyMapMatchesCellList) {
  for (const double edge_m : {0.1, 0.25}) {
    OccupancyMapConfig config;
    config.edge_m = edge_m;
    config.keep_radius_m = config.range_max_m = 10.0;
    config.distance_max_m = 8.0 * edge_m;
    const auto map = make_occupancy_map(config);
    map->insert(returns_around<OccupancyMap::Ray>(1, 160, 4.0), 1);
    const Centers all = occupied_cells(*map, {4.5, 4.5, 2.5});
    ASSERT_GT(all.size(), 100U);
    expect_answers_of(*map, all, 4.0, 2);
  }
}

OccupancyMap::Ray straight_to(const Vector3& end_m) {
  return {(end_m - Vector3(0.01, 0, 0)).cast<float>(), end_m.cast<float>(), true};
}

TEST(PlainMaps, KeepAllBlocksWithinTheRadius) {
  OccupancyMapConfig config;
  config.edge_m = 0.25;
  config.keep_radius_m = config.range_max_m = 16.0;
  const auto map = make_occupancy_map(config);
  Centers ends_m;
  for (int x = -9; x < 9; ++x) {
    for (int y = -9; y < 9; ++y) {
      for (int z = -9; z < 9; ++z) {
        const Vector3 end_m = 2.0 * Vector3(x, y, z) + Vector3(0.6, 0.6, 0.6);
        if ((2.0 * Vector3(x + 0.5, y + 0.5, z + 0.5)).norm() < 15.9) ends_m.push_back(end_m);
      }
    }
  }
  std::vector<OccupancyMap::Ray> rays;
  for (const Vector3& end_m : ends_m) {
    rays.push_back(straight_to(end_m));
  }
  map->keep_around(Vector3::Zero());
  map->insert(rays, 1);
  for (const Vector3& end_m : ends_m) {
    ASSERT_EQ(map->state(end_m), CellState::kOccupied) << end_m.transpose();
  }
}

TEST(PlainMaps, KeepRemainingValuesWhenScrolling) {
  VoxelMapConfig config;
  config.size_m = {12.0, 9.0, 7.0};
  VoxelMap map(config);
  std::map<std::tuple<int, int, int>, float> known;
  const Random random(8, "test.scroll");
  Vector3 center_m = Vector3::Zero();
  for (std::uint32_t k = 0; k < 15; ++k) {
    for (std::uint32_t i = 0; i < 40; ++i) {
      const Cell cell =
          map.grid().min_cell + Cell(static_cast<int>(random.uniform(0, map.grid().size.x(), k, 3 * i)),
                                     static_cast<int>(random.uniform(0, map.grid().size.y(), k, 3 * i + 1)),
                                     static_cast<int>(random.uniform(0, map.grid().size.z(), k, 3 * i + 2)));
      const auto value = static_cast<float>(random.uniform(-900.0, 0.0, k, 200 + i));
      map.set(map.grid().index(cell), value);
      known[{cell.x(), cell.y(), cell.z()}] = value;
    }
    center_m += Vector3(random.uniform(-6, 6, k, 300), random.uniform(-6, 6, k, 301), random.uniform(-5, 5, k, 302));
    map.follow(center_m);
    // The vehicle stays near the center.
    const Cell center = map.grid().min_cell + map.grid().size / 2;
    ASSERT_LE((map.grid().cell_of(center_m) - center).cwiseAbs().maxCoeff(), 16);
    std::erase_if(known, [&](const auto& entry) {
      const auto& [x, y, z] = entry.first;
      return !map.grid().contains(Cell(x, y, z));
    });
    std::ptrdiff_t occupied = 0;
    for (std::ptrdiff_t i = 0; i < map.grid().num_cells(); ++i) {
      const Cell cell = map.grid().cell(i);
      const auto found = known.find({cell.x(), cell.y(), cell.z()});
      const float expected = found == known.end() ? -740.0F : found->second;
      ASSERT_EQ(map.value(i), expected) << k;
      occupied += expected >= -300.0F ? 1 : 0;
    }
    ASSERT_EQ(map.num_occupied(), occupied) << k;
  }
}

TEST(PlainMaps, ListCentersOfSufficientlyCertainVoxels) {
  VoxelMapConfig config;
  config.extent = VoxelMapConfig::Extent::kBounded;
  config.size_m = {3.0, 2.0, 1.0};
  VoxelMap map(config);
  const Random random(9, "test.sure");
  for (std::ptrdiff_t i = 0; i < map.grid().num_cells(); ++i)
    map.set(i, static_cast<float>(random.uniform(-1000.0, 300.0, static_cast<std::uint32_t>(i), 0)));
  for (const VoxelState at_least :
       {VoxelState::kFree, VoxelState::kUncertain, VoxelState::kTentative, VoxelState::kConfident}) {
    Centers found, expected;
    map.append_centers(at_least, found);
    for (std::ptrdiff_t i = 0; i < map.grid().num_cells(); ++i) {
      if (map.state(i) >= at_least) expected.push_back(map.grid().center_m(map.grid().cell(i)));
    }
    EXPECT_EQ(found, expected);
  }
}

}  // namespace
}  // namespace swiftlet
