// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/world/neighborhood.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet::sim {
namespace {

/// Vehicles of random radius on random paths that start in a cube with an edge of 30 m.
struct RandomTeam {
  explicit RandomTeam(int count) : states(count), radii_m(count) {
    for (int i = 0; i < count; ++i) {
      radii_m[i] = random.uniform(0.1, 0.8, 0, i);
      for (int axis = 0; axis < 3; ++axis) states[i].p_world_m[axis] = random.uniform(0.0, 30.0, 1 + axis, i);
    }
  }

  /// Moves each vehicle by a random step with a standard deviation of `step_m` per axis. Steps are constant for 40
  /// ticks, so that vehicles fly far enough to change their nearest neighbor.
  void move(std::uint32_t tick, double step_m) {
    for (std::size_t i = 0; i < states.size(); ++i) {
      const auto step = random.normal3(100 + tick / 40, static_cast<std::uint32_t>(i));
      states[i].p_world_m += step_m * Vector3(step[0], step[1], step[2]);
    }
  }

  /// All vehicles with the least gap to vehicle `i`: distance of centers less the other vehicle's radius.
  std::vector<VehicleId> nearest_to(VehicleId i, const std::vector<double>& radii) const {
    double least_m = std::numeric_limits<double>::infinity();
    std::vector<VehicleId> nearest;
    for (VehicleId j = 0; j < static_cast<VehicleId>(states.size()); ++j) {
      if (j == i) continue;
      const double gap_m = (states[i].p_world_m - states[j].p_world_m).norm() - radii[j];
      if (gap_m < least_m) nearest.clear();
      if (gap_m <= least_m) nearest.push_back(j);
      least_m = std::min(least_m, gap_m);
    }
    return nearest;
  }

  Random random{5, "neighborhood_test"};
  std::vector<VehicleState> states;
  std::vector<double> radii_m;
};

void expect_nearest_among_candidates(double step_m, bool with_radii) {
  RandomTeam team(60);
  const std::vector<double> radii_m = with_radii ? team.radii_m : std::vector<double>(60, 0.0);
  Neighborhood neighborhood(radii_m);
  for (std::uint32_t tick = 0; tick < 300; ++tick) {
    team.move(tick, step_m);
    neighborhood.update(team.states);
    for (VehicleId i = 0; i < 60; ++i) {
      const auto candidates = neighborhood.candidates(i);
      ASSERT_TRUE(std::is_sorted(candidates.begin(), candidates.end()));
      for (const VehicleId j : team.nearest_to(i, radii_m)) {
        ASSERT_TRUE(std::binary_search(candidates.begin(), candidates.end(), j))
            << "tick " << tick << ": " << j << " is nearest to " << i;
      }
    }
  }
}

TEST(Neighborhood, AlwaysContainsTheNearestVehicle) {
  for (const double step_m : {0.001, 0.02, 0.3, 5.0}) {
    expect_nearest_among_candidates(step_m, false);
    expect_nearest_among_candidates(step_m, true);
  }
}

TEST(Neighborhood, ContainsAllEquallyNearVehicles) {
  Neighborhood neighborhood(std::vector<double>(5, 0.0));
  std::vector<VehicleState> states(5);
  states[0].p_world_m = {1.0, 0.0, 0.0};
  states[1].p_world_m = {-1.0, 0.0, 0.0};
  states[3].p_world_m = {0.0, 1.0, 0.0};
  states[4].p_world_m = {100.0, 0.0, 0.0};
  neighborhood.update(states);
  const auto candidates = neighborhood.candidates(2);
  EXPECT_EQ(std::vector<VehicleId>(candidates.begin(), candidates.end()), (std::vector<VehicleId>{0, 1, 3}));
}

TEST(Neighborhood, HasFewCandidatesInSparseTeam) {
  std::vector<VehicleState> states(100);
  for (int i = 0; i < 100; ++i) states[i].p_world_m = {6.0 * (i % 10), 6.0 * (i / 10), 0.0};
  Neighborhood neighborhood(std::vector<double>(100, 0.3));
  neighborhood.update(states);
  for (VehicleId i = 0; i < 100; ++i) EXPECT_LE(neighborhood.candidates(i).size(), 4U);
}

TEST(Neighborhood, IsEmptyForSingleVehicle) {
  Neighborhood neighborhood({0.5});
  const std::vector<VehicleState> states(1);
  neighborhood.update(states);
  EXPECT_TRUE(neighborhood.candidates(0).empty());
}

}  // namespace
}  // namespace swiftlet::sim
