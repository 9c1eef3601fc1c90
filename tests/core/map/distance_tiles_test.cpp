// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/distance_tiles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

using Place = std::tuple<int, int, int>;

/// Occupied cells that come and go.
class ChangingBlocks : public OccupiedBlocks {
 public:
  void set(const Cell& cell, bool occupied) {
    ++revision;
    Block& block = blocks_[place(block_of(cell))];
    const std::uint64_t bit = std::uint64_t{1} << ((cell.y() & 7) * 8 + (cell.x() & 7));
    const auto z = static_cast<std::size_t>(cell.z() & 7);
    block.bits[z] = occupied ? block.bits[z] | bit : block.bits[z] & ~bit;
    block.touched[z] |= bit;
    block.changed = revision;
    occupied ? (void)cells.insert(place(cell)) : (void)cells.erase(place(cell));
  }
  /// Earlier changes are no longer reported.
  void forget_touched() {
    touched_after_ = revision;
    for (auto& [at, block] : blocks_) block.touched = {};
  }
  const CellBlock::Bits* occupied_of(const Cell& block) const override {
    const auto found = blocks_.find(place(block));
    if (found == blocks_.end()) return nullptr;
    const CellBlock::Bits& bits = found->second.bits;
    return std::any_of(bits.begin(), bits.end(), [](std::uint64_t word) { return word != 0; }) ? &bits : nullptr;
  }
  void append_changes(const Cell& low, const Cell& high, std::uint64_t since,
                      std::vector<Change>& changes) const override {
    for (const auto& [at, block] : blocks_) {
      const Cell cell(std::get<0>(at), std::get<1>(at), std::get<2>(at));
      if (block.changed <= since || cell.cwiseMax(low).cwiseMin(high) != cell) continue;
      changes.push_back({cell, since < touched_after_ ? nullptr : &block.touched, &block.bits});
    }
  }
  /// Reference: search over all occupied cells.
  std::int16_t squared(const Cell& cell, int reach) const {
    int least = reach * reach + 1;
    for (const auto& [x, y, z] : cells) least = std::min(least, (Cell(x, y, z) - cell).squaredNorm());
    return least > reach * reach ? DistanceTiles::kFar : static_cast<std::int16_t>(least);
  }

  std::uint64_t revision = 0;
  std::set<Place> cells;

 private:
  static Place place(const Cell& cell) { return {cell.x(), cell.y(), cell.z()}; }
  static Cell block_of(const Cell& cell) { return {cell.x() >> 3, cell.y() >> 3, cell.z() >> 3}; }
  struct Block {
    CellBlock::Bits bits{}, touched{};
    std::uint64_t changed = 0;
  };
  std::map<Place, Block> blocks_;
  std::uint64_t touched_after_ = 0;
};

Cell random_cell(const Random& random, std::uint32_t k, std::uint32_t channel, int half) {
  const auto part = [&](std::uint32_t axis) {
    return static_cast<int>(std::floor(random.uniform(-half, half, k, 3 * channel + axis)));
  };
  return {part(0), part(1), part(2)};
}

// Cells come and go at random; few cells at first, so that distances reach the bound and beyond. Changes are reported
// for some rounds, then forgotten.
TEST(DistanceTiles, AreExactAfterAnyChangeSequence) {
  for (const int reach : {5, 8, 17, 30}) {
    const Random random(static_cast<std::uint64_t>(reach), "cells");
    ChangingBlocks map;
    DistanceTiles tiles(reach);
    int far = 0, near = 0;
    for (std::uint32_t round = 0; round < 120; ++round) {
      if (round % 4 == 1) map.forget_touched();
      for (std::uint32_t i = 0; i <= round % 7; ++i) map.set(random_cell(random, round, i, 30), true);
      if (round % 3 == 2) {
        const auto [x, y, z] = *std::next(map.cells.begin(), round % static_cast<std::uint32_t>(map.cells.size()));
        map.set({x, y, z}, false);
      }
      for (std::uint32_t i = 0; i < 60; ++i) {
        const Cell cell = random_cell(random, round, 100 + i, 40);
        const std::int16_t expected = map.squared(cell, reach);
        ASSERT_EQ(tiles.squared(cell, map, map.revision), expected) << "reach " << reach << ", round " << round;
        (expected == DistanceTiles::kFar ? far : near) += 1;
      }
    }
    EXPECT_GT(std::min(far, near), 100) << reach;
  }
}

// Bounds by blocks and by halves of blocks must not leave out what matters to a single cell.
TEST(DistanceTiles, RespondToObstaclesNearFewCells) {
  constexpr int kReach = 22;
  const Random random(5, "few");
  int tried = 0;
  for (std::uint32_t k = 0; k < 6000 && tried < 300; ++k) {
    const Cell there = random_cell(random, k, 0, 26), comes = random_cell(random, k, 1, 26);
    std::vector<Cell> cells;
    int nearer = 0;
    for (int i = 0; i < 512; ++i) {
      cells.emplace_back(i & 7, i >> 3 & 7, i >> 6);
      const int now_sq = (there - cells.back()).squaredNorm(), then_sq = (comes - cells.back()).squaredNorm();
      nearer += then_sq < std::min(now_sq, kReach * kReach + 1);
    }
    if (nearer < 1 || nearer > 12) continue;
    ++tried;
    ChangingBlocks map;
    DistanceTiles tiles(kReach);
    const auto expect_exact = [&](const char* when) {
      for (const Cell& cell : cells) {
        ASSERT_EQ(tiles.squared(cell, map, map.revision), map.squared(cell, kReach)) << when << ", " << k;
      }
    };
    map.set(there, true);
    ASSERT_NO_FATAL_FAILURE(expect_exact("before"));
    map.set(comes, true);
    ASSERT_NO_FATAL_FAILURE(expect_exact("came"));
    map.set(comes, false);
    ASSERT_NO_FATAL_FAILURE(expect_exact("went"));
  }
  EXPECT_GT(tried, 100);
}

TEST(DistanceTiles, RecomputeOnlyWhatChanged) {
  ChangingBlocks map;
  DistanceTiles tiles(20);
  for (int x = -40; x < 40; ++x) {
    for (int y = -40; y < 40; ++y) map.set({x, y, 0}, true);  // a floor
  }
  const auto ask_all = [&] {
    const std::uint64_t before = tiles.num_computed();
    for (int z = 4; z < 20; z += 8) {
      for (int y = -36; y < 40; y += 8) {
        for (int x = -36; x < 40; x += 8)
          EXPECT_EQ(tiles.squared({x, y, z}, map, map.revision), map.squared({x, y, z}, 20));
      }
    }
    return tiles.num_computed() - before;
  };
  const std::uint64_t all = ask_all();
  EXPECT_GT(all, 0U);
  EXPECT_EQ(ask_all(), 0U);
  map.set({100, 0, 0}, true);
  EXPECT_EQ(ask_all(), 0U) << "too far away to matter";
  map.set({0, 0, 26}, true);
  EXPECT_EQ(ask_all(), 0U) << "a new cell lowers known distances";
  map.set({0, 0, 26}, false);
  const std::uint64_t again = ask_all();
  EXPECT_GT(again, 0U) << "a removed cell that was nearest to others causes updates";
  EXPECT_LT(again, all);
  map.set({3, 3, -2}, true);
  map.set({3, 3, -2}, false);
  EXPECT_EQ(ask_all(), 0U) << "the nearest of no cell";
  map.set({8, 8, 12}, true);
  map.forget_touched();
  EXPECT_GT(ask_all(), 0U) << "unknown changes need all blocks";
}

TEST(DistanceTiles, ForgetAndAreWorkedOutAgain) {
  ChangingBlocks map;
  map.set({3, 4, 0}, true);
  DistanceTiles tiles(10);
  for (int x = -100; x < 100; x += 4) tiles.squared({x, 0, 0}, map, map.revision);
  const std::size_t before = tiles.num_tiles();
  tiles.forget_if([](const Cell& block) { return block.x() >= 0; });
  EXPECT_LT(tiles.num_tiles(), before);
  EXPECT_EQ(tiles.squared({0, 0, 0}, map, map.revision), 25);
}

// Forgotten and flickering cells are followed too.
TEST(DistanceTiles, FollowOccupiedCellsOfAMap) {
  OccupancyMapConfig config;
  config.keep_radius_m = config.range_max_m = 8.0;
  config.distance_max_m = 1.5;
  const auto map = make_occupancy_map(config);
  const Random random(4, "flight");
  for (std::uint32_t scan = 0; scan < 30; ++scan) {
    const Eigen::Vector3f origin_m(0.4F * static_cast<float>(scan) - 6.0F, 0.05F, 0.03F);
    std::vector<OccupancyMap::Ray> rays;
    for (std::uint32_t i = 0; i < 400; ++i) {
      const auto n = random.normal3(scan, i);
      const Vector3 direction = Vector3(n[0], n[1], 0.3 * n[2]).normalized();
      const auto range_m = static_cast<float>(random.uniform(1.0, 4.0, scan, 5000 + i));
      rays.push_back({origin_m, origin_m + range_m * direction.cast<float>(), true});
    }
    map->keep_around(origin_m.cast<double>());
    map->insert(rays, scan);
    std::vector<Vector3> occupied;
    map->occupied_in(Vector3::Constant(-30.0), Vector3::Constant(30.0), occupied);
    for (std::uint32_t i = 0; i < 200; ++i) {
      const auto n = random.normal3(1000 + scan, i);
      const Vector3 p_m = origin_m.cast<double>() + 3.0 * Vector3(n[0], n[1], n[2]);
      const Vector3 center_m = ((p_m.array() * 10.0).floor() + 0.5) * 0.1;
      double expected = 1.5;
      for (const Vector3& cell_m : occupied) expected = std::min(expected, (cell_m - center_m).norm());
      ASSERT_NEAR(map->clearance_m(p_m, 1.5), expected, 1e-9);
      ASSERT_NEAR(map->OccupancyView::clearance_m(p_m, 1.5), expected, 1e-9)
          << "clearance by the generic implementation";
      double farther = 4.0;
      for (const Vector3& cell_m : occupied) farther = std::min(farther, (cell_m - center_m).norm());
      ASSERT_NEAR(map->clearance_m(p_m, 4.0), farther, 1e-9) << "farther than distances are kept";
    }
  }
}

}  // namespace
}  // namespace swiftlet
