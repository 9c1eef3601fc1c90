// SPDX-License-Identifier: BSD-3-Clause
// One UAV guides three in the full simulation: they are identified by their motion, and take turns.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "swiftlet/sim/metrics/relative_score.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::sim {
namespace {

TEST(GuidedTeamInFull, AllThreeArriveInTurn) {
  const Scenario scenario =
      load_scenario("guided_team", {{"recorders", "[]"}, {"snapshots", "[]"}, {"metrics.stop_on_crash", "true"}});
  Simulation simulation(scenario);
  std::vector<Vector3> starts_m;
  std::set<VehicleId> crashed;
  double worst_m = 0.0;
  int most_guided = 0;
  while (!simulation.finished()) {
    simulation.tick();
    const TickView& view = simulation.view();
    if (starts_m.empty()) {
      for (const auto& state : view.states) starts_m.push_back(state.p_world_m);
    }
    for (const Event& event : view.events) {
      if (event.kind == "crash") crashed.insert(event.vehicle);
    }
    for (const RelativeScore& score : rows_of<RelativeScore>(simulation.info().series)) {
      worst_m = std::max(worst_m, score.error_world_m.norm());
    }
    int guided = 0;
    for (std::size_t i = 1; i < view.actions.size(); ++i) {
      guided += view.actions[i]->mission_note == "following the guide";
    }
    most_guided = std::max(most_guided, guided);
  }
  EXPECT_EQ(simulation.summary().outcome, "done");
  EXPECT_TRUE(crashed.empty());
  EXPECT_EQ(most_guided, 1) << "one moves, the others hover";
  EXPECT_LT(worst_m, 1.0) << "taken for another one, it would be 3 m off";
  for (std::size_t i = 1; i < starts_m.size(); ++i) {
    EXPECT_GT(simulation.view().states[i].p_world_m.x() - starts_m[i].x(), 6.0) << i;
  }
}

}  // namespace
}  // namespace swiftlet::sim
