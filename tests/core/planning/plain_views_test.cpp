// SPDX-License-Identifier: BSD-3-Clause
// Views and regions of a plane, against exhaustive search.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "swiftlet/core/map/overlaid_occupancy.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/planning/guiding_viewpoint.hpp"
#include "swiftlet/core/planning/next_view.hpp"
#include "swiftlet/core/planning/plane_region.hpp"
#include "swiftlet/core/planning/team_plan.hpp"
#include "tests/core/planning/box_map.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using testing::BoxMap;
using testing::CellListMap;

// ---- where to look next

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
  EXPECT_EQ(given_up.size(), 1U) << "the same cube";
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

TEST(PlainViews, ViewsLieOnEveryOtherNode) {
  const BoxMap map = corridor();
  const NextViewConfig config = short_sighted();
  const Vector3 start_m(0.9, 1.4, 1.4);
  const NextView found = find_next_view(map, config, {}, GivenUp(0.5), start_m);
  ASSERT_EQ(found.status, NextViewStatus::kFound);
  const Vector3 off = (found.corners_local_m.back() - start_m) / (2.0 * config.step_m);
  EXPECT_LT((off - Vector3(off.array().round())).norm(), 1e-9);
  std::vector<Vector3> seen_m;
  unknown_in_sight(map, config, {}, GivenUp(0.5), found.corners_local_m.back(), config.num_rays, seen_m);
  EXPECT_NEAR(found.share, static_cast<double>(seen_m.size()) / config.num_rays, 1e-12);
  // The share suffices up to the required minimum.
  NextViewConfig strict = config;
  strict.way_weight_per_m = 0.0;
  const NextView best = find_next_view(map, strict, {}, GivenUp(0.5), start_m);
  strict.share_min = best.share;
  EXPECT_EQ(find_next_view(map, strict, {}, GivenUp(0.5), start_m).status, NextViewStatus::kFound);
  strict.share_min = best.share + 1e-9;
  EXPECT_EQ(find_next_view(map, strict, {}, GivenUp(0.5), start_m).status, NextViewStatus::kNothingLeft);
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

TEST(PlainViews, ReportsAnEnclosedStart) {
  BoxMap map({24, 24, 24}, 0.25);
  for (std::ptrdiff_t i = 0; i < map.grid().num_cells(); ++i) map.at(map.grid().cell(i)) = CellState::kUnknown;
  GivenUp all(100.0);
  for (int corner = 0; corner < 8; ++corner)
    all.add({corner & 1 ? 3.0 : -3.0, corner & 2 ? 3.0 : -3.0, corner & 4 ? 3.0 : -3.0});
  EXPECT_EQ(find_next_view(map, short_sighted(), {}, all, {3.1, 3.1, 3.1}).status, NextViewStatus::kStartEnclosed);
  // In the open nothing is left to see.
  EXPECT_EQ(find_next_view(corridor(), short_sighted(), {}, all, {0.9, 1.4, 1.4}).status, NextViewStatus::kNothingLeft);
}

// ---- from where a path is watched

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
  const auto distance_to_way_m = [](const std::vector<Vector3>& way, const Vector3& p_m) {
    double least_m = 1e9;
    for (std::size_t i = 1; i < way.size(); ++i) {
      for (int k = 0; k <= 200; ++k)
        least_m = std::min(least_m, (way[i - 1] + (way[i] - way[i - 1]) * (k / 200.0) - p_m).head<2>().norm());
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
          const double off_m = std::min(distance_to_way_m(path, p_m), distance_to_way_m(before, p_m));
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

// ---- regions of a plane

PlaneRegion random_star(std::uint32_t trial, std::uint32_t which) {
  const Random random(trial, "test.star");
  Ring ring;
  for (std::uint32_t k = 0; k < 17; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / 17, r = random.uniform(0.4, 2.5, which, k);
    ring.emplace_back(r * std::cos(angle) + 0.7 * which, r * std::sin(angle) - 0.3 * which);
  }
  return inside_of(ring);
}

TEST(PlainRegion, SetOperationsMatchPointMembership) {
  for (std::uint32_t trial = 0; trial < 12; ++trial) {
    const PlaneRegion a = random_star(trial, 0), b = random_star(trial, 1);
    const PlaneRegion both[] = {a, b};
    const PlaneRegion any = union_of(both), common = intersection_of(a, b), rest = difference_of(a, b);
    double cells = 0.0;
    for (int i = -60; i < 80; ++i) {
      for (int j = -70; j < 70; ++j) {
        const Vector2 p_m(0.05 * i + 0.013, 0.05 * j + 0.017);
        const bool in_a = contains(a, p_m), in_b = contains(b, p_m);
        ASSERT_EQ(contains(any, p_m), in_a || in_b);
        ASSERT_EQ(contains(common, p_m), in_a && in_b);
        ASSERT_EQ(contains(rest, p_m), in_a && !in_b);
        cells += in_a ? 0.0025 : 0.0;
      }
    }
    EXPECT_NEAR(area_m2(a), cells, 0.1);
    EXPECT_NEAR(area_m2(any), area_m2(a) + area_m2(b) - area_m2(common), 1e-5);
    EXPECT_NEAR(area_m2(rest), area_m2(a) - area_m2(common), 1e-5);
  }
}

TEST(PlainRegion, BorderDistanceMatchesDenseSampling) {
  const Random random(2, "test.border");
  for (std::uint32_t trial = 0; trial < 6; ++trial) {
    const PlaneRegion region = random_star(trial, 0);
    std::vector<Vector2> border_m;
    for (const Ring& ring : region.rings_m) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vector2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
        for (int k = 0; k < 1000; ++k) border_m.push_back(a + (b - a) * (k / 1000.0));
      }
    }
    for (std::uint32_t k = 0; k < 60; ++k) {
      const Vector2 p_m(random.uniform(-4, 4, trial, 2 * k), random.uniform(-4, 4, trial, 2 * k + 1));
      double least_m = 1e9;
      for (const Vector2& q_m : border_m) least_m = std::min(least_m, (q_m - p_m).norm());
      EXPECT_NEAR(distance_to_border_m(region, p_m), least_m, 2e-3);
    }
    const Pole pole = pole_of_inaccessibility(region, 0.003);
    EXPECT_TRUE(contains(region, pole.p_m));
    EXPECT_NEAR(distance_to_border_m(region, pole.p_m), pole.distance_m, 1e-9);
  }
  // A single point has edges of zero length.
  PlaneRegion point;
  point.rings_m = {{{1, 2}, {1, 2}, {1, 2}}};
  EXPECT_NEAR(distance_to_border_m(point, {4, 6}), 5.0, 1e-12);
}

TEST(PlainRegion, PathBufferIsWithinHalfPercent) {
  const Random random(3, "test.around");
  for (std::uint32_t trial = 0; trial < 8; ++trial) {
    std::vector<Vector2> path;
    for (std::uint32_t i = 0; i <= trial % 4; ++i)
      path.emplace_back(random.uniform(-3, 3, trial, 2 * i), random.uniform(-3, 3, trial, 2 * i + 1));
    const PlaneRegion around = around_path(path, 0.8);
    for (std::uint32_t k = 0; k < 1500; ++k) {
      const Vector2 p_m(random.uniform(-4, 4, trial, 100 + 2 * k), random.uniform(-4, 4, trial, 101 + 2 * k));
      double least_m = (path[0] - p_m).norm();
      for (std::size_t i = 1; i < path.size(); ++i) {
        const Vector2 leg = path[i] - path[i - 1];
        const double share = std::clamp((p_m - path[i - 1]).dot(leg) / leg.squaredNorm(), 0.0, 1.0);
        least_m = std::min(least_m, (path[i - 1] + share * leg - p_m).norm());
      }
      if (least_m > 0.8 - 1e-5 && least_m < 0.8 * 1.005) continue;
      ASSERT_EQ(contains(around, p_m), least_m < 0.8) << trial << " " << least_m;
    }
  }
  EXPECT_TRUE(around_path({}, 1.0).empty());
  EXPECT_TRUE(inside_of({{0, 0}, {1, 0}}).empty()) << "a line goes around nothing";
  EXPECT_NEAR(area_m2(inside_of({{0, 0}, {1, 0}, {0, 1}})), 0.5, 1e-9);
}

// ---- plans for two

TEST(PlainPlan, TakesTheNearestClearGoal) {
  CellListMap map(0.25);
  map.occupy_box({1.0, -1.0, 0.0}, {1.25, 3.0, 1.5});
  map.occupy_box({1.0, 2.75, 0.0}, {3.0, 3.0, 3.0});
  TeamPlannerConfig config;
  config.secondary.max_expansions = config.primary.max_expansions = 300;
  config.secondary.clearance_m = 0.8;
  config.goal_search_m = 1.6;
  const Vector3 primary_m(-3, -3, 0.9), secondary_m(-2, 0.1, 0.9);
  const std::vector<KeepOut> air = {KeepOut::box(primary_m, {1.5, 1.5, 10.0})};
  const OverlaidOccupancy around(map, air);
  const ClearSpace space(around, config.secondary, secondary_m);
  for (const Vector3& goal_m :
       {Vector3(0.6, 0.4, 1.2), Vector3(1.1, 2.0, 1.1), Vector3(2.4, 2.3, 1.4), Vector3(-1, 1, 1)}) {
    const TeamPlan plan = plan_team(map, config, primary_m, {secondary_m, 0.0}, {goal_m, 0.0});
    const auto way_m = [&](const Vector3& p_m) {
      return (p_m - goal_m).head<2>().norm() + 2.0 * std::abs(p_m.z() - goal_m.z());
    };
    double least_m = 1.6;
    bool any = space.is_clear(goal_m);
    if (any) least_m = 0.0;
    for (int x = -6; x <= 6; ++x) {
      for (int y = -6; y <= 6; ++y) {
        for (int z = -6; z <= 6; ++z) {
          const Vector3 p_m = goal_m + 0.25 * Vector3(x, y, z);
          if (way_m(p_m) >= least_m || !space.is_clear(p_m)) continue;
          any = true;
          least_m = way_m(p_m);
        }
      }
    }
    ASSERT_TRUE(any);
    EXPECT_NEAR(way_m(plan.goal_local_m), least_m, 1e-9) << goal_m.transpose();
    EXPECT_TRUE(space.is_clear(plan.goal_local_m));
  }
}

TEST(PlainPlan, ReachesGoalsWithinTheToleranceOnly) {
  const CellListMap map(0.25);
  TeamPlannerConfig config;
  config.primary.max_expansions = config.secondary.max_expansions = 50;
  const auto next = [&](double off_m) {
    return plan_team(map, config, {-4, -2.5, 0.9}, {{0, 0, 0.9}, 0.0}, {{off_m, 0, 0.9}, 0.0}).next;
  };
  EXPECT_EQ(next(0.299), TeamPlan::Next::kGoalReached);
  EXPECT_NE(next(0.301), TeamPlan::Next::kGoalReached);
}

}  // namespace
}  // namespace swiftlet
