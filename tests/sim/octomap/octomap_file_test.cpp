// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/octomap/octomap_file.hpp"

#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <fstream>
#include <sstream>

#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/sim/errors.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

MapVoxels some_map() {
  OccupancyMap map({});
  for (int i = 0; i < 3; ++i) {
    map.insert(std::vector<OccupancyMap::Ray>{{{0.05F, 0.05F, 0.05F}, {3.05F, 0.05F, 0.05F}, true},
                                              {{0.05F, 0.05F, 0.05F}, {-1.0F, 2.2F, -0.7F}, i > 0}},
               i);
  }
  MapVoxels copy;
  map.append_voxels(copy);
  return copy;
}

TEST(OctomapFile, HoldsLogOddsOfEveryCell) {
  const MapVoxels map = some_map();
  std::istringstream in(octomap_content(map, OctomapFormat::kOt, {"frame uav1/local"}));
  EXPECT_NE(in.str().find("\n# frame uav1/local\n"), std::string::npos);
  const std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(in));
  auto* tree = dynamic_cast<octomap::OcTree*>(read.get());
  ASSERT_NE(tree, nullptr);
  tree->expand();
  EXPECT_EQ(tree->getNumLeafNodes(), map.size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    const Eigen::Vector3f& at = map.centers_local_m[i];
    const octomap::OcTreeNode* node = tree->search(at.x(), at.y(), at.z());
    ASSERT_NE(node, nullptr);
    EXPECT_EQ(node->getLogOdds(), map.value[i]);
    EXPECT_EQ(tree->isNodeOccupied(node), map.state[i] == 1);
  }
}

TEST(OctomapFile, IsReadBackAsCells) {
  const MapVoxels map = some_map();
  TemporaryDirectory directory;
  for (const auto& [format, name] :
       {std::pair{OctomapFormat::kOt, "map.ot"}, std::pair{OctomapFormat::kBt, "map.bt"}}) {
    const auto file = directory.path() / name;
    std::ofstream(file, std::ios::binary) << octomap_content(map, format, {});
    EXPECT_TRUE(is_octomap_file(file));
    const OctomapCells cells = read_octomap(file);
    EXPECT_EQ(cells.edge_m, 0.1);
    const auto occupied = static_cast<std::size_t>(std::count(map.state.begin(), map.state.end(), 1));
    EXPECT_EQ(cells.occupied_m.size(), occupied) << name;
    EXPECT_EQ(cells.free_m.size(), map.size() - occupied) << name;
    for (const Eigen::Vector3f& p : cells.occupied_m) {
      EXPECT_TRUE(std::any_of(map.centers_local_m.begin(), map.centers_local_m.end(),
                              [&](const Eigen::Vector3f& q) { return (p - q).norm() < 1e-4F; }));
    }
  }
}

// A detector's map has other values and more states: what is neither free nor occupied is left out.
TEST(OctomapFile, ExportsStatesOfOtherMapTypes) {
  MapVoxels map;
  map.edge_m = 0.25;
  map.states = {"free", "uncertain", "tentative", "confident"};
  map.occupied_from = 2;
  for (int state = 0; state < 4; ++state) {
    map.add({0.125 + 0.25 * state, 0.125, 0.125}, static_cast<std::uint8_t>(state), -1000.0F);
  }
  std::istringstream in(octomap_content(map, OctomapFormat::kBt, {}));
  octomap::OcTree tree(0.1);
  ASSERT_TRUE(tree.readBinary(in));
  EXPECT_EQ(tree.getResolution(), 0.25);
  const auto occupied = [&](double x) {
    const octomap::OcTreeNode* node = tree.search(x, 0.125, 0.125);
    return node == nullptr ? -1 : tree.isNodeOccupied(node) ? 1 : 0;
  };
  EXPECT_EQ(occupied(0.125), 0);
  EXPECT_EQ(occupied(0.375), -1);
  EXPECT_EQ(occupied(0.625), 1);
  EXPECT_EQ(occupied(0.875), 1);
}

TEST(OctomapFile, RefusesInvalidFilesWithReason) {
  const TemporaryDirectory directory;
  const auto refusal = [&](const char* name, const std::string& content) -> std::string {
    std::ofstream(directory.path() / name, std::ios::binary) << content;
    try {
      read_octomap(directory.path() / name);
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
      return error.what();
    }
    return "";
  };
  const std::string whole = octomap_content(some_map(), OctomapFormat::kOt, {});
  EXPECT_NE(refusal("a.bt", whole).find("title"), std::string::npos) << "the other format";
  EXPECT_NE(refusal("b.ot", "ply\n").find("title"), std::string::npos);
  EXPECT_NE(refusal("c.ot", whole.substr(0, whole.size() - 40)).find("data"), std::string::npos) << "cut off";
  EXPECT_NE(refusal("d.ot", whole.substr(0, whole.find("res"))).find("header"), std::string::npos);
  std::string flat = whole;
  flat.replace(flat.find("res 0.1"), 7, "res 0.0");
  EXPECT_NE(refusal("e.ot", flat).find("resolution"), std::string::npos);
  EXPECT_THROW(read_octomap(directory.path() / "missing.bt"), InputError);
  // Each of these sends the library's reader into endless recursion.
  const std::string head = whole.substr(0, whole.find("data\n") + 5);
  EXPECT_NE(refusal("f.ot", head + std::string(100, '\xff')).find("deeper"), std::string::npos);
  const std::string binary = octomap_content(some_map(), OctomapFormat::kBt, {});
  EXPECT_NE(refusal("g.bt", binary.substr(0, binary.find("data\n") + 5) + std::string(100, '\xff')).find("deeper"),
            std::string::npos);
  for (std::size_t cut = 1; cut < 60; ++cut) {
    EXPECT_NE(refusal("h.ot", whole.substr(0, whole.size() - cut)).find("data"), std::string::npos) << cut;
    EXPECT_NE(refusal("i.bt", binary.substr(0, binary.size() - cut)).find("data"), std::string::npos) << cut;
  }
}

TEST(OctomapFile, AsksBeforeItTakesMemory) {
  TemporaryDirectory directory;
  const auto file = directory.path() / "map.bt";
  std::ofstream(file, std::ios::binary) << octomap_content(some_map(), OctomapFormat::kBt, {});
  double asked = 0.0;
  read_octomap(file, [&](double bytes) { asked = bytes; });
  EXPECT_EQ(asked, static_cast<double>(some_map().size() * sizeof(Eigen::Vector3f)));
}

}  // namespace
}  // namespace swiftlet::sim
