// SPDX-License-Identifier: BSD-3-Clause
// Maps against lists of their cells: what is near, what is hit, what is kept, and what it takes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/map/overlaid_occupancy.hpp"
#include "swiftlet/core/map/sparse_voxel_map.hpp"
#include "swiftlet/core/map/voxel_map.hpp"
#include "swiftlet/core/math/random.hpp"
#include "tests/support/allocation_counter.hpp"

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
double way_to_cell_m(const Vector3& from_m, const Vector3& to_m, const Vector3& cell_m, double edge_m) {
  double first = 0.0, last = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double way = to_m[axis] - from_m[axis], a = (cell_m[axis] - 0.5 * edge_m - from_m[axis]) / way,
                 b = (cell_m[axis] + 0.5 * edge_m - from_m[axis]) / way;
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first <= last ? first * (to_m - from_m).norm() : -1.0;
}

/// Every question about what is occupied, against all occupied cells one by one.
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
    Centers told, within, in_box;
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
      const double way_m = way_to_cell_m(p_m, q_m, c_m, edge_m);
      if (way_m >= 0.0 && way_m < first_m) {
        first_m = way_m;
        first_cell_m = c_m;
      }
    }
    view.occupied_within(p_m, radius_m, kEver, told);
    const Centers told_within = sorted(told), expected_within = sorted(within);
    ASSERT_EQ(told_within.size(), expected_within.size()) << k;
    for (std::size_t i = 0; i < told.size(); ++i) ASSERT_LT((told_within[i] - expected_within[i]).norm(), 1e-9);
    view.occupied_in(low_m, high_m, told);
    ASSERT_EQ(told.size(), in_box.size()) << k;
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
    OccupancyMap map(config);
    map.insert(returns_around<OccupancyMap::Ray>(1, 160, 4.0), 1);
    const Centers all = occupied_cells(map, {4.5, 4.5, 2.5});
    ASSERT_GT(all.size(), 100U);
    expect_answers_of(map, all, 4.0, 2);
  }
}

TEST(PlainMaps, SparseMapMatchesVoxelList) {
  SparseVoxelMapConfig config;
  config.keep_radius_m = 10.0;
  SparseVoxelMap map(config);
  map.insert(returns_around<SparseVoxelMap::Ray>(3, 160, 4.0), 1);
  const Centers all = occupied_cells(map, {4.5, 4.5, 2.5});
  ASSERT_GT(all.size(), 100U);
  expect_answers_of(map, all, 4.0, 4);
}

TEST(PlainMaps, OverlaidPlacesMatchTheirCells) {
  OccupancyMapConfig config;
  config.edge_m = 0.25;
  config.keep_radius_m = config.range_max_m = 10.0;
  OccupancyMap map(config);
  map.insert(returns_around<OccupancyMap::Ray>(5, 60, 4.0), 1);
  const std::vector<KeepOut> places = {KeepOut::box({1.03, -0.52, 0.21}, {1.37, 0.93, 1.11}),
                                       KeepOut::column({-1.27, 1.08, -0.34}, 1.63, 2.17),
                                       KeepOut::box({1.61, -0.13, 0.47}, {0.71, 0.83, 0.93})};
  const OverlaidOccupancy view(map, places);
  const Random random(6, "test.overlaid");
  const Centers below = occupied_cells(map, {4.5, 4.5, 2.5});
  Centers all = below;
  for (int x = -18; x < 18; ++x) {
    for (int y = -18; y < 18; ++y) {
      for (int z = -10; z < 10; ++z) {
        const Vector3 c_m = 0.25 * Vector3(x + 0.5, y + 0.5, z + 0.5);
        bool in = false;
        for (std::size_t i = 0; i < places.size(); ++i) {
          const Vector3 to_m = (c_m - places[i].center_local_m).cwiseAbs();
          in = in || (i == 1 ? std::hypot(to_m.x(), to_m.y()) <= 0.815 && to_m.z() <= 1.085
                             : (to_m.array() <= 0.5 * places[i].size_m.array()).all());
        }
        const bool was = map.state(c_m) == CellState::kOccupied;
        ASSERT_EQ(view.state(c_m) == CellState::kOccupied, in || was) << c_m.transpose();
        if (in && !was) all.push_back(c_m);
      }
    }
  }
  ASSERT_GT(all.size(), below.size() + 100U);
  for (std::uint32_t k = 0; k < 80; ++k) {
    const Vector3 p_m(random.uniform(-3, 3, k, 0), random.uniform(-3, 3, k, 1), random.uniform(-2, 2, k, 2));
    const Vector3 q_m(random.uniform(-3, 3, k, 3), random.uniform(-3, 3, k, 4), random.uniform(-2, 2, k, 5));
    const double radius_m = random.uniform(0.1, 2.0, k, 6);
    Centers told;
    view.occupied_within(p_m, radius_m, kEver, told);
    const auto in_ball =
        std::count_if(all.begin(), all.end(), [&](const Vector3& c_m) { return gap_m(p_m, c_m, 0.25) <= radius_m; });
    EXPECT_EQ(std::ssize(told), in_ball) << k;
    const Vector3 low_m = p_m.cwiseMin(q_m), high_m = p_m.cwiseMax(q_m);
    view.occupied_in(low_m, high_m, told);
    const auto in_box = std::count_if(all.begin(), all.end(), [&](const Vector3& c_m) {
      return (c_m.array() + 0.125 >= low_m.array()).all() && (c_m.array() - 0.125 <= high_m.array()).all();
    });
    EXPECT_EQ(std::ssize(told), in_box) << k;
    // Distances are those to the places themselves.
    double least_m = map.distance_m(p_m, radius_m), clear_m = map.clearance_m(p_m, radius_m);
    const Vector3 own_m = ((p_m.array() / 0.25).floor() + 0.5) * 0.25;
    for (const KeepOut& place : places) {
      least_m = std::min(least_m, place.distance_m(p_m));
      clear_m = std::min(clear_m, place.distance_m(own_m));
    }
    EXPECT_NEAR(view.distance_m(p_m, radius_m), least_m, 1e-12);
    EXPECT_NEAR(view.clearance_m(p_m, radius_m), clear_m, 1e-12);
    auto first = map.first_hit(p_m, q_m);
    double first_m = first ? first->distance_m : 1e9;
    bool by_place = false;
    for (const KeepOut& place : places) {
      const auto enters = place.entered_after_m(p_m, q_m);
      if (!enters || *enters >= first_m) continue;
      first_m = *enters;
      by_place = true;
    }
    const auto hit = view.first_hit(p_m, q_m);
    ASSERT_EQ(hit.has_value(), first_m < 1e8);
    if (!hit) continue;
    EXPECT_NEAR(hit->distance_m, first_m, 1e-12);
    const Vector3 at_m = p_m + first_m * (q_m - p_m).normalized();
    const Vector3 cell_m = by_place ? Vector3(((at_m.array() / 0.25).floor() + 0.5) * 0.25) : first->center_local_m;
    EXPECT_LT((hit->center_local_m - cell_m).norm(), 0.26) << "rounding may decide between two cells";
  }
  // A place at a point, and one that is met along an axis only.
  const KeepOut box = KeepOut::box({0, 0, 0}, {1, 1, 1}), column = KeepOut::column({0, 0, 0}, 1, 1);
  for (const KeepOut& place : {box, column}) {
    EXPECT_EQ(place.entered_after_m({0.1, 0.1, 0.1}, {0.1, 0.1, 0.1}).value_or(-1.0), 0.0);
    EXPECT_FALSE(place.entered_after_m({2, 0, 0}, {2, 0, 0}));
    EXPECT_NEAR(place.entered_after_m({0.2, 0.2, 3}, {0.2, 0.2, -3}).value_or(-1.0), 2.5, 1e-12);
    EXPECT_FALSE(place.entered_after_m({0.6, 0.2, 3}, {0.6, 0.2, -3}));
    EXPECT_NEAR(place.entered_after_m({-3, 0, 0.2}, {3, 0, 0.2}).value_or(-1.0), 2.5, 1e-12);
    EXPECT_FALSE(place.entered_after_m({-3, 0, 0.6}, {3, 0, 0.6}));
    EXPECT_FALSE(place.entered_after_m({-3, 0, 0}, {-1, 0, 0}));
    EXPECT_TRUE(place.contains({0.5, 0, 0.5}));
    EXPECT_FALSE(place.contains({0.5001, 0, 0}));
    EXPECT_NEAR(place.distance_m({1.5, 0, 1.5}), std::sqrt(2.0), 1e-12);
  }
}

// ---- what is kept, and for how long

OccupancyMap::Ray straight_to(const Vector3& end_m) {
  return {(end_m - Vector3(0.01, 0, 0)).cast<float>(), end_m.cast<float>(), true};
}

TEST(PlainMaps, KeepAllBlocksWithinTheRadius) {
  OccupancyMapConfig config;
  config.edge_m = 0.25;
  config.keep_radius_m = config.range_max_m = 16.0;
  OccupancyMap map(config);
  SparseVoxelMapConfig sparse_config;
  sparse_config.edge_m = 0.25;
  sparse_config.keep_radius_m = 16.0;
  SparseVoxelMap sparse(sparse_config);
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
  std::vector<SparseVoxelMap::Ray> sparse_rays;
  for (const Vector3& end_m : ends_m) {
    rays.push_back(straight_to(end_m));
    sparse_rays.push_back({rays.back().origin_local_m, rays.back().end_local_m, true});
  }
  map.keep_around(Vector3::Zero());
  map.insert(rays, 1);
  sparse.insert(sparse_rays, 1);
  sparse.keep_around(Vector3::Zero());
  for (const Vector3& end_m : ends_m) {
    ASSERT_EQ(map.state(end_m), CellState::kOccupied) << end_m.transpose();
    ASSERT_EQ(sparse.state(end_m), CellState::kOccupied) << end_m.transpose();
  }
  EXPECT_EQ(sparse.num_blocks(), ends_m.size());
}

// ---- what it takes

// ---- the dense maps

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
    const VoxelGrid before = map.grid();
    map.follow(center_m);
    // The map scrolls when the vehicle is 16 voxels or more from its center, along any axis.
    const Cell wanted = Cell((center_m.array() / 0.25).floor().cast<int>()) - before.size / 2;
    const bool moves = (wanted - before.min_cell).cwiseAbs().maxCoeff() >= 16;
    ASSERT_EQ(map.grid().min_cell, moves ? wanted : before.min_cell);
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
    Centers told, expected;
    map.append_centers(at_least, told);
    for (std::ptrdiff_t i = 0; i < map.grid().num_cells(); ++i) {
      if (map.state(i) >= at_least) expected.push_back(map.grid().center_m(map.grid().cell(i)));
    }
    EXPECT_EQ(told, expected);
  }
}

}  // namespace
}  // namespace swiftlet
