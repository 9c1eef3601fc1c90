// SPDX-License-Identifier: BSD-3-Clause
// Cells of octrees one by one, at the ends of what they can hold.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <sstream>

#include "swiftlet/sim/octomap/octomap_file.hpp"
#include "tests/support/file_test.hpp"

namespace swiftlet::sim {
namespace {

using testing::HasSubstr;
using testing::UnorderedElementsAreArray;

MapVoxels map_of(double edge_m, bool log_odds) {
  MapVoxels map;
  map.edge_m = edge_m;
  map.states = {"free", "uncertain", "occupied"};
  map.occupied_from = 2;
  map.log_odds = log_odds;
  return map;
}

class CellsOfOctrees : public FileTest {
 protected:
  OctomapCells read(const std::string& name, const std::string& content) const {
    return read_octomap(write(name, content));
  }
  std::string refusal(const std::string& name, const std::string& content) const {
    return refusal_of([&] { read(name, content); });
  }
};

// Blocks of any size that are all free or all occupied come back cell by cell, wherever they lie.
TEST_F(CellsOfOctrees, SurviveAnyPlacementAndPruning) {
  const double edge_m = 0.25;
  MapVoxels map = map_of(edge_m, false);
  std::vector<std::array<int, 3>> occupied, free;
  const auto add = [&](int x, int y, int z, int state) {
    map.add({(x + 0.5) * edge_m, (y + 0.5) * edge_m, (z + 0.5) * edge_m}, static_cast<std::uint8_t>(state), 0.0F);
    if (state == 2) occupied.push_back({x, y, z});
    if (state == 0) free.push_back({x, y, z});
  };
  for (int x = 0; x < 4; ++x) {  // one node of 4 x 4 x 4 cells, and one of 2 x 2 x 2
    for (int y = 0; y < 4; ++y) {
      for (int z = 0; z < 4; ++z) add(x, y, z, 2);
    }
  }
  for (int x = 0; x < 2; ++x) {
    for (int y = 0; y < 2; ++y) {
      for (int z = 0; z < 2; ++z) add(x - 6, y - 2, z + 10, 0);
    }
  }
  add(-1, -1, -1, 2);
  add(100, -50, 7, 0);
  add(3, -9, 4, 1);  // unknown state
  add(32767, -32768, 32767, 2);
  const auto cells_of = [&](const std::vector<Eigen::Vector3f>& centers_m) {
    std::vector<std::array<int, 3>> cells;
    for (const Eigen::Vector3f& p : centers_m) {
      std::array<int, 3> cell{};
      for (int axis = 0; axis < 3; ++axis) {
        cell[axis] = static_cast<int>(std::floor(p[axis] / edge_m));
        EXPECT_NEAR(p[axis], (cell[axis] + 0.5) * edge_m, 1e-3);
      }
      cells.push_back(cell);
    }
    return cells;
  };
  for (const auto& [format, name] : {std::pair{OctomapFormat::kOt, "a.ot"}, {OctomapFormat::kBt, "a.bt"}}) {
    const std::string content = octomap_content(map, format, {"one", "two"});
    EXPECT_THAT(content, HasSubstr("# one\n# two\n"));
    const OctomapCells cells = read(name, content);
    EXPECT_EQ(cells.edge_m, edge_m);
    EXPECT_THAT(cells_of(cells.occupied_m), UnorderedElementsAreArray(occupied)) << name;
    EXPECT_THAT(cells_of(cells.free_m), UnorderedElementsAreArray(free)) << name;
  }
}

TEST_F(CellsOfOctrees, OmitCellsBeyondTheTree) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const auto& [cell, is_in] : {std::pair(32767, true), {32768, false}, {-32768, true}, {-32769, false}}) {
      MapVoxels map = map_of(0.5, false);
      Vector3 p = Vector3::Constant(0.25);
      p[axis] = 0.5 * (cell + 0.5);
      map.add(p, 2, 0.0F);
      const OctomapCells cells = read("a.ot", octomap_content(map, OctomapFormat::kOt, {}));
      ASSERT_EQ(cells.occupied_m.size(), is_in ? 1U : 0U) << axis << " " << cell;
      if (is_in) {
        EXPECT_NEAR(cells.occupied_m[0][axis], p[axis], 1e-3);
      }
    }
  }
  MapVoxels odd = map_of(0.5, false);
  odd.add(Vector3::Constant(std::nan("")), 2, 0.0F);
  EXPECT_TRUE(read("a.ot", octomap_content(odd, OctomapFormat::kOt, {})).occupied_m.empty());
}

std::unique_ptr<octomap::OcTree> tree_of(const MapVoxels& map) {
  std::istringstream in(octomap_content(map, OctomapFormat::kOt, {}));
  return std::unique_ptr<octomap::OcTree>(dynamic_cast<octomap::OcTree*>(octomap::AbstractOcTree::read(in)));
}

TEST(Octrees, KeepLogOddsAndClampStates) {
  MapVoxels odds = map_of(0.1, true), states = map_of(0.1, false);
  const std::vector<float> values = {-15.0F, -2.0F, -0.1F, 0.3F, 3.5F, 15.0F};
  for (std::size_t i = 0; i < values.size(); ++i)
    odds.add({0.05 + 0.3 * static_cast<double>(i), 0.05, 0.05}, 1, values[i]);
  const auto tree = tree_of(odds);
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_FLOAT_EQ(tree->search(0.05 + 0.3 * static_cast<double>(i), 0.05, 0.05)->getLogOdds(), values[i]);
  states.add({0.05, 0.05, 0.05}, 2, 0.0F);
  states.add({0.35, 0.05, 0.05}, 0, 0.0F);
  const auto clamped = tree_of(states);
  const octomap::OcTree usual(0.1);
  EXPECT_EQ(clamped->search(0.05, 0.05, 0.05)->getLogOdds(), usual.getClampingThresMaxLog());
  EXPECT_EQ(clamped->search(0.35, 0.05, 0.05)->getLogOdds(), usual.getClampingThresMinLog());
}

TEST_F(CellsOfOctrees, AreWrittenWithoutNodesWhenEmpty) {
  for (const auto& [format, name] : {std::pair{OctomapFormat::kOt, "a.ot"}, {OctomapFormat::kBt, "a.bt"}}) {
    const std::string content = octomap_content(map_of(0.2, false), format, {});
    EXPECT_THAT(content, HasSubstr("size 0\nres 0.2\ndata\n"));
    const OctomapCells cells = read(name, content);
    EXPECT_TRUE(cells.occupied_m.empty() && cells.free_m.empty());
    EXPECT_EQ(cells.edge_m, 0.2);
  }
  EXPECT_FALSE(is_octomap_file("a.pcd"));
  EXPECT_TRUE(is_octomap_file("a.bt"));
}

/// A single chain of nodes down to a depth, as each format writes it.
std::string chain(int depth, bool binary) {
  std::string data;
  for (int level = 0; level < depth; ++level) {
    if (binary) {
      const bool last = level + 1 == depth;
      data += last ? std::string("\x02\x00", 2) : std::string("\x03\x00", 2);  // an occupied leaf; a node
    } else {
      const float value = 1.0F;
      data.append(reinterpret_cast<const char*>(&value), 4);
      data += '\x01';
    }
  }
  if (!binary) {
    const float value = 1.0F;
    data.append(reinterpret_cast<const char*>(&value), 4);
    data += '\x00';
  }
  const std::string title = binary ? "# Octomap OcTree binary file\n" : "# Octomap OcTree file\n";
  return title + "id OcTree\nsize " + std::to_string(depth + 1) + "\nres 0.1\ndata\n" + data;
}

TEST_F(CellsOfOctrees, LieSixteenLevelsDeepAtMost) {
  for (const bool binary : {false, true}) {
    const std::string name = binary ? "a.bt" : "a.ot";
    const OctomapCells cells = read(name, chain(16, binary));
    EXPECT_EQ(cells.occupied_m.size(), 1U) << name;
    EXPECT_THAT(refusal(name, chain(17, binary)), HasSubstr("expected a tree of 16 levels"));
    // A leaf a level higher stands for eight cells.
    EXPECT_EQ(read(name, chain(15, binary)).occupied_m.size(), 8U) << name;
    EXPECT_EQ(read(name, chain(14, binary)).occupied_m.size(), 64U) << name;
    EXPECT_THAT(refusal(name, chain(16, binary) + std::string(9, '\0')), HasSubstr("nothing was thrown"));
    EXPECT_THAT(refusal(name, chain(16, binary).substr(0, chain(16, binary).size() - 1)),
                HasSubstr("ends before its data"));
  }
}

}  // namespace
}  // namespace swiftlet::sim
