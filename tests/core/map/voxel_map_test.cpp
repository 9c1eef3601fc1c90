// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/voxel_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

VoxelMapConfig small_box(const Vector3& size_m = {6.0, 5.0, 4.0}) {
  VoxelMapConfig config;
  config.extent = VoxelMapConfig::Extent::kBounded;
  config.size_m = size_m;
  return config;
}

Vector3 random_point(const Random& random, std::uint32_t i, const Vector3& size_m) {
  Vector3 p;
  for (int a = 0; a < 3; ++a) p[a] = (random.uniform(i, a) - 0.5) * size_m[a];
  return p;
}

TEST(VoxelMap, FollowsEquation12) {
  for (const double g : {0.0, -740.0, -1000.0}) {
    for (const double n : {0.25, 1.0, 2.5, 7.75, 40.0}) {
      VoxelMap one(small_box()), many(small_box());
      one.update(7, n, g);
      for (int i = 0; i < 5; ++i) many.update(7, 0.2 * n, g);
      EXPECT_NEAR(one.value(7), many.value(7), 1e-3) << n << " updates towards " << g;
      EXPECT_NEAR(one.value(7), std::exp2(-n) * -740.0 + (1.0 - std::exp2(-n)) * g, 1e-3);
    }
  }
}

TEST(VoxelMap, SetsExactValueAtInfiniteWeight) {
  VoxelMap map(small_box());
  map.update(3, 2.5, 0.0);
  map.update(3, kInfinity, -740.0);
  EXPECT_EQ(map.value(3), -740.0F);
}

TEST(VoxelMap, FreesRowsLikeSingleVoxels) {
  const Random random(1, "row");
  VoxelMap row(small_box()), single(small_box());
  std::vector<float> n(20);
  const Cell first = row.grid().min_cell + Cell(2, 3, 4);
  for (int repeat = 0; repeat < 5; ++repeat) {
    for (int i = 0; i < 20; ++i) {
      n[i] = i % 3 == 0 ? 0.0F : static_cast<float>(std::pow(10.0, 6.0 * random.uniform(repeat, i) - 4.0));
      const double points = 10.0 * random.uniform(repeat, 100 + i);
      for (VoxelMap* map : {&row, &single}) map->update(map->grid().index(first) + i, points, 0.0);
    }
    std::vector<float> before(20);
    for (int i = 0; i < 20; ++i) before[i] = row.value(row.grid().index(first) + i);
    row.move_to_free(first, n);
    for (int i = 0; i < 20; ++i) single.update(single.grid().index(first) + i, n[i], -1000.0);
    for (int i = 0; i < 20; ++i) {
      const std::ptrdiff_t at = row.grid().index(first) + i;
      EXPECT_NEAR(row.value(at), single.value(at), 1e-3);
      if (n[i] == 0.0F) {
        EXPECT_EQ(row.value(at), before[i]);
      }
    }
    EXPECT_EQ(row.num_occupied(), single.num_occupied());
  }
}

TEST(VoxelMap, CopiesAllVoxelsExceptUnknown) {
  VoxelMap map(small_box());
  map.set(3, 0.0F);
  map.set(40, -200.0F);
  map.set(41, -740.0F);
  map.set(77, -999.0F);
  map.set(78, static_cast<float>(kInfinity));
  MapVoxels copy;
  map.append_voxels(copy);
  ASSERT_EQ(copy.size(), 4u);
  EXPECT_EQ(copy.edge_m, 0.25);
  EXPECT_EQ(copy.centers_local_m[1], map.grid().center_m(map.grid().cell(40)).cast<float>());
  EXPECT_EQ(copy.states.at(copy.state[0]), "confident");
  EXPECT_EQ(copy.states.at(copy.state[1]), "tentative");
  EXPECT_EQ(copy.states.at(copy.state[2]), "free");
  EXPECT_EQ(copy.states.at(copy.occupied_from), "tentative");
  EXPECT_EQ(copy.value[2], -999.0F);
  EXPECT_EQ(copy.value[3], static_cast<float>(kInfinity));
}

TEST(VoxelMap, ThresholdsBelongToTheStateAbove) {  // eq. (7)
  VoxelMap map(small_box());
  EXPECT_EQ(map.state_of(-0.1F), VoxelState::kConfident);
  EXPECT_EQ(map.state_of(-0.2F), VoxelState::kTentative);
  EXPECT_EQ(map.state_of(-300.0F), VoxelState::kTentative);
  EXPECT_EQ(map.state_of(-301.0F), VoxelState::kUncertain);
  EXPECT_EQ(map.state_of(-750.0F), VoxelState::kUncertain);
  EXPECT_EQ(map.state_of(-750.1F), VoxelState::kFree);
  EXPECT_EQ(map.state_at({100.0, 0.0, 0.0}), VoxelState::kUncertain);
  EXPECT_EQ(map.state_at(Vector3::Constant(std::nan(""))), VoxelState::kUncertain);
}

TEST(VoxelMap, WhatIsKnownBeforehandNeverChanges) {
  PriorMap prior;
  prior.occupied_world_m = {{0.1F, 0.1F, 0.1F}, {1e30F, 0.0F, 0.0F}};
  prior.free_world_m = {{1.1F, 0.1F, 0.1F}, {0.1F, 0.1F, 0.1F}};
  VoxelMap map(small_box());
  map.set_prior(prior);
  const std::ptrdiff_t occupied = map.grid().index(map.grid().cell_of({0.1, 0.1, 0.1}));
  const std::ptrdiff_t free = map.grid().index(map.grid().cell_of({1.1, 0.1, 0.1}));
  for (const double g : {0.0, -740.0, -1000.0}) {
    for (const double n : {1.0, 1e9, kInfinity}) {
      map.update(occupied, n, g);
      map.update(free, n, g);
    }
  }
  const std::vector<float> much(24, 1e9F);
  map.move_to_free({map.grid().min_cell.x(), 0, 0}, much);
  EXPECT_EQ(map.value(occupied), std::numeric_limits<float>::infinity());
  EXPECT_EQ(map.value(free), -std::numeric_limits<float>::infinity());
  EXPECT_EQ(map.state(occupied), VoxelState::kConfident);
  EXPECT_EQ(map.state(free), VoxelState::kFree);
}

TEST(VoxelMap, CountsRejectedPriorVoxels) {
  PriorMap prior;
  prior.occupied_world_m = {{0.1F, 0.1F, 0.1F}, {0.15F, 0.1F, 0.1F}, {900.0F, 0.0F, 0.0F}, {1e30F, 0.0F, 0.0F}};
  prior.free_world_m = {{1.1F, 0.1F, 0.1F}, {0.0F, 0.0F, -900.0F}};
  VoxelMap bounded(small_box());
  bounded.set_prior(prior);
  EXPECT_EQ(bounded.num_prior(), 5U) << "two points lie in one voxel";
  EXPECT_EQ(bounded.num_prior_outside(), 3U);

  VoxelMapConfig config = small_box({20.0, 20.0, 10.0});
  config.extent = VoxelMapConfig::Extent::kScrolling;
  VoxelMap scrolling(config);
  scrolling.set_prior(prior);
  EXPECT_EQ(scrolling.num_prior_outside(), 0U) << "a scrolling map can reach all prior voxels";
  prior.occupied_world_m = {{900.0F, 0.0F, 0.0F}, {901.0F, 0.0F, 0.0F}};
  prior.free_world_m.clear();
  scrolling.set_prior(prior);
  EXPECT_EQ(scrolling.num_prior_outside(), 2U);
  scrolling.follow({30.0, 0.0, 0.0});
  EXPECT_EQ(scrolling.num_prior_outside(), 2U);
  scrolling.follow({895.0, 0.0, 0.0});
  EXPECT_EQ(scrolling.num_prior_outside(), 0U);
  EXPECT_EQ(scrolling.num_occupied(), 2);
}

TEST(VoxelMap, MatchesBruteForceForOccupiedVoxels) {
  const Random random(1, "map");
  const VoxelMapConfig config = small_box({20.0, 9.0, 5.0});  // rows of more than one word
  VoxelMap map(config);
  for (std::uint32_t i = 0; i < 600; ++i) {
    const Vector3 p = random_point(random, i, config.size_m);
    map.update(map.grid().index(map.grid().cell_of(p)), 16.0 * random.uniform(i, 5), 0.0);
    if (i % 5 == 0) map.update(map.grid().index(map.grid().cell_of(p)), 1.0, -1000.0);
  }
  std::vector<Vector3> centers;
  for (std::ptrdiff_t i = 0; i < map.grid().num_cells(); ++i) {
    if (map.state(i) >= VoxelState::kTentative) centers.push_back(map.grid().center_m(map.grid().cell(i)));
  }
  std::vector<Vector3> found;
  map.append_centers(VoxelState::kTentative, found);
  ASSERT_EQ(found, centers);
  ASSERT_EQ(map.num_occupied(), static_cast<std::ptrdiff_t>(centers.size()));

  for (std::uint32_t i = 0; i < 300; ++i) {
    const Vector3 p = random_point(random, 1000 + i, 1.2 * config.size_m);
    const double radius_m = 3.0 * random.uniform(1000 + i, 3);
    double nearest_m = kInfinity;
    bool confident = false;
    for (const Vector3& c : centers) {
      nearest_m = std::min(nearest_m, (c - p).norm());
      confident = confident || ((c - p).norm() <= radius_m && map.state_at(c) == VoxelState::kConfident);
    }
    EXPECT_EQ(map.occupied_within(p, radius_m), nearest_m <= radius_m);
    EXPECT_EQ(map.any_within(p, radius_m, VoxelState::kConfident), confident);
  }
  for (const double bad : {std::nan(""), kInfinity, -kInfinity, 1e300}) {
    EXPECT_FALSE(map.occupied_within({bad, 0.0, 0.0}, 1.0));
    EXPECT_FALSE(map.occupied_within({0.0, bad, 0.0}, 1.0));
  }
}

TEST(VoxelMap, ScrollsAndForgetsWhatItLeaves) {
  VoxelMapConfig config = small_box({20.0, 20.0, 10.0});
  config.extent = VoxelMapConfig::Extent::kScrolling;
  PriorMap prior;
  prior.occupied_world_m = {{14.1F, 0.1F, 0.1F}};  // outside at first
  VoxelMap map(config);
  map.set_prior(prior);
  const auto mark = [&](const Vector3& p) { map.update(map.grid().index(map.grid().cell_of(p)), 20.0, 0.0); };
  mark({9.0, 1.0, 1.0});
  mark({-9.0, 1.0, 1.0});
  mark({3.0, -8.0, -2.0});
  const auto state = [&](double x, double y, double z) { return map.state_at({x, y, z}); };

  map.follow({1.0, 1.0, 0.5});  // too little to move
  EXPECT_EQ(state(-9.0, 1.0, 1.0), VoxelState::kConfident);
  map.follow({7.0, -3.0, 1.0});
  EXPECT_EQ(state(9.0, 1.0, 1.0), VoxelState::kConfident);
  EXPECT_EQ(state(3.0, -8.0, -2.0), VoxelState::kConfident);
  EXPECT_EQ(state(14.1, 0.1, 0.1), VoxelState::kConfident);  // known background enters with the box
  EXPECT_EQ(map.num_occupied(), 3);
  map.follow({0.0, 0.0, 0.0});
  EXPECT_EQ(state(-9.0, 1.0, 1.0), VoxelState::kUncertain);  // forgotten
  EXPECT_EQ(state(9.0, 1.0, 1.0), VoxelState::kConfident);
  map.follow({1000.0, 0.0, 0.0});
  EXPECT_EQ(map.num_occupied(), 0);
  map.follow(Vector3::Constant(std::nan("")));
  EXPECT_EQ(state(1000.0, 0.0, 0.0), VoxelState::kUncertain);
}

TEST(VoxelMap, ABoundedMapStays) {
  VoxelMap map(small_box());
  const Cell before = map.grid().min_cell;
  map.follow({100.0, 0.0, 0.0});
  EXPECT_EQ(map.grid().min_cell, before);
}

TEST(VoxelGrid, IndexesPointsByTheirCell) {
  const Random random(9, "grid");
  const VoxelGrid grid = VoxelGrid::covering({0.3, -7.0, 100.0}, {9.0, 4.0, 3.0}, 0.1);
  int inside = 0;
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    Vector3 p(12.0 * random.uniform(i, 0) - 6.0, 6.0 * random.uniform(i, 1) - 10.0, 4.0 * random.uniform(i, 2) + 98.0);
    if (i % 3 == 0) p.x() = 0.1 * static_cast<int>(10.0 * p.x());  // on a face
    if (i % 3 == 1) p.x() = -1e-20;
    ASSERT_EQ(grid.index_of(p), grid.contains(p) ? grid.index(grid.cell_of(p)) : -1);
    inside += grid.contains(p);
  }
  EXPECT_GT(inside, 1000);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  for (const Vector3& p : {Vector3(kNaN, -7.0, 100.0), Vector3(0.0, kInf, 100.0), Vector3(0.0, -7.0, -1e300)}) {
    EXPECT_EQ(grid.index_of(p), -1);
  }
}

}  // namespace
}  // namespace swiftlet
