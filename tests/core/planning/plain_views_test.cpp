// SPDX-License-Identifier: BSD-3-Clause
// Views and regions of a plane, against exhaustive search.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/planning/guiding_viewpoint.hpp"
#include "swiftlet/core/planning/next_view.hpp"
#include "swiftlet/core/planning/plane_region.hpp"
#include "tests/core/planning/box_map.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using testing::BoxMap;
using testing::CellListMap;

TEST(PlainViews, AbandonedCubesAreCorrectAcrossZero) {
  GivenUp given_up(0.5);
  given_up.add({-0.1, 0.2, 7.4});
  EXPECT_EQ(given_up.size(), 1U);
  for (const Vector3& p_m : {Vector3(-0.49, 0.0, 7.0), Vector3(-0.01, 0.49, 7.49)}) EXPECT_TRUE(given_up.has(p_m));
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0})
      EXPECT_FALSE(given_up.has(Vector3(-0.1, 0.2, 7.4) + 0.5 * sign * Vector3::Unit(axis)));
  }
  given_up.add({-0.3, 0.4, 7.1});
  EXPECT_EQ(given_up.size(), 1U) << "a second point in the same cube";
  for (int i = 0; i < 1000; ++i)
    given_up.add({0.5 * (i % 10) + 10.1, 0.5 * (i / 10 % 10) - 2.4, 0.5 * (i / 100) + 0.1});
  EXPECT_EQ(given_up.size(), 1001U);
}

/// 6 m x 3 m x 3 m, free, with its last meter unknown.
BoxMap corridor() {
  BoxMap map({24, 12, 12}, 0.25);
  for (int x = 20; x < 24; ++x) {
    for (int y = 0; y < 12; ++y) {
      for (int z = 0; z < 12; ++z) map.at({x, y, z}) = CellState::kUnknown;
    }
  }
  return map;
}

NextViewConfig short_sighted() {
  NextViewConfig config;
  config.range_m = 2.0;
  config.path.clearance_m = 0.3;
  config.path.max_shortenings = 0;
  return config;
}

TEST(PlainViews, BudgetLimitsExpansionsButKeepsResults) {
  const BoxMap map = corridor();
  NextViewConfig config = short_sighted();
  const Vector3 start_m(0.9, 1.4, 1.4);
  const NextView whole = find_next_view(map, config, {}, GivenUp(0.5), start_m);
  ASSERT_EQ(whole.status, NextViewStatus::kFound);
  int first = 0;
  for (int budget = 1; budget <= static_cast<int>(whole.expansions) + 1; budget += 1 + budget / 12) {
    config.max_expansions = budget;
    const NextView found = find_next_view(map, config, {}, GivenUp(0.5), start_m);
    EXPECT_LE(found.expansions, static_cast<std::size_t>(budget));
    if (found.status == NextViewStatus::kBudgetSpent) {
      EXPECT_EQ(found.expansions, static_cast<std::size_t>(budget));
      EXPECT_EQ(first, 0) << "once something was found it stays so";
      continue;
    }
    ASSERT_EQ(found.status, NextViewStatus::kFound);
    if (first == 0) first = budget;
  }
  EXPECT_GT(first, 3);
  config.max_expansions = static_cast<int>(whole.expansions);
  EXPECT_EQ(find_next_view(map, config, {}, GivenUp(0.5), start_m).corners_local_m, whole.corners_local_m);
}

TEST(PlainViews, WaypointIsVisibleFromSafePlaces) {
  CellListMap map(0.2);
  map.occupy_box({-0.6, 0.8, 0.4}, {-0.4, 1.6, 1.6});
  map.occupy_box({1.0, -1.6, 0.4}, {1.2, -0.6, 1.6});
  map.occupy_box({0.4, 1.2, 0.4}, {1.2, 1.4, 0.8});
  const std::vector<Vector3> path = {{-1.03, 0.017, 0.913}, {0.011, 0.123, 0.907}, {0.937, 0.319, 0.893}},
                             before = {{-1.03, 0.017, 0.913}, {-1.63, -0.83, 0.9}};
  const KeepOut other = KeepOut::box({0.5, -1.5, 1.0}, {0.6, 0.6, 4.0});
  ViewpointRules rules;
  rules.ray_max_m = 2.23;
  rules.buffer_m = 0.5;
  rules.clearance_m = 0.45;
  rules.margin_m = 0.0;
  const Vector3 watcher(-1.5, -1.5, 1.3);
  const auto distance_to_path_m = [](const std::vector<Vector3>& corners, const Vector3& p_m) {
    double least_m = 1e9;
    for (std::size_t i = 1; i < corners.size(); ++i) {
      for (int k = 0; k <= 200; ++k)
        least_m =
            std::min(least_m, (corners[i - 1] + (corners[i] - corners[i - 1]) * (k / 200.0) - p_m).head<2>().norm());
    }
    return least_m;
  };
  for (const double known_m : {100.0, 1.65}) {
    map.known_within_m = known_m;
    for (const bool unknown_is_free : {true, false}) {
      rules.unknown_is_free = unknown_is_free;
      const GuidingViewpoints all = find_guiding_viewpoints(map, watcher, path, rules, before, std::span(&other, 1));
      ASSERT_EQ(all.visible.size(), path.size());
      int seen = 0, hidden = 0;
      for (int ix = -20; ix < 20; ++ix) {
        for (int iy = -20; iy < 20; ++iy) {
          const Vector3 p_m(0.2 * ix + 0.1, 0.2 * iy + 0.1, 1.3);
          const double off_m = std::min(distance_to_path_m(path, p_m), distance_to_path_m(before, p_m));
          if (std::abs(off_m - 0.502) < 0.004) continue;  // the buffer is round to half a percent
          const bool is_known = map.state({p_m.x(), p_m.y(), 1.3}) != CellState::kUnknown;
          const double clear_m = std::min(map.clearance_m(p_m, 1.0), other.distance_m(p_m));
          const bool safe = off_m > 0.5 && clear_m > 0.45 && (unknown_is_free || is_known);
          for (std::size_t w = 0; w < path.size(); ++w) {
            const bool near = (p_m - path[w]).head<2>().norm() <= 2.23, in_sight = !map.first_hit(p_m, path[w]);
            ASSERT_EQ(contains(all.visible[w], p_m.head<2>()), safe && near && in_sight)
                << p_m.transpose() << " " << w << " " << known_m;
            ++(safe && near ? (in_sight ? seen : hidden) : hidden);
          }
        }
      }
      EXPECT_GT(seen, 200);
      // A viewpoint lies where all that it counts is seen.
      for (const GuidingViewpoint& v : all.best_first) {
        EXPECT_EQ(v.p_local_m.z(), 1.3);
        for (int w = 0; w < v.num_visible; ++w) {
          EXPECT_TRUE(contains(all.visible[static_cast<std::size_t>(v.first_visible + w)], v.p_local_m.head<2>()));
        }
      }
      ASSERT_FALSE(all.best_first.empty());
    }
  }
}

TEST(PlainViews, ViewpointIsNearestWithItsMargin) {
  // An aisle with a meter of room: the path is in its middle, and no viewpoint has 0.6 m to both walls.
  CellListMap map(0.1);
  map.occupy_box({-4.0, 1.2, 0.5}, {4.0, 1.3, 1.5});
  map.occupy_box({-4.0, -4.0, 0.5}, {4.0, -0.6, 1.5});
  const std::vector<Vector3> path = {{0, 0, 1}};
  ViewpointRules rules;
  rules.buffer_m = 1.0;
  rules.clearance_m = 0.4;
  rules.ray_max_m = 3.0;
  for (const double margin_m : {0.1, 0.6}) {
    rules.margin_m = margin_m;
    const auto all = find_guiding_viewpoints(map, {3, 0.3, 1}, path, rules);
    for (const GuidingViewpoint& v : all.best_first) {
      EXPECT_GE(distance_to_border_m(v.overlap, v.p_local_m.head<2>()), margin_m);
      EXPECT_TRUE(contains(v.overlap, v.p_local_m.head<2>()));
    }
    EXPECT_EQ(all.best_first.empty(), margin_m > 0.5);
    if (margin_m > 0.5) continue;
    ASSERT_GE(all.best_first.size(), 2U) << "on both sides of the path";
    EXPECT_GT(all.best_first[0].p_local_m.x(), 0.0) << "the watcher's side first";
    EXPECT_LT(all.best_first[1].p_local_m.x(), 0.0);
  }
}

}  // namespace
}  // namespace swiftlet
