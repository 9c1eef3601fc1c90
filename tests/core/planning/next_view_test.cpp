// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/planning/next_view.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "swiftlet/core/math/random.hpp"
#include "tests/core/planning/box_map.hpp"

namespace swiftlet {
namespace {

using testing::BoxMap;

constexpr double kEdge_m = 0.25;

void fill(BoxMap& map, const Vector3& min_m, const Vector3& max_m, CellState state) {
  const Cell low = (min_m / kEdge_m).array().round().cast<int>(), high = (max_m / kEdge_m).array().round().cast<int>();
  for (int z = low.z(); z < high.z(); ++z) {
    for (int y = low.y(); y < high.y(); ++y) {
      for (int x = low.x(); x < high.x(); ++x) map.at({x, y, z}) = state;
    }
  }
}

/// 12 m x 6 m x 3 m, all known, with walls around.
BoxMap hall() {
  BoxMap map(Cell(48, 24, 12), kEdge_m);
  fill(map, {0, 0, 0}, {12, 6, 3}, CellState::kOccupied);
  fill(map, {kEdge_m, kEdge_m, kEdge_m}, {12 - kEdge_m, 6 - kEdge_m, 3 - kEdge_m}, CellState::kFree);
  return map;
}

std::vector<Vector3> seen_from(const BoxMap& map, const NextViewConfig& config, const GivenUp& given_up,
                               const Vector3& p_m, int num_rays) {
  std::vector<Vector3> found_m;
  unknown_in_sight(map, config, {}, given_up, p_m, num_rays, found_m);
  return found_m;
}

NextViewConfig rules() {
  NextViewConfig config;
  config.range_m = 4.0;
  config.path.clearance_m = 0.4;
  return config;
}

TEST(NextView, FindsNothingUnknownInKnownHalls) {
  const BoxMap map = hall();
  const NextView found = find_next_view(map, rules(), {}, GivenUp(0.4), {1.1, 3.0, 1.5});
  EXPECT_EQ(found.status, NextViewStatus::kNothingLeft);
  EXPECT_TRUE(found.corners_local_m.empty());
  EXPECT_GT(found.expansions, 300U) << "the search expands all reachable space";
}

TEST(NextView, LiesInSightOfUnknownEnd) {
  BoxMap map = hall();
  fill(map, {9, kEdge_m, kEdge_m}, {12 - kEdge_m, 6 - kEdge_m, 3 - kEdge_m}, CellState::kUnknown);
  const Vector3 start_m(1.1, 3.0, 1.5);
  const NextView found = find_next_view(map, rules(), {}, GivenUp(0.4), start_m);
  ASSERT_EQ(found.status, NextViewStatus::kFound);
  EXPECT_EQ(found.corners_local_m.front(), start_m);
  EXPECT_GT(found.corners_local_m.back().x(), 5.0);
  EXPECT_LT(found.corners_local_m.back().x(), 9.0) << "the path ends before unknown space";
  EXPECT_GT(found.share, 0.2);
}

/// Share times the exponential of the path length, for every place of the lattice, by exhaustive search.
double best_of_all(const BoxMap& map, const NextViewConfig& config, const Vector3& start_m) {
  const ClearSpace space(map, config.path, start_m);
  using Key = std::tuple<int, int, int>;
  const auto place = [&](const Key& k) {
    return Vector3(start_m + NextViewConfig::kStep_m * Vector3(std::get<0>(k), std::get<1>(k), std::get<2>(k)));
  };
  std::map<Key, double> way_m;  // Dijkstra
  std::set<std::pair<double, Key>> open = {{0.0, {0, 0, 0}}};
  while (!open.empty()) {
    const auto [cost_m, from] = *open.begin();
    open.erase(open.begin());
    if (!way_m.emplace(from, cost_m).second) continue;
    for (int i = 0; i < 27; ++i) {
      const int dx = i % 3 - 1, dy = i / 3 % 3 - 1, dz = i / 9 - 1;
      const Key to{std::get<0>(from) + dx, std::get<1>(from) + dy, std::get<2>(from) + dz};
      if (way_m.count(to) != 0 || !space.is_clear(place(to)) || !space.is_clear_segment(place(from), place(to)))
        continue;
      open.insert({cost_m + NextViewConfig::kStep_m * std::sqrt(dx * dx + dy * dy + dz * dz), to});
    }
  }
  double best = 0.0;
  for (const auto& [key, cost_m] : way_m) {
    if (std::get<0>(key) % 2 != 0 || std::get<1>(key) % 2 != 0 || std::get<2>(key) % 2 != 0 || cost_m == 0.0) continue;
    const auto seen = seen_from(map, config, GivenUp(0.4), place(key), config.num_rays).size();
    const double share = static_cast<double>(seen) / config.num_rays;
    if (share >= config.share_min) best = std::max(best, share * std::exp(-config.path_decay_per_m * cost_m));
  }
  return best;
}

TEST(NextView, IsBestOfAllReachableViews) {
  for (int trial = 0; trial < 6; ++trial) {
    const Random random(7, "next view", std::to_string(trial));
    BoxMap map = hall();
    for (int i = 0; i < 6; ++i) {
      const double x_m = random.uniform(2.0, 10.0, 0, i), y_m = random.uniform(0.5, 4.5, 1, i);
      fill(map, {x_m, y_m, kEdge_m}, {x_m + 0.75, y_m + 1.0, 2.75}, i < 4 ? CellState::kOccupied : CellState::kUnknown);
    }
    NextViewConfig config = rules();
    config.path_decay_per_m = 0.3;
    const Vector3 start_m(1.1, 3.1, 1.5);
    const NextView found = find_next_view(map, config, {}, GivenUp(0.4), start_m);
    const double best = best_of_all(map, config, start_m);
    ASSERT_EQ(found.status, best > 0.0 ? NextViewStatus::kFound : NextViewStatus::kNothingLeft) << trial;
    // The path is shorter than that along the lattice: its value is not less than the one of the search.
    if (best > 0.0) {
      const double value = found.share * std::exp(-config.path_decay_per_m * length_m(found.corners_local_m));
      EXPECT_GE(value, best - 1e-9) << trial;
      const ClearSpace space(map, config.path, start_m);
      for (std::size_t i = 1; i < found.corners_local_m.size(); ++i) {
        EXPECT_TRUE(space.is_clear_segment(found.corners_local_m[i - 1], found.corners_local_m[i])) << trial;
      }
    }
  }
}

TEST(NextView, CountsRemainingCellsInTheBox) {
  BoxMap map = hall();
  fill(map, {9, kEdge_m, kEdge_m}, {12 - kEdge_m, 6 - kEdge_m, 3 - kEdge_m}, CellState::kUnknown);
  WorldBox box;
  box.max_world_m.x() = 8.9;
  const Vector3 start_m(1.1, 3.0, 1.5), view_m(7.1, 3.0, 1.5);
  EXPECT_EQ(find_next_view(map, rules(), box, GivenUp(0.4), start_m).status, NextViewStatus::kNothingLeft);
  GivenUp given_up(0.4);
  EXPECT_GT(seen_from(map, rules(), given_up, view_m, 200).size(), 30U);
  for (const Vector3& p_m : seen_from(map, rules(), given_up, view_m, 200)) given_up.add(p_m);
  EXPECT_TRUE(seen_from(map, rules(), given_up, view_m, 200).empty());
}

TEST(NextView, ABoxTurnsWithTheWorld) {
  WorldBox box;
  box.max_world_m.x() = 1.0;
  box.T_world_local = make_pose({0, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(3.14159265, Vector3::UnitZ())));
  EXPECT_TRUE(box.holds({5, 0, 0}));
  EXPECT_FALSE(box.holds({-5, 0, 0}));
}

TEST(NextView, SightEndsAtWallsAndRange) {
  BoxMap map = hall();
  fill(map, {9, kEdge_m, kEdge_m}, {12 - kEdge_m, 6 - kEdge_m, 3 - kEdge_m}, CellState::kUnknown);
  const GivenUp none(0.4);
  NextViewConfig config = rules();
  EXPECT_TRUE(seen_from(map, config, none, {4.0, 3.0, 1.5}, 400).empty()) << "5 m away";
  for (const Vector3& p_m : seen_from(map, config, none, {7.0, 3.0, 1.5}, 400)) EXPECT_GE(p_m.x(), 9.0);
  fill(map, {8, kEdge_m, kEdge_m}, {8.25, 6 - kEdge_m, 3 - kEdge_m}, CellState::kOccupied);
  EXPECT_TRUE(seen_from(map, config, none, {7.0, 3.0, 1.5}, 400).empty()) << "behind a wall";
  fill(map, {3, 1, kEdge_m}, {6, 5, 0.75}, CellState::kUnknown);  // on the floor
  EXPECT_FALSE(seen_from(map, config, none, {4.5, 3.0, 1.9}, 400).empty());
  config.down_deg = 10.0;
  EXPECT_TRUE(seen_from(map, config, none, {4.5, 3.0, 1.9}, 400).empty()) << "below what it sees";
}

TEST(NextView, SaysWhyThereIsNone) {
  BoxMap map = hall();
  fill(map, {9, kEdge_m, kEdge_m}, {12 - kEdge_m, 6 - kEdge_m, 3 - kEdge_m}, CellState::kUnknown);
  NextViewConfig config = rules();
  config.max_expansions = 5;
  EXPECT_EQ(find_next_view(map, config, {}, GivenUp(0.4), {1.1, 3.0, 1.5}).status, NextViewStatus::kBudgetSpent);
  BoxMap closet(Cell(6, 6, 6), kEdge_m);
  EXPECT_EQ(find_next_view(closet, rules(), {}, GivenUp(0.4), {100.0, 0.0, 0.0}).status,
            NextViewStatus::kStartEnclosed);
}

}  // namespace
}  // namespace swiftlet
