// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/math/assignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

struct Outcome {
  int pairs = 0;
  double cost = 0.0;
};

/// All assignments, by permutation of the longer side; dummies pad the shorter one.
Outcome best_by_brute_force(const std::vector<double>& costs, int rows, int cols) {
  const int n = std::max(rows, cols);
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  Outcome best{-1, 0.0};
  do {
    Outcome now;
    for (int r = 0; r < rows; ++r) {
      if (order[r] >= cols || costs[r * cols + order[r]] == Assignment::kForbidden) continue;
      ++now.pairs;
      now.cost += costs[r * cols + order[r]];
    }
    if (now.pairs > best.pairs || (now.pairs == best.pairs && now.cost < best.cost)) best = now;
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

TEST(Assignment, IsTheBestOfAllPairings) {
  Assignment assignment;
  for (std::uint32_t trial = 0; trial < 300; ++trial) {
    const Random random(trial, "test.assignment");
    const int rows = static_cast<int>(7 * random.uniform(0, 0)), cols = static_cast<int>(7 * random.uniform(0, 1));
    const double forbidden_share = random.uniform(0, 2);
    std::vector<double> costs(rows * cols);
    for (std::uint32_t i = 0; i < costs.size(); ++i) {
      costs[i] = random.uniform(2, i) < forbidden_share ? Assignment::kForbidden : random.uniform(-3.0, 10.0, 1, i);
    }
    const auto columns = assignment.solve(costs, rows, cols);
    Outcome ours;
    std::vector<int> used;
    for (int r = 0; r < rows; ++r) {
      if (columns[r] < 0) continue;
      ++ours.pairs;
      ours.cost += costs[r * cols + columns[r]];
      used.push_back(columns[r]);
    }
    std::sort(used.begin(), used.end());
    EXPECT_EQ(std::adjacent_find(used.begin(), used.end()), used.end()) << "a column twice";
    const Outcome best = best_by_brute_force(costs, rows, cols);
    EXPECT_EQ(ours.pairs, best.pairs) << trial;
    EXPECT_NEAR(ours.cost, best.cost, 1e-9) << trial;
  }
}

// A chain in which all rows find a partner only if each of them takes the dear one. As many as possible are paired,
// whatever that costs.
TEST(Assignment, MaximizesPairsBeforeMinimizingCost) {
  Assignment assignment;
  for (int n = 1; n <= 12; ++n) {
    for (const double cost : {1e-3, 1.0, 1e6}) {
      std::vector<double> costs(static_cast<std::size_t>(n) * n, Assignment::kForbidden);
      for (int r = 0; r < n; ++r) {
        if (r > 0) costs[static_cast<std::size_t>(r * n + r - 1)] = -cost;  // n - 1 pairs that cost little
        costs[static_cast<std::size_t>(r * n + r)] = cost;
      }
      const auto columns = assignment.solve(costs, n, n);
      for (int r = 0; r < n; ++r) EXPECT_EQ(columns[static_cast<std::size_t>(r)], r) << n << " " << cost;
    }
  }
}

TEST(Assignment, PairsNothingWithoutRowsOrColumns) {
  Assignment assignment;
  EXPECT_TRUE(assignment.solve({}, 0, 5).empty());
  const auto alone = assignment.solve({}, 3, 0);
  EXPECT_EQ(std::vector<int>(alone.begin(), alone.end()), (std::vector<int>{-1, -1, -1}));
}

}  // namespace
}  // namespace swiftlet
