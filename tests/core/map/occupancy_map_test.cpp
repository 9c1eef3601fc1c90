// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/occupancy_map.hpp"

#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "swiftlet/core/math/random.hpp"
#include "tests/support/allocation_counter.hpp"

namespace swiftlet {
namespace {

using Beam = OccupancyMap::Ray;

constexpr TimeNs kScan = kNsPerSecond / 10;
const Eigen::Vector3f kOrigin(0.05F, 0.05F, 0.05F);

Beam beam_to(float x, float y, float z) { return {kOrigin, {x, y, z}, true}; }

/// A wall at x = 3 m seen from the origin.
std::vector<Beam> near_wall() {
  std::vector<Beam> rays;
  for (int i = -40; i <= 40; ++i) {
    for (int j = -40; j <= 40; ++j) {
      rays.push_back(beam_to(3.05F, 0.025F * static_cast<float>(i), 0.025F * static_cast<float>(j)));
    }
  }
  return rays;
}

/// A scan of beams in all directions with returns at random.
std::vector<Beam> random_scan(std::uint32_t seed, const Eigen::Vector3f& origin_m, std::uint32_t beams, double far_m) {
  const Random random(seed, "scan");
  std::vector<Beam> rays;
  for (std::uint32_t i = 0; i < beams; ++i) {
    const auto n = random.normal3(0, i);
    const Eigen::Vector3f direction = Vector3(n[0], n[1], 0.5 * n[2]).normalized().cast<float>();
    rays.push_back({origin_m, origin_m + static_cast<float>(random.uniform(0.2, far_m, 1, i)) * direction, true});
  }
  return rays;
}

Cell cell_of(const octomap::OcTreeKey& key) { return Cell(key[0], key[1], key[2]) - Cell::Constant(32768); }

void insert(const std::vector<Beam>& rays, double range_max_m, octomap::OcTree& tree) {
  octomap::Pointcloud cloud;
  for (const Beam& ray : rays) cloud.push_back(ray.end_local_m.x(), ray.end_local_m.y(), ray.end_local_m.z());
  const Eigen::Vector3f& origin = rays.front().origin_local_m;
  tree.insertPointCloud(cloud, {origin.x(), origin.y(), origin.z()}, range_max_m);
}

/// Every cell of both has the same bits.
void expect_equal(const OccupancyMap& map, octomap::OcTree& tree) {
  tree.expand();
  std::size_t count = 0, differ = 0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf, ++count) {
    const Cell cell = cell_of(leaf.getKey());
    const bool occupied = map.state((cell.cast<double>().array() + 0.5) * map.edge_m()) == CellState::kOccupied;
    if (!map.known(cell) || map.log_odds(cell) != leaf->getLogOdds() || occupied != tree.isNodeOccupied(*leaf)) {
      ++differ;
    }
  }
  MapVoxels copy;
  map.append_voxels(copy);
  EXPECT_EQ(differ, 0U);
  EXPECT_EQ(copy.size(), count);
  EXPECT_GT(count, 1000U);
}

// Some rays lie exactly in the planes between cells, some along an axis: there ties and rounding decide.
TEST(OccupancyMap, MatchesTheLibraryInEveryCell) {
  const auto map = make_occupancy_map({});
  octomap::OcTree tree(0.1);
  for (std::uint32_t scan = 0; scan < 8; ++scan) {
    const auto s = static_cast<float>(scan);
    const Eigen::Vector3f origin_m = scan % 4 == 3 ? Eigen::Vector3f(0.1F * s, -0.2F * s, 0.5F)
                                                   : Eigen::Vector3f(0.13F * s, -0.07F * s, 0.4F + 0.011F * s);
    std::vector<Beam> rays = random_scan(scan, origin_m, 1200, 24.0);
    for (const float length : {2.0F, -3.0F, 4.5F}) {
      for (int axis = 0; axis < 3; ++axis)
        rays.push_back({origin_m, origin_m + length * Eigen::Vector3f::Unit(axis), true});
      rays.push_back({origin_m, origin_m + Eigen::Vector3f(length, length, length), true});
      rays.push_back({origin_m, origin_m + Eigen::Vector3f(length, length, 0.0F), true});
    }
    rays.push_back({origin_m, origin_m, true});
    map->insert(rays, scan * kScan);
    insert(rays, 20.0, tree);
  }
  expect_equal(*map, tree);
}

TEST(OccupancyMap, ResolvesRayTiesLikeTheLibrary) {
  const auto map = make_occupancy_map({});
  octomap::OcTree tree(0.1);
  std::vector<Beam> rays;
  for (int i = 0; i < 24; ++i) {
    const float far_m = i % 2 == 0 ? 6.0F : -6.0F, other_m = 0.5F * static_cast<float>(i - 12);
    rays.push_back(beam_to(0.05F + far_m, 0.05F + other_m, 0.05F + far_m));
    rays.push_back(beam_to(0.05F + far_m, 0.05F + far_m, 0.05F + other_m));
    rays.push_back(beam_to(0.05F + other_m, 0.05F + far_m, 0.05F - far_m));
  }
  map->insert(rays, kScan);
  insert(rays, 20.0, tree);
  expect_equal(*map, tree);
}

// A miss that weighs little must be counted beyond what the bits hold; one that weighs much saturates soon.
TEST(OccupancyMap, MatchesTheLibraryWithOtherProbabilities) {
  for (const double p_miss : {0.49, 0.46, 0.2}) {
    OccupancyMapConfig config;
    config.edge_m = 0.2;
    config.p_hit = 0.6;
    config.p_miss = p_miss;
    config.p_occupied = 0.7;
    const auto map = make_occupancy_map(config);
    octomap::OcTree tree(config.edge_m);
    tree.setProbHit(config.p_hit);
    tree.setProbMiss(config.p_miss);
    tree.setOccupancyThres(config.p_occupied);
    for (std::uint32_t scan = 0; scan < 40; ++scan) {
      const std::vector<Beam> rays = random_scan(scan, kOrigin, 400, 8.0);
      map->insert(rays, scan * kScan);
      insert(rays, 20.0, tree);
    }
    SCOPED_TRACE(p_miss);
    expect_equal(*map, tree);
  }
}

// The library has 32768 cells on each side of the origin.
TEST(OccupancyMap, InsertsNothingBeyondTheLibrarysBounds) {
  for (const float x_m : {3276.0F, 3290.0F, -3276.0F, -3290.0F}) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto map = make_occupancy_map({});
      octomap::OcTree tree(0.1);
      const Eigen::Vector3f origin_m = x_m * Eigen::Vector3f::Unit(axis);
      for (const float length_m : {0.55F, -0.55F, 2.0F, -2.0F}) {
        const std::vector<Beam> rays = {{origin_m, origin_m + length_m * Eigen::Vector3f::Unit(axis), true}};
        map->insert(rays, kScan);
        insert(rays, 20.0, tree);
      }
      tree.expand();
      MapVoxels copy;
      map->append_voxels(copy);
      EXPECT_EQ(copy.size(), tree.getNumLeafNodes()) << x_m << ", " << axis;
    }
  }
}

TEST(OccupancyMap, RayBeyondRangeOnlyClears) {
  OccupancyMapConfig config;
  config.range_max_m = 5.0;
  const auto map = make_occupancy_map(config);
  map->insert(std::vector{beam_to(30.0F, 0.05F, 0.05F), Beam{kOrigin, {0.05F, 3.0F, 0.05F}, false}}, kScan);
  EXPECT_EQ(map->state({4.9, 0.05, 0.05}), CellState::kFree);
  EXPECT_EQ(map->state({5.2, 0.05, 0.05}), CellState::kUnknown);
  EXPECT_EQ(map->state({0.05, 2.9, 0.05}), CellState::kFree);
  EXPECT_EQ(map->state({0.05, 3.1, 0.05}), CellState::kUnknown);
  std::vector<Vector3> occupied;
  map->occupied_in(Vector3::Constant(-40.0), Vector3::Constant(40.0), occupied);
  EXPECT_TRUE(occupied.empty());
}

TEST(OccupancyMap, RaysStartAtTheirOwnOrigins) {
  const auto map = make_occupancy_map({});
  map->insert(std::vector<Beam>{{{0.05F, 0.05F, 0.05F}, {3.05F, 0.05F, 0.05F}, true},
                                {{0.05F, 1.05F, 0.05F}, {3.05F, 1.05F, 0.05F}, true}},
              kScan);
  for (int x = 0; x < 30; ++x) {
    EXPECT_LT(map->log_odds({x, 0, 0}), 0.0F);
    EXPECT_LT(map->log_odds({x, 10, 0}), 0.0F);
    EXPECT_FALSE(map->known({x, 5, 0}));
  }
}

TEST(OccupancyMap, IgnoresNonFiniteRays) {
  const auto map = make_occupancy_map({});
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  map->insert(std::vector<Beam>{beam_to(nan, 0.0F, 0.0F),
                                beam_to(inf, 0.0F, 0.0F),
                                {{nan, 0.0F, 0.0F}, kOrigin, true},
                                beam_to(3.05F, 0.05F, 0.05F)},
              kScan);
  MapVoxels copy;
  map->append_voxels(copy);
  EXPECT_EQ(copy.size(), 31U) << "the cells of the finite ray";
}

TEST(OccupancyMap, RemembersWhenACellWasHit) {
  const auto map = make_occupancy_map({});
  std::vector<Vector3> cells;
  const auto hit_since = [&](TimeNs since) {
    map->occupied_within(Vector3::Zero(), 10.0, since, cells);
    return cells.size();
  };
  map->insert(std::vector{beam_to(3.05F, 0.05F, 0.05F)}, 1 * kScan);
  map->insert(std::vector{beam_to(0.05F, 3.05F, 0.05F)}, 2 * kScan);
  map->insert(std::vector{beam_to(0.05F, 0.05F, 3.05F)}, 3 * kScan);
  EXPECT_EQ(hit_since(kEver), 3U);
  EXPECT_EQ(hit_since(2 * kScan), 2U);
  EXPECT_EQ(hit_since(2 * kScan + 1), 1U);
  EXPECT_EQ(hit_since(4 * kScan), 0U);
  for (int i = 4; i < 6000; ++i) map->insert({}, i * kScan);
  EXPECT_EQ(hit_since(kEver), 3U);
  EXPECT_EQ(hit_since(5000 * kScan), 0U) << "too long ago for a time stamp";
}

TEST(OccupancyMap, ReportsChangesSinceARevision) {
  OccupancyMapConfig config;
  config.keep_radius_m = config.range_max_m = 5.0;
  const auto map = make_occupancy_map(config);
  std::vector<VoxelGrid> boxes;
  const auto covers = [&](const Vector3& p_m) {
    return std::any_of(boxes.begin(), boxes.end(), [&](const VoxelGrid& box) { return box.contains(p_m); });
  };
  const std::uint64_t before = map->revision();
  map->insert(near_wall(), kScan);
  EXPECT_GT(map->revision(), before);
  ASSERT_TRUE(map->changed_since(before, boxes));
  EXPECT_TRUE(covers({3.05, 0.05, 0.05}) && covers({1.55, 0.05, 0.05}));
  EXPECT_FALSE(covers({-3.05, 0.05, 0.05}));

  const std::uint64_t seen = map->revision();
  map->insert(near_wall(), 2 * kScan);
  ASSERT_TRUE(map->changed_since(seen, boxes));
  EXPECT_TRUE(boxes.empty()) << "more certain, but the same state";

  for (int i = 3; i < 9; ++i) map->insert(std::vector{beam_to(4.55F, 0.05F, 0.05F)}, i * kScan);
  ASSERT_TRUE(map->changed_since(seen, boxes));
  EXPECT_TRUE(covers({3.05, 0.05, 0.05})) << "cleared by rays that pass";
  EXPECT_EQ(map->state({3.05, 0.05, 0.05}), CellState::kFree);

  map->keep_around({50.0, 0.0, 0.0});
  ASSERT_TRUE(map->changed_since(seen, boxes));
  EXPECT_TRUE(covers({3.05, 0.05, 0.05})) << "forgotten";
  EXPECT_EQ(map->state({3.05, 0.05, 0.05}), CellState::kUnknown);
}

TEST(OccupancyMap, HitBelowThresholdMakesCellKnown) {
  OccupancyMapConfig config;
  config.p_hit = 0.55;
  config.p_occupied = 0.7;
  const auto map = make_occupancy_map(config);
  const Vector3 end_m(3.25, 0.05, 0.05);  // the first cell of its block: no ray passes through another one
  ASSERT_EQ(map->state(end_m), CellState::kUnknown);
  const std::uint64_t before = map->revision();
  map->insert(std::vector{beam_to(3.25F, 0.05F, 0.05F)}, kScan);
  ASSERT_EQ(map->state(end_m), CellState::kFree);
  std::vector<VoxelGrid> boxes;
  ASSERT_TRUE(map->changed_since(before, boxes));
  EXPECT_TRUE(std::any_of(boxes.begin(), boxes.end(), [&](const VoxelGrid& box) { return box.contains(end_m); }));
}

// The conservative setting of Kamler 2025, sec. 3.4.
TEST(OccupancyMap, EvenMissProbabilityClearsNothing) {
  OccupancyMapConfig config;
  config.p_miss = 0.5;
  const auto map = make_occupancy_map(config);
  const Eigen::Vector3f origin(0.05F, 0.05F, 0.05F), wall(4.05F, 0.05F, 0.05F), behind(8.05F, 0.05F, 0.05F);
  map->insert(std::vector<OccupancyMap::Ray>{{origin, wall, true}}, 1);
  for (TimeNs t = 2; t < 30; ++t) map->insert(std::vector<OccupancyMap::Ray>{{origin, behind, false}}, t);
  EXPECT_EQ(map->state(wall.cast<double>()), CellState::kOccupied);
  EXPECT_EQ(map->state({2.05, 0.05, 0.05}), CellState::kUnknown);
}

TEST(OccupancyMap, ConfidenceThresholdFiltersOnlyOccupiedCells) {
  const auto map = make_occupancy_map({});
  for (int i = 1; i <= 6; ++i) {
    std::vector<Beam> rays = {beam_to(3.05F, 0.05F, 0.05F)};
    if (i <= 2) rays.push_back(beam_to(0.05F, 3.05F, 0.05F));
    if (i <= 2) rays.push_back(beam_to(0.05F, 0.05F, 3.25F));  // the first of its block
    map->insert(rays, i * kScan);
  }
  const auto counted = [&](double p) {
    std::pair<int, int> cells;  // occupied, free
    for (const CellBlock& block : map->blocks_above(p)) {
      for (int z = 0; z < 8; ++z) {
        cells.first += std::popcount(block.occupied[static_cast<std::size_t>(z)]);
        cells.second += std::popcount(block.free[static_cast<std::size_t>(z)]);
      }
    }
    return cells;
  };
  const float twice = map->log_odds({0, 30, 0});
  const double p_twice = 1.0 / (1.0 + std::exp(-static_cast<double>(twice)));
  EXPECT_EQ(counted(0.5).first, 3);
  EXPECT_EQ(counted(p_twice - 0.001).first, 3);
  EXPECT_EQ(counted(p_twice + 0.001).first, 1) << "hit six times";
  EXPECT_EQ(counted(0.999).first, 0);
  EXPECT_EQ(counted(0.5).second, counted(0.999).second);
  EXPECT_EQ(counted(0.5).second, 30 + 29 + 31);
}

TEST(OccupancyMap, ForgetsDistantCellsAndReusesMemory) {
  OccupancyMapConfig config;
  config.keep_radius_m = config.range_max_m = 5.0;
  const auto map = make_occupancy_map(config);
  for (int i = 1; i <= 400; ++i) {
    const auto x = static_cast<float>(0.5 * i);
    map->keep_around({x, 0.0, 0.0});
    map->insert(std::vector<Beam>{{{x, 0.0F, 0.0F}, {x + 2.0F, 0.15F, 0.15F}, true}}, i * kScan);
  }
  EXPECT_LE(map->num_blocks(), 60U);
  EXPECT_EQ(map->state({202.0, 0.15, 0.15}), CellState::kOccupied);
  EXPECT_EQ(map->state({40.0, 0.15, 0.15}), CellState::kUnknown);
}

TEST(OccupancyMap, ScanAllocatesNothingAfterWarmUp) {
  const auto map = make_occupancy_map({});
  const std::vector<Beam> rays = random_scan(1, kOrigin, 5000, 15.0);
  map->insert(rays, kScan);
  const std::uint64_t before = test::num_allocations();
  for (int i = 2; i < 20; ++i) {
    map->keep_around(kOrigin.cast<double>());
    map->insert(rays, i * kScan);
  }
  EXPECT_EQ(test::num_allocations(), before);
}

}  // namespace
}  // namespace swiftlet
