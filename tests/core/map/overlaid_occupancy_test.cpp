// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/overlaid_occupancy.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

/// One ray from (0, 0, 2) to an occupied cell at (6, 0, 2).
const OccupancyMap& one_ray() {
  static const std::unique_ptr<OccupancyMap> map = [] {
    auto made = make_occupancy_map({});
    made->insert(std::vector<OccupancyMap::Ray>{{{0.05F, 0.05F, 2.05F}, {6.05F, 0.05F, 2.05F}, true}}, 1);
    return made;
  }();
  return *map;
}

const KeepOut kColumn = KeepOut::column({3.05, 0.05, 2.05}, 1.0, 4.0);
const KeepOut kBox = KeepOut::box({3.05, 0.05, 2.05}, {1.0, 2.0, 4.0});

TEST(OverlaidOccupancy, OccupiesPlacesAndKeepsMapElsewhere) {
  const OverlaidOccupancy view(one_ray(), {kColumn});
  EXPECT_EQ(view.state({3.05, 0.05, 3.85}), CellState::kOccupied);
  EXPECT_EQ(view.state({3.05, 0.05, 4.25}), CellState::kUnknown) << "above it";
  EXPECT_EQ(view.state({3.45, 0.45, 2.05}), CellState::kUnknown) << "a column is round";
  EXPECT_EQ(OverlaidOccupancy(one_ray(), {kBox}).state({3.45, 0.45, 2.05}), CellState::kOccupied);
  EXPECT_EQ(view.state({1.05, 0.05, 2.05}), CellState::kFree);
  EXPECT_EQ(view.state({6.05, 0.05, 2.05}), CellState::kOccupied);
  EXPECT_EQ(one_ray().state({3.05, 0.05, 2.05}), CellState::kFree) << "the map itself is unchanged";
}

TEST(OverlaidOccupancy, MeasuresDistanceToNearerOfBoth) {
  const OverlaidOccupancy view(one_ray(), {kColumn});
  EXPECT_NEAR(view.distance_m({1.05, 0.05, 2.05}, 10.0), 1.5, 1e-9);
  EXPECT_NEAR(view.distance_m({5.05, 0.05, 2.05}, 10.0), 0.95, 1e-9) << "the cell of the map begins at 6 m";
  EXPECT_NEAR(view.clearance_m({2.05, 0.05, 2.05}, 3.0), 0.5, 1e-9);
  EXPECT_NEAR(view.clearance_m({5.55, 0.05, 2.05}, 3.0), 0.5, 1e-9);
  EXPECT_EQ(view.distance_m({3.05, 0.05, 2.05}, 10.0), 0.0);
  EXPECT_NEAR(view.distance_m({3.05, 0.05, 5.05}, 10.0), 1.0, 1e-9) << "straight above";
  EXPECT_NEAR(view.distance_m({1.05, 0.05, 2.05}, 1.0), 1.0, 1e-9) << "bounded";
}

TEST(OverlaidOccupancy, ASegmentHitsWhatComesFirst) {
  const OverlaidOccupancy view(one_ray(), {kColumn});
  const auto through = view.first_hit({0.05, 0.05, 2.05}, {10.05, 0.05, 2.05});
  ASSERT_TRUE(through.has_value());
  EXPECT_NEAR(through->distance_m, 2.5, 1e-9);
  EXPECT_NEAR(view.first_hit({4.05, 0.05, 2.05}, {10.05, 0.05, 2.05})->distance_m, 1.95, 1e-9) << "behind the column";
  EXPECT_FALSE(view.first_hit({0.05, 0.05, 8.05}, {10.05, 0.05, 8.05}).has_value());
  EXPECT_EQ(view.first_hit({3.05, 0.05, 2.05}, {10.05, 0.05, 2.05})->distance_m, 0.0)
      << "the segment begins inside the column";
  EXPECT_FALSE(view.first_hit({0.05, 0.05, 2.05}, {2.45, 0.05, 2.05}).has_value())
      << "the segment ends before the column";
}

// Random points and segments against a fine walk along the segment.
TEST(KeepOut, IsEnteredWhereDistanceBecomesZero) {
  const Random random(3, "segments");
  int entered = 0;
  for (std::uint32_t k = 0; k < 400; ++k) {
    const auto point = [&](std::uint32_t i) {
      return Vector3(random.uniform(1.0, 5.0, k, i), random.uniform(-2.0, 2.0, k, i + 1),
                     random.uniform(-1.0, 5.0, k, i + 2));
    };
    const Vector3 from = point(0), to = point(3);
    const KeepOut& keep_out = k % 2 == 0 ? kColumn : kBox;
    constexpr int kSteps = 4000;
    double expected = -1.0;
    for (int i = 0; i <= kSteps && expected < 0.0; ++i) {
      if (keep_out.contains(from + (to - from) * (static_cast<double>(i) / kSteps))) {
        expected = (to - from).norm() * i / kSteps;
      }
    }
    const auto found = keep_out.entered_after_m(from, to);
    if (expected < 0.0) {
      // A graze that the fine walk misses.
      EXPECT_TRUE(!found || keep_out.distance_m(from + (to - from).normalized() * *found) < 2e-3) << k;
      continue;
    }
    ++entered;
    ASSERT_TRUE(found.has_value()) << k;
    EXPECT_NEAR(*found, expected, 2e-3) << k;
  }
  EXPECT_GT(entered, 50);
}

TEST(KeepOut, IsEnteredAlongAxes) {
  for (const KeepOut& place : {KeepOut::box({0, 0, 0}, {1, 1, 1}), KeepOut::column({0, 0, 0}, 1, 1)}) {
    EXPECT_EQ(place.entered_after_m({0.1, 0.1, 0.1}, {0.1, 0.1, 0.1}).value_or(-1.0), 0.0);
    EXPECT_FALSE(place.entered_after_m({2, 0, 0}, {2, 0, 0}));
    EXPECT_NEAR(place.entered_after_m({0.2, 0.2, 3}, {0.2, 0.2, -3}).value_or(-1.0), 2.5, 1e-12);
    EXPECT_FALSE(place.entered_after_m({0.6, 0.2, 3}, {0.6, 0.2, -3}));
    EXPECT_NEAR(place.entered_after_m({-3, 0, 0.2}, {3, 0, 0.2}).value_or(-1.0), 2.5, 1e-12);
    EXPECT_FALSE(place.entered_after_m({-3, 0, 0.6}, {3, 0, 0.6}));
    EXPECT_FALSE(place.entered_after_m({-3, 0, 0}, {-1, 0, 0}));
    EXPECT_NEAR(place.distance_m({1.5, 0, 1.5}), std::sqrt(2.0), 1e-12);
  }
}

// A fine walk through the box meets the same cells.
TEST(OverlaidOccupancy, CollectsCellsIntersectingBox) {
  const OverlaidOccupancy view(one_ray(), {kBox});
  const Vector3 low(2.72, -0.37, 0.93), high(3.22, 0.38, 1.47);
  for (const auto& [min, max] : {std::pair(low, high), std::pair(Vector3(low.array() + 0.06), high)}) {
    std::vector<Vector3> cells;
    view.occupied_in(min, max, cells);
    std::size_t expected = 0;
    for (double z = 0.05; z < 4.0; z += 0.1) {
      for (double y = -1.95; y < 2.0; y += 0.1) {
        for (double x = 0.05; x < 6.0; x += 0.1) {
          const Vector3 center(x, y, z);
          const Eigen::AlignedBox3d cell(Vector3(center.array() - 0.05), Vector3(center.array() + 0.05));
          expected += kBox.contains(center) && cell.intersects(Eigen::AlignedBox3d(min, max)) ? 1 : 0;
        }
      }
    }
    EXPECT_EQ(cells.size(), expected);
    EXPECT_GT(expected, 50U);
  }
}

TEST(OverlaidOccupancy, CollectsItsCellsOnce) {
  const OverlaidOccupancy view(one_ray(), {kBox, kColumn});
  std::vector<Vector3> cells, inside;
  view.occupied_in(Vector3::Constant(-1.0), Vector3::Constant(10.0), cells);
  const auto less = [](const Vector3& a, const Vector3& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::sort(cells.begin(), cells.end(), less);
  EXPECT_EQ(std::adjacent_find(cells.begin(), cells.end()), cells.end());
  EXPECT_EQ(std::count_if(cells.begin(), cells.end(), [](const Vector3& c) { return kBox.contains(c); }),
            std::ssize(cells) - 1)
      << "all cells but the one of the map lie in the box";
  view.occupied_within({3.05, 0.05, 2.05}, 1.0, kEver, inside);
  for (const Vector3& cell : inside) {
    EXPECT_LE(((cell - Vector3(3.05, 0.05, 2.05)).cwiseAbs().array() - 0.05).cwiseMax(0.0).matrix().norm(), 1.0);
  }
  EXPECT_GT(inside.size(), 500U);
}

}  // namespace
}  // namespace swiftlet
