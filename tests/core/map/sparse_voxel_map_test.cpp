// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/sparse_voxel_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

using Ray = SparseVoxelMap::Ray;

constexpr TimeNs kSweep = kNsPerSecond / 10;

bool is_occupied(SparseVoxelMap& map, const Vector3& p_m, TimeNs now) {
  map.set_time(now);
  return map.state(p_m) == CellState::kOccupied;
}

/// A wall at x = 3 m seen from the origin.
std::vector<Ray> wall() {
  std::vector<Ray> rays;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) rays.push_back({{0, 0, 0}, {3.05F, 0.05F * i + 0.01F, 0.05F * j + 0.01F}, true});
  }
  return rays;
}

TEST(SparseVoxelMap, MarksOnlyTheObservedWall) {
  SparseVoxelMap map({});
  for (int i = 1; i <= 5; ++i) map.insert(wall(), i * kSweep);
  std::vector<Vector3> voxels;
  map.set_time(5 * kSweep);
  map.occupied_within(Vector3::Zero(), 10.0, kEver, voxels);
  ASSERT_FALSE(voxels.empty());
  for (const Vector3& voxel : voxels) {
    EXPECT_NEAR(voxel.x(), 3.1, 1e-9);
    EXPECT_LE(std::abs(voxel.y()), 1.11);
  }
  EXPECT_TRUE(is_occupied(map, {3.05, 0.0, 0.0}, 5 * kSweep));
  EXPECT_FALSE(is_occupied(map, {2.5, 0.0, 0.0}, 5 * kSweep));
}

TEST(SparseVoxelMap, OneReturnMakesOneVoxelKnown) {
  SparseVoxelMap map({});
  map.insert(std::vector<Ray>{{{0, 0, 0}, {3.3F, 1.1F, 0.9F}, true}}, kSweep);
  MapVoxels copy;
  map.append_voxels(copy);
  ASSERT_EQ(copy.size(), 1U);
  EXPECT_LT((copy.centers_local_m[0] - Eigen::Vector3f(3.3F, 1.1F, 0.9F)).cwiseAbs().maxCoeff(), 0.1001F);
}

TEST(SparseVoxelMap, ExportsVoxelsConsistentWithItsQueries) {
  SparseVoxelMap map({});
  for (int i = 1; i <= 5; ++i) map.insert(wall(), i * kSweep);
  map.insert(std::vector<Ray>{{{0, 0, 0}, {6.0F, 0.11F, 0.31F}, true}}, 6 * kSweep);  // passes through the wall
  map.set_time(6 * kSweep);
  MapVoxels copy;
  map.append_voxels(copy);
  std::vector<Vector3> occupied;
  map.occupied_within(Vector3::Zero(), 20.0, kEver, occupied);
  EXPECT_EQ(std::count(copy.state.begin(), copy.state.end(), copy.occupied_from), std::ssize(occupied));
  for (std::size_t i = 0; i < copy.size(); ++i) {
    const CellState state = map.state(copy.centers_local_m[i].cast<double>());
    EXPECT_EQ(copy.states.at(copy.state[i]), state == CellState::kOccupied ? "occupied" : "free");
    EXPECT_NE(state, CellState::kUnknown);
    EXPECT_EQ(copy.value[i] >= 0.8F, state == CellState::kOccupied);
  }
}

TEST(SparseVoxelMap, ReportsChangesSinceARevision) {
  SparseVoxelMapConfig config;
  config.keep_radius_m = 5.0;
  SparseVoxelMap map(config);
  std::vector<VoxelGrid> boxes;
  const auto covers = [&](const Vector3& p_m) {
    return std::any_of(boxes.begin(), boxes.end(), [&](const VoxelGrid& box) { return box.contains(p_m); });
  };
  const std::uint64_t before = map.revision();
  map.insert(wall(), kSweep);
  EXPECT_GT(map.revision(), before);
  ASSERT_TRUE(map.changed_since(before, boxes));
  EXPECT_TRUE(covers({3.05, 0.05, 0.05}));
  EXPECT_FALSE(covers({-3.05, 0.05, 0.05}));

  const std::uint64_t seen = map.revision();
  map.insert(wall(), 2 * kSweep);
  ASSERT_TRUE(map.changed_since(seen, boxes));
  EXPECT_TRUE(boxes.empty()) << "more certain, but the same state";

  map.keep_around({50.0, 0.0, 0.0});
  ASSERT_TRUE(map.changed_since(seen, boxes));
  EXPECT_TRUE(covers({3.05, 0.05, 0.05})) << "forgotten";
  EXPECT_EQ(map.state({3.05, 0.05, 0.05}), CellState::kUnknown);

  config.memory_s = 1.0;
  EXPECT_FALSE(SparseVoxelMap(config).changed_since(0, boxes)) << "forgets by time, without a sweep";
}

TEST(SparseVoxelMap, ClearsGhostsUnlessConservative) {
  SparseVoxelMapConfig conservative;
  conservative.miss_log_odds = 0.0;
  SparseVoxelMap forgets({}), keeps(conservative);
  const std::vector<Ray> leaf = {{{0, 0, 0}, {1.5F, 0.05F, 0.05F}, true}};
  for (int i = 1; i <= 3; ++i) {
    forgets.insert(leaf, i * kSweep);
    keeps.insert(leaf, i * kSweep);
  }
  const Vector3 ghost(1.5, 0.05, 0.05);
  ASSERT_TRUE(is_occupied(forgets, ghost, 3 * kSweep));
  for (int i = 4; i <= 13; ++i) {  // one second of looking at the wall behind
    forgets.insert(wall(), i * kSweep);
    keeps.insert(wall(), i * kSweep);
  }
  EXPECT_FALSE(is_occupied(forgets, ghost, 13 * kSweep));
  EXPECT_EQ(forgets.state(ghost), CellState::kFree);
  EXPECT_TRUE(is_occupied(keeps, ghost, 13 * kSweep));
  EXPECT_TRUE(is_occupied(forgets, {3.05, 0.0, 0.0}, 13 * kSweep));
}

TEST(SparseVoxelMap, ClearsByMissesAndFadesMemory) {
  SparseVoxelMapConfig fading;
  fading.memory_s = 2.0;
  SparseVoxelMap map({}), fades(fading);
  const std::vector<Ray> leaf = {{{0, 0, 0}, {1.5F, 0.05F, 0.05F}, true}};
  map.insert(leaf, kSweep);
  fades.insert(leaf, kSweep);
  const std::vector<Ray> sky = {{{0, 0, 0}, {8.0F, 0.2667F, 0.2667F}, false}};
  for (int i = 2; i <= 10; ++i) map.insert(sky, i * kSweep);
  const Vector3 ghost(1.5, 0.05, 0.05);
  EXPECT_FALSE(is_occupied(map, ghost, 10 * kSweep));
  EXPECT_TRUE(is_occupied(fades, ghost, 10 * kSweep));
  EXPECT_FALSE(is_occupied(fades, ghost, 30 * kSweep));
}

TEST(SparseVoxelMap, PreservesSurfacesAtGrazingAngles) {
  SparseVoxelMap map({});
  std::vector<Ray> ground;
  for (int i = 0; i < 400; ++i) ground.push_back({{0, 0, 1.0F}, {0.5F + 0.02F * i, 0.03F, 0.02F}, true});
  for (int i = 1; i <= 30; ++i) map.insert(ground, i * kSweep);
  for (int i = 0; i < 37; ++i) EXPECT_TRUE(is_occupied(map, {0.6 + 0.2 * i, 0.03, 0.02}, 30 * kSweep)) << i;
}

TEST(SparseVoxelMap, ForgetsDistantBlocksAndReusesMemory) {
  SparseVoxelMapConfig config;
  config.keep_radius_m = 5.0;
  SparseVoxelMap map(config);
  for (int i = 1; i <= 200; ++i) {
    const auto x = static_cast<float>(0.5 * i);
    map.insert(std::vector<Ray>{{{x, 0, 0}, {x + 2.0F, 0.1F, 0.1F}, true}}, i * kSweep);
    map.keep_around({x, 0, 0});
  }
  EXPECT_LE(map.num_blocks(), 10U);
  EXPECT_TRUE(is_occupied(map, {102.0, 0.1, 0.1}, 200 * kSweep));
  EXPECT_FALSE(is_occupied(map, {20.0, 0.1, 0.1}, 200 * kSweep));
}

TEST(SparseVoxelMap, NeverExceedsItsBlockBound) {
  SparseVoxelMapConfig config;
  config.edge_m = 0.2;
  config.keep_radius_m = 7.0;
  config.miss_log_odds = 0.0;
  SparseVoxelMap map(config);
  // A return in every block of a cube around a vehicle that moves.
  std::size_t most_blocks = 0;
  for (int step = 0; step < 5; ++step) {
    const Eigen::Vector3f at(0.4F * static_cast<float>(step), 0.1F, 0.0F);
    std::vector<SparseVoxelMap::Ray> rays;
    rays.reserve(1000);
    for (int i = 0; i < 10 * 10 * 10; ++i) {
      const Eigen::Vector3f place(static_cast<float>(i % 10), static_cast<float>(i / 10 % 10),
                                  static_cast<float>(i / 100));
      rays.push_back({at, at + 1.6F * (place.array() - 4.7F).matrix(), true});
    }
    map.insert(rays, step);
    map.keep_around(at.cast<double>());
    most_blocks = std::max(most_blocks, map.num_blocks());
  }
  EXPECT_GT(most_blocks, 250U);
  constexpr double kBytesOfABlock = 512 * 12;
  const double bound = SparseVoxelMap::most_bytes(config, 100.0);
  EXPECT_GE(bound, static_cast<double>(most_blocks) * kBytesOfABlock);
  EXPECT_LE(bound, 4.0 * static_cast<double>(most_blocks) * kBytesOfABlock) << "and not much more";
  EXPECT_LT(SparseVoxelMap::most_bytes(config, 3.0), 0.5 * bound) << "shorter rays reach less";
}

float log_odds_at(const SparseVoxelMap& map, const Vector3& p_m) {
  MapVoxels copy;
  map.append_voxels(copy);
  for (std::size_t i = 0; i < copy.size(); ++i) {
    if ((copy.centers_local_m[i].cast<double>() - p_m).cwiseAbs().maxCoeff() < 0.1) return copy.value[i];
  }
  return std::nanf("");
}

TEST(SparseVoxelMap, BoundsLogOddsUpdatesPerSweep) {
  const Vector3 at_m(1.5, 0.1, 0.1);
  const Ray hit{{0, 0.1F, 0.1F}, {1.5F, 0.1F, 0.1F}, true}, pass{{0, 0.1F, 0.1F}, {4.5F, 0.1F, 0.1F}, false};
  SparseVoxelMap once({}), often({}), mixed({});
  once.insert(std::vector<Ray>{hit}, kSweep);
  often.insert(std::vector<Ray>{hit, hit, hit}, kSweep);
  mixed.insert(std::vector<Ray>{pass, hit, pass}, kSweep);
  EXPECT_EQ(log_odds_at(often, at_m), log_odds_at(once, at_m));
  EXPECT_EQ(log_odds_at(mixed, at_m), log_odds_at(once, at_m)) << "a voxel that is hit loses nothing in that sweep";
  // However often a voxel was hit, a moment of free sight clears it.
  for (int i = 2; i < 200; ++i) once.insert(std::vector<Ray>{hit}, i * kSweep);
  EXPECT_EQ(once.state(at_m), CellState::kOccupied);
  for (int i = 200; i < 220; ++i) once.insert(std::vector<Ray>{pass}, i * kSweep);
  EXPECT_EQ(once.state(at_m), CellState::kFree);
}

TEST(SparseVoxelMap, ClearsUpToRangeOrHit) {
  SparseVoxelMapConfig config;
  config.clear_range_m = 2.0;
  const auto lost = [&](double voxel_m, float end_m, bool is_hit) {
    SparseVoxelMap map(config);
    map.insert(
        std::vector<Ray>{{{static_cast<float>(voxel_m), 0.1F, 0.1F}, {static_cast<float>(voxel_m), 0.1F, 0.11F}, true}},
        kSweep);
    map.insert(std::vector<Ray>{{{0, 0.1F, 0.1F}, {end_m, 0.1F, 0.1F}, is_hit}}, 2 * kSweep);
    return log_odds_at(map, {voxel_m, 0.1, 0.1}) < 0.8F;
  };
  EXPECT_TRUE(lost(1.9, 9.0F, false));
  EXPECT_FALSE(lost(2.1, 9.0F, false)) << "beyond the range";
  EXPECT_TRUE(lost(1.3, 1.35F, false));
  EXPECT_FALSE(lost(1.5, 1.39F, false));
  // A voxel from 1.2 to 1.4 m before one that is hit: 0.1 m before the end nothing is cleared any more.
  EXPECT_TRUE(lost(1.3, 1.51F, true));
  EXPECT_TRUE(lost(1.3, 1.42F, true)) << "it reaches 0.12 m into it";
  EXPECT_FALSE(lost(1.1, 1.0F, true));
}

TEST(SparseVoxelMap, FiltersHitsByAgeAndMemory) {
  SparseVoxelMapConfig config;
  config.memory_s = 2.0;
  SparseVoxelMap map(config);
  map.insert(std::vector<Ray>{{{0, 0.1F, 0.1F}, {1.5F, 0.1F, 0.1F}, true}}, kNsPerSecond);
  EXPECT_TRUE(is_occupied(map, {1.5, 0.1, 0.1}, 3 * kNsPerSecond));
  EXPECT_FALSE(is_occupied(map, {1.5, 0.1, 0.1}, 3 * kNsPerSecond + 1));
  map.set_time(3 * kNsPerSecond);
  std::vector<Vector3> found;
  map.occupied_within({1.5, 0, 0}, 1.0, kNsPerSecond, found);
  EXPECT_EQ(found.size(), 1U);
  map.occupied_within({1.5, 0, 0}, 1.0, kNsPerSecond + 1, found);
  EXPECT_TRUE(found.empty());
}

TEST(SparseVoxelMap, IgnoresHitsBeyondItsRadius) {
  SparseVoxelMapConfig config;
  config.keep_radius_m = 5.0;
  SparseVoxelMap map(config);
  map.insert(
      std::vector<Ray>{{{0, 0.1F, 0.1F}, {4.99F, 0.1F, 0.1F}, true}, {{0, 0.1F, 0.5F}, {5.01F, 0.1F, 0.5F}, true}},
      kSweep);
  EXPECT_EQ(map.state({4.99, 0.1, 0.1}), CellState::kOccupied);
  EXPECT_EQ(map.state({5.01, 0.1, 0.5}), CellState::kUnknown);
  EXPECT_EQ(map.num_blocks(), 1U);
}

}  // namespace
}  // namespace swiftlet
