// SPDX-License-Identifier: BSD-3-Clause
// A vehicle that knows where it is by SLAM and plans through the map of its submaps.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "swiftlet/core/map_voxels.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::sim {
namespace {

Scenario submap_navigation(double duration_s, ConfigChanges changes = {}) {
  changes.insert(changes.begin(), {{"recorders", "[]"}, {"snapshots", "[]"}});
  Scenario scenario = load_scenario(std::string(SWIFTLET_SOURCE_DIR) + "/scenarios/submap_navigation.yaml", changes);
  scenario.duration_s = duration_s;
  return validated(scenario);
}

MapVoxels map_of(const Simulation& simulation) {
  std::vector<MapVoxels> maps;
  simulation.view().agents[0]->append_maps(maps);
  const auto found = std::find_if(maps.begin(), maps.end(), [](const MapVoxels& m) { return m.name == "mapping"; });
  return found == maps.end() ? MapVoxels{} : *found;
}

// One round and the beginning of the next: the loop is closed when it comes by its start again.
TEST(SubmapFlight, ClosesItsLoopAndFliesOnThroughTheMapThatMovedWithoutTouchingAnything) {
  Simulation simulation(submap_navigation(75.0), 2);
  std::uint32_t corrections = 0;
  while (!simulation.finished()) {
    simulation.tick();
    const StateEstimate& e = simulation.view().actions[0]->estimate;
    ASSERT_TRUE(e.valid) << to_seconds(simulation.now()) << " s";
    corrections = e.correction_revision;
  }
  const RunSummary summary = simulation.summary();
  EXPECT_NE(summary.outcome, "crashed");
  EXPECT_NE(simulation.view().actions[0]->mission, MissionStatus::kFailed)
      << simulation.view().actions[0]->mission_note;
  EXPECT_GE(corrections, 1U) << "a loop was closed";
  EXPECT_GT(summary.metrics.find("path_length_m", "uav1")->value, 90.0);
  // The walls of the building are where they are, in the world as the vehicle knows it: x = 7 m and y = 4.5 m.
  const MapVoxels map = map_of(simulation);
  const StateEstimate& e = simulation.view().actions[0]->estimate;
  int on_wall = 0, inside = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (map.state[i] < map.occupied_from) continue;
    const Vector3 p_world_m = e.T_world_local * map.centers_local_m[i].cast<double>();
    if (p_world_m.z() < 1.0 || p_world_m.z() > 2.5 || std::abs(p_world_m.x()) > 8.0 || std::abs(p_world_m.y()) > 5.5) {
      continue;
    }
    const double off_m = std::max(std::abs(p_world_m.x()) - 7.0, std::abs(p_world_m.y()) - 4.5);
    (std::abs(off_m) < 0.8 ? on_wall : inside) += 1;
  }
  EXPECT_GT(on_wall, 500);
  EXPECT_LT(inside, on_wall / 10);
}

TEST(SubmapFlight, HasTheSameBitsOnAnyNumberOfThreads) {
  std::uint64_t hashes[2] = {};
  std::size_t cells[2] = {};
  for (int threads : {1, 2}) {
    Simulation simulation(submap_navigation(5.0), threads);
    while (!simulation.finished()) simulation.tick();
    hashes[threads - 1] = simulation.state_hash();
    cells[threads - 1] = map_of(simulation).size();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(cells[0], cells[1]);
  EXPECT_GT(cells[0], 10000U);
}

TEST(SubmapFlight, WithoutAPoseGraphItIsRefused) {
  try {
    Simulation simulation(submap_navigation(1.0, {{"vehicles[0].agent.localization", "{type: ground_truth}"}}), 1);
    FAIL() << "it took a map of submaps without submaps";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("localization: expected {type: slam, global: {enabled: true}}"),
              std::string::npos)
        << error.what();
  }
}

TEST(SubmapFlight, MorePiecesThanTheMemoryHoldsAreRefusedByTheirKey) {
  try {
    Simulation simulation(submap_navigation(1.0, {{"vehicles[0].agent.mapping.pieces_max", "1000000"}}), 1);
    FAIL() << "it took a map that fits nowhere";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("mapping.pieces_max"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace swiftlet::sim
