// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/octomap/octomap_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <sstream>

#include "swiftlet/core/map/occupancy_map.hpp"
#include "tests/support/file_test.hpp"

namespace swiftlet::sim {
namespace {

using testing::HasSubstr;
using OctomapFiles = FileTest;

MapVoxels some_map() {
  const auto map = make_occupancy_map({});
  for (int i = 0; i < 3; ++i) {
    map->insert(std::vector<OccupancyMap::Ray>{{{0.05F, 0.05F, 0.05F}, {3.05F, 0.05F, 0.05F}, true},
                                               {{0.05F, 0.05F, 0.05F}, {-1.0F, 2.2F, -0.7F}, i > 0}},
                i);
  }
  MapVoxels copy;
  map->append_voxels(copy);
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

TEST_F(OctomapFiles, AreRefusedWithReasonWhenInvalid) {
  const std::string whole = octomap_content(some_map(), OctomapFormat::kOt, {}),
                    binary = octomap_content(some_map(), OctomapFormat::kBt, {});
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = whole;
    return changed.replace(changed.find(from), from.size(), to);
  };
  const auto head = [](const std::string& content) { return content.substr(0, content.find("data\n") + 5); };
  const std::tuple<const char*, std::string, const char*> files[] = {
      {"a.bt", whole, "title"},
      {"b.ot", "ply\n", "title"},
      {"c.ot", whole.substr(0, whole.find("res")), "header"},
      {"d.ot", whole.substr(0, whole.find("data")), "ends with the line 'data'"},
      {"e.ot", with("id OcTree", "id ColorOcTree"), "header with the id OcTree"},
      {"f.ot", with("res 0.1", "res 0.0"), "resolution above 0"},
      {"g.ot", with("res 0.1", "res -0.1"), "resolution above 0"},
      {"h.ot", with("res 0.1", "res wide"), "header with id, size and res"},
      {"i.ot", with("size ", "size 1"), "as many nodes"},
      // Each of these sends the library's reader into endless recursion.
      {"j.ot", head(whole) + std::string(100, '\xff'), "deeper"},
      {"k.bt", head(binary) + std::string(100, '\xff'), "deeper"}};
  for (const auto& [name, content, reason] : files) {
    const auto file = write(name, content);
    EXPECT_THAT(refusal_of([&] { read_octomap(file); }), AllOf(HasSubstr(name), HasSubstr(reason)));
  }
  for (std::size_t cut = 1; cut < 60; ++cut) {
    for (const auto& file :
         {write("l.ot", whole.substr(0, whole.size() - cut)), write("m.bt", binary.substr(0, binary.size() - cut))})
      EXPECT_THAT(refusal_of([&] { read_octomap(file); }), HasSubstr("data")) << cut;
  }
  EXPECT_NO_THROW(read_octomap(write("n.ot", with("id OcTree", "\nid OcTree")))) << "empty lines do no harm";
  EXPECT_THROW(read_octomap(folder_ / "missing.bt"), InputError);
}

TEST_F(OctomapFiles, AnnounceTheirMemoryBeforeReading) {
  const auto file = write("map.bt", octomap_content(some_map(), OctomapFormat::kBt, {}));
  double announced_bytes = 0.0;
  read_octomap(file, [&](double bytes) { announced_bytes = bytes; });
  EXPECT_EQ(announced_bytes, static_cast<double>(some_map().size() * sizeof(Eigen::Vector3f)));
}

}  // namespace
}  // namespace swiftlet::sim
