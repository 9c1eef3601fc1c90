// SPDX-License-Identifier: BSD-3-Clause
// A vehicle that localizes itself by SLAM and plans through the map of its submaps.
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "swiftlet/core/base/map_voxels.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "tests/support/temporary_directory.hpp"

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

/// The file that the recorder wrote, as OctoMap's library itself reads it, has the cells of the map and nothing else.
void expect_octomap_has(const MapVoxels& map, const std::filesystem::path& file) {
  octomap::OcTree tree(1.0);
  ASSERT_TRUE(tree.readBinary(file.string()));
  EXPECT_DOUBLE_EQ(tree.getResolution(), map.edge_m);
  std::size_t num_occupied = 0, num_wrong = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    const Eigen::Vector3f& p = map.centers_local_m[i];
    const octomap::OcTreeNode* node = tree.search(p.x(), p.y(), p.z());
    const bool occupied = map.state[i] >= map.occupied_from;
    num_occupied += occupied;
    num_wrong += node == nullptr || tree.isNodeOccupied(node) != occupied;
  }
  EXPECT_EQ(num_wrong, 0U);
  EXPECT_GT(num_occupied, 1000U);
  EXPECT_GT(map.size(), 2 * num_occupied) << "free cells are there as well";
  std::size_t num_cells = 0;  // pruned leaves are cubes of cells
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    num_cells += std::size_t{1} << 3 * (tree.getTreeDepth() - leaf.getDepth());
  }
  EXPECT_EQ(num_cells, map.size()) << "the file contains the map's cells and no others";
}

// One round and the beginning of the next: the loop is closed when it comes by its start again.
TEST(SubmapFlight, ClosesItsLoopAndTouchesNothing) {
  const TemporaryDirectory folder;
  Simulation simulation(submap_navigation(75.0, {{"recorders", "[{type: map, format: bt, maps: [mapping]}]"}}), 2);
  simulation.attach_recorders(folder.path());
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
  // The walls of the building are at their places in the estimated world: x = 7 m and y = 4.5 m.
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
  const std::vector<std::filesystem::path> files = simulation.finish();
  ASSERT_EQ(files.size(), 1U);
  expect_octomap_has(map, folder.path() / files[0]);
}

TEST(SubmapFlightInFull, KeepsIdenticalBitsAfterLoopClosure) {
  std::uint64_t hashes[2] = {};
  MapVoxels maps[2];
  for (int threads : {1, 2}) {
    Simulation simulation(submap_navigation(75.0), threads);
    while (!simulation.finished()) simulation.tick();
    hashes[threads - 1] = simulation.state_hash();
    maps[threads - 1] = map_of(simulation);
    EXPECT_GE(simulation.view().actions[0]->estimate.correction_revision, 1U) << "the graph moved the map";
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_GT(maps[0].size(), 10000U);
  EXPECT_EQ(maps[0].centers_local_m, maps[1].centers_local_m);
  EXPECT_EQ(maps[0].state, maps[1].state);
}

TEST(SubmapFlight, IsRefusedWithoutAPoseGraph) {
  try {
    Simulation simulation(submap_navigation(1.0, {{"vehicles[0].agent.localization", "{type: ground_truth}"}}), 1);
    FAIL() << "a submap mapper is accepted without a pose graph";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("localization: expected {type: slam, global: {enabled: true}}"),
              std::string::npos)
        << error.what();
  }
}

TEST(SubmapFlight, RefusesMorePiecesThanMemoryHolds) {
  try {
    Simulation simulation(submap_navigation(1.0, {{"vehicles[0].agent.mapping.pieces_max", "1000000"}}), 1);
    FAIL() << "more pieces than fit in memory are accepted";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("mapping.pieces_max"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace swiftlet::sim
