// SPDX-License-Identifier: BSD-3-Clause
// Position of the guiding vehicle [Pritzl 2024, alg. 2], against exact geometry and exhaustive search.
#include "core/planning/guiding_viewpoint.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using testing::CellListMap;
using Sight = ViewpointRules::Sight;
using SafeSpace = ViewpointRules::SafeSpace;

/// A room of 12 m x 12 m whose east wall, at x = 2 m, has a gap of the given width around y = 0.
CellListMap two_rooms(double gap_m) {
  CellListMap map;
  map.occupy_box({2.0, -6.0, 0.8}, {2.1, -0.5 * gap_m, 1.2});
  map.occupy_box({2.0, 0.5 * gap_m, 0.8}, {2.1, 6.0, 1.2});
  return map;
}

ViewpointRules published() {
  ViewpointRules rules;
  rules.sight = Sight::kAtWaypoint;
  rules.safe_space = SafeSpace::kClosest;
  return rules;
}

struct Found {
  std::optional<Vector3> p_local_m;
  int num_visible = 0;
  PlaneRegion overlap;
};

/// The best one.
Found find_guiding_viewpoint(const OccupancyView& map, const Vector3& watcher_local_m, const std::vector<Vector3>& path,
                             const ViewpointRules& rules) {
  const GuidingViewpoints all = find_guiding_viewpoints(map, watcher_local_m, path, rules);
  EXPECT_EQ(all.visible.size(), path.size());
  if (all.best_first.empty()) return {};
  const GuidingViewpoint& best = all.best_first.front();
  return {best.p_local_m, best.num_visible, best.overlap};
}

TEST(VisibilityRing, IsADiscWithoutObstacles) {
  CellListMap map;
  map.occupy_box({2, -1, 5}, {2.2, 1, 6});
  const Ring ring = visibility_ring(map, {1, 2, 3}, 6.0, 500);
  ASSERT_EQ(ring.size(), 500U);
  for (const Vector2& p : ring) EXPECT_NEAR((p - Vector2(1, 2)).norm(), 6.0, 1e-9);
  EXPECT_NEAR(area_m2(inside_of(ring)), 250.0 * 36.0 * std::sin(2.0 * std::numbers::pi / 500.0), 1e-3);
}

TEST(VisibilityRing, EndsAtWallsButNotGaps) {
  const CellListMap map = two_rooms(1.0);
  const PlaneRegion seen = inside_of(visibility_ring(map, {0, 0, 1}, 6.0, 2000));
  // Through the gap only what lies between its two edges, as seen from the origin: |y| / x <= 0.5 / 2.1.
  for (const Vector2& p : {Vector2(1.9, 3.0), Vector2(-4, 2), Vector2(5, 1.0), Vector2(4, -0.8)}) {
    EXPECT_TRUE(contains(seen, p)) << p.transpose();
  }
  for (const Vector2& p : {Vector2(2.3, 3.0), Vector2(5, 1.35), Vector2(4, -1.1), Vector2(-6.1, 0)}) {
    EXPECT_FALSE(contains(seen, p)) << p.transpose();
  }
}

TEST(GuidingViewpoint, SeesBehindGapAsGeometryAllows) {
  // A path straight through the gap to a point 1 m behind its edge: the line of sight to that point passes the gap.
  const CellListMap map = two_rooms(1.2);
  const std::vector<Vector3> path = {{-0.5, 0, 1}, {1, 0, 1}, {3, 0, 1}};
  const Found found = find_guiding_viewpoint(map, {-4, 0.3, 1}, path, published());
  ASSERT_TRUE(found.p_local_m);
  EXPECT_EQ(found.num_visible, 3);
  const double y_in_gap_m = found.p_local_m->y() * (3.0 - 2.0) / (3.0 - found.p_local_m->x());
  EXPECT_LT(std::abs(y_in_gap_m), 0.6);
  EXPECT_LT(found.p_local_m->x(), 2.0);
}

TEST(GuidingViewpoint, CountsWaypointsWithoutInterruption) {
  // A ring of walls hides the second of three waypoints from all sides: the third does not count.
  CellListMap map;
  map.occupy_box({-1.0, -1.0, 0.8}, {1.0, -0.6, 1.2});
  map.occupy_box({-1.0, 0.6, 0.8}, {1.0, 1.0, 1.2});
  map.occupy_box({-1.0, -0.6, 0.8}, {-0.6, 0.6, 1.2});
  map.occupy_box({0.6, -0.6, 0.8}, {1.0, 0.6, 1.2});
  const std::vector<Vector3> path = {{-4, 0, 1}, {0, 0, 1}, {4, 0, 1}};
  for (const Sight sight : {Sight::kAtWaypoint, Sight::kInSpace}) {
    ViewpointRules rules = published();
    rules.sight = sight;
    const Found found = find_guiding_viewpoint(map, {-4, 4, 1}, path, rules);
    ASSERT_TRUE(found.p_local_m);
    EXPECT_EQ(found.num_visible, 1);
    EXPECT_FALSE(map.first_hit(*found.p_local_m, path[0]));
  }
}

TEST(GuidingViewpoint, StartsAtFirstVisibleWaypoint) {
  // The first waypoint lies in a box; from outside one sees the others.
  CellListMap map;
  map.occupy_box({-4.5, -0.5, 0.8}, {-3.5, -0.4, 1.2});
  map.occupy_box({-4.5, 0.4, 0.8}, {-3.5, 0.5, 1.2});
  map.occupy_box({-4.5, -0.5, 0.8}, {-4.4, 0.5, 1.2});
  map.occupy_box({-3.6, -0.5, 0.8}, {-3.5, 0.5, 1.2});
  const std::vector<Vector3> path = {{-4, 0, 1}, {-1, 0, 1}, {2, 0, 1}};
  ViewpointRules rules;
  rules.unseen_start = true;
  const GuidingViewpoints found = find_guiding_viewpoints(map, {-1, 4, 1}, path, rules);
  ASSERT_FALSE(found.best_first.empty());
  EXPECT_EQ(found.best_first.front().first_visible, 1);
  EXPECT_EQ(found.best_first.front().num_visible, 2);
  rules.unseen_start = false;
  EXPECT_TRUE(find_guiding_viewpoints(map, {-1, 4, 1}, path, rules).best_first.empty());
}

TEST(GuidingViewpoint, ReportsWhenNoneExists) {
  CellListMap map;
  for (const double y : {-3.0, -2.0, -1.0, 1.0, 2.0, 3.0}) {
    for (const double x : {-3.0, -2.0, -1.0, 1.0, 2.0, 3.0}) map.occupy_box({x, y, 0.5}, {x + 0.2, y + 0.2, 1.5});
  }
  ViewpointRules rules = published();
  rules.ray_max_m = 3.0;
  rules.clearance_m = 1.0;
  const Found found = find_guiding_viewpoint(map, {0, 0, 1}, std::vector<Vector3>{{0, 0, 1}}, rules);
  EXPECT_FALSE(found.p_local_m);
  EXPECT_EQ(found.num_visible, 0);
}

TEST(GuidingViewpoint, RefusesUnknownSpace) {
  CellListMap map;
  map.known_within_m = 3.0;
  ViewpointRules rules = published();
  const std::vector<Vector3> path = {{0, 0, 1}};
  const Found known = find_guiding_viewpoint(map, {5, 0, 1}, path, rules);
  ASSERT_TRUE(known.p_local_m);
  EXPECT_LT(known.p_local_m->cwiseAbs().maxCoeff(), 3.0);
  rules.unknown_is_free = true;
  const Found anywhere = find_guiding_viewpoint(map, {5, 0, 1}, path, rules);
  ASSERT_TRUE(anywhere.p_local_m);
  EXPECT_GT(area_m2(anywhere.overlap), area_m2(known.overlap));
}

/// A wall with an unknown hole.
class HoledMap : public CellListMap {
 public:
  CellState state(const Vector3& p_local_m) const override {
    const bool in_hole = p_local_m.x() > 2.0 && p_local_m.x() < 2.1 && std::abs(p_local_m.y()) < 0.2;
    return in_hole ? CellState::kUnknown : CellListMap::state(p_local_m);
  }
};

TEST(GuidingViewpoint, RefusesSightThroughUnobservedHoles) {
  HoledMap map;
  map.occupy_box({2.0, -6.0, 0.5}, {2.1, -0.2, 1.5});
  map.occupy_box({2.0, 0.2, 0.5}, {2.1, 6.0, 1.5});
  ViewpointRules rules = published();
  rules.sight = Sight::kInSpace;
  const std::vector<Vector3> path = {{-1, 0, 1}};
  const Found known = find_guiding_viewpoint(map, {5, 0, 1}, path, rules);
  EXPECT_FALSE(known.p_local_m && known.p_local_m->x() > 2.1);
  rules.unknown_is_free = true;
  const Found through = find_guiding_viewpoint(map, {5, 0, 1}, path, rules);
  ASSERT_TRUE(through.p_local_m);
  EXPECT_GT(through.p_local_m->x(), 2.1);
}

TEST(GuidingViewpoint, DiffersByInterpretationOfSafeSpace) {
  // A wall along y = 0 with the path on its northern side; near its western end one sees the start of the path from the
  // south. The watcher stands in the south; the north sees everything.
  CellListMap map;
  map.occupy_box({-2.0, -0.05, 0.5}, {8.0, 0.15, 1.5});
  map.occupy_box({-8.0, -0.05, 0.5}, {-3.5, 0.15, 1.5});
  const std::vector<Vector3> path = {{-2.75, 1.5, 1}, {1, 1.5, 1}, {3, 1.5, 1}};
  ViewpointRules rules = published();
  rules.clearance_m = 0.9;
  rules.buffer_m = 1.0;
  const Vector3 watcher(-2.75, -3, 1);
  const Found closest = find_guiding_viewpoint(map, watcher, path, rules);
  rules.safe_space = SafeSpace::kMaxVisible;
  const Found most = find_guiding_viewpoint(map, watcher, path, rules);
  ASSERT_TRUE(closest.p_local_m && most.p_local_m);
  EXPECT_LT(closest.p_local_m->y(), 0.0);
  EXPECT_GT(most.p_local_m->y(), 0.0);
  EXPECT_GT(most.num_visible, closest.num_visible);
}

TEST(GuidingViewpoint, OffersEveryConnectedSpaceBestFirst) {
  // Seen through the gap from either room: a wall that no larger vehicle passes has a second space behind it.
  const CellListMap map = two_rooms(1.0);
  ViewpointRules rules = published();
  rules.safe_space = SafeSpace::kMaxVisible;
  rules.buffer_m = 1.0;
  const std::vector<Vector3> path = {{0.5, 0, 1}, {2, 0, 1}, {3.5, 0, 1}};
  const GuidingViewpoints all = find_guiding_viewpoints(map, {-2, 1, 1}, path, rules);
  ASSERT_GE(all.best_first.size(), 2U);
  for (std::size_t i = 1; i < all.best_first.size(); ++i) {
    EXPECT_LE(all.best_first[i].num_visible, all.best_first[i - 1].num_visible);
  }
  const auto east = [](const GuidingViewpoint& v) { return v.p_local_m.x() > 2.0; };
  EXPECT_TRUE(std::any_of(all.best_first.begin(), all.best_first.end(), east));
  EXPECT_FALSE(std::all_of(all.best_first.begin(), all.best_first.end(), east));
}

TEST(GuidingViewpoint, RespectsOcclusionByATableIn3d) {
  // The watcher's plane is above a table's top, the path below it: in the waypoint's own plane nothing stands between.
  CellListMap map;
  map.occupy_box({-2.5, -2.5, 1.4}, {2.5, 2.5, 1.5});
  const std::vector<Vector3> path = {{0, 0, 1}};
  ViewpointRules rules = published();
  rules.buffer_m = 1.0;
  rules.clearance_m = 0.3;
  const Vector3 watcher(4, 0, 2);
  const Found flat = find_guiding_viewpoint(map, watcher, path, rules);
  ASSERT_TRUE(flat.p_local_m);
  EXPECT_TRUE(map.first_hit(*flat.p_local_m, path[0])) << "the paper's visibility lies in the plane of the waypoint";
  rules.sight = Sight::kInSpace;
  const Found in_space = find_guiding_viewpoint(map, watcher, path, rules);
  EXPECT_FALSE(in_space.p_local_m && map.first_hit(*in_space.p_local_m, path[0]));
}

TEST(GuidingViewpoint, MatchesExhaustiveSearchInVisibleWaypoints) {
  CellListMap map;
  map.occupy_box({-1.0, 1.0, 0.8}, {-0.8, 3.0, 1.2});
  map.occupy_box({1.5, -2.5, 0.8}, {1.7, -0.7, 1.2});
  map.occupy_box({2.5, 0.9, 0.8}, {4.0, 1.1, 1.2});
  const std::vector<Vector3> path = {{-3, 0, 1}, {-1, 0, 1}, {1, 0, 1}, {2.5, 0, 1}, {4, 0, 1}};
  ViewpointRules rules;
  rules.sight = Sight::kInSpace;
  const Vector3 watcher(-4, -3, 1);
  const Found found = find_guiding_viewpoint(map, watcher, path, rules);
  int most = 0;
  for (int i = -90; i <= 100; ++i) {
    for (int j = -60; j <= 60; ++j) {
      const Vector3 p(0.1 * i + 0.05, 0.1 * j + 0.05, 1);
      if (contains(around_path(std::vector<Vector2>{{-3, 0}, {4, 0}}, rules.buffer_m), p.head<2>())) continue;
      if (map.clearance_m(p, 2.0) <= rules.clearance_m) continue;
      int seen = 0;
      for (const Vector3& waypoint : path) {
        if ((p - waypoint).norm() > rules.ray_max_m || map.first_hit(p, waypoint)) break;
        ++seen;
      }
      most = std::max(most, seen);
    }
  }
  EXPECT_EQ(found.num_visible, most);
  EXPECT_GT(most, 3);
}

}  // namespace
}  // namespace swiftlet
