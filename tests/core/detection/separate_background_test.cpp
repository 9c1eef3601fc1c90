// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/separate_background.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

VoxelMapConfig box(const Vector3& size_m) {
  VoxelMapConfig config;
  config.extent = VoxelMapConfig::Extent::kBounded;
  config.size_m = size_m;
  return config;
}

/// Connected components by labels that spread to a fixed point.
std::vector<std::ptrdiff_t> separate_slowly(const VoxelMap& map, double distance_m, int least_confident) {
  std::vector<std::ptrdiff_t> voxels;
  map.for_each_occupied([&](std::ptrdiff_t i) { voxels.push_back(i); });
  std::vector<std::size_t> label(voxels.size());
  for (std::size_t i = 0; i < label.size(); ++i) label[i] = i;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const double d_m =
            map.grid().edge_m * (map.grid().cell(voxels[i]) - map.grid().cell(voxels[j])).cast<double>().norm();
        if (d_m > distance_m || label[i] == label[j]) continue;
        label[i] = label[j] = std::min(label[i], label[j]);
        changed = true;
      }
    }
  }
  std::vector<int> confident(voxels.size(), 0);
  for (std::size_t i = 0; i < voxels.size(); ++i) confident[label[i]] += map.state(voxels[i]) == VoxelState::kConfident;
  std::vector<std::ptrdiff_t> out;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    if (confident[label[i]] < least_confident) out.push_back(voxels[i]);
  }
  return out;
}

TEST(SeparateBackground, AgreesWithLabelsThatSpread) {
  const Random random(1, "separate");
  SeparateBackground separator;
  std::size_t removed = 0, kept = 0;
  for (std::uint32_t trial = 0; trial < 24; ++trial) {
    // Rows of more than one word; sizes that are multiples of a block and sizes that are not.
    VoxelMap map(box(trial % 3 == 0   ? Vector3(18.0, 6.0, 3.0)
                     : trial % 3 == 1 ? Vector3(17.75, 5.25, 2.75)
                                      : Vector3(8.0, 7.25, 5.0)));
    const int least = trial % 5 == 0 ? 1 : trial % 5 == 1 ? 2 : 3;
    const double share = 0.002 + 0.02 * random.uniform(trial, 0);
    for (std::ptrdiff_t i = 0; i < map.grid().num_cells(); ++i) {
      const double u = random.uniform(trial, 10 + static_cast<std::uint32_t>(i));
      if (u < share) map.set(i, u < 0.3 * share ? 0.0F : -200.0F);
    }
    const double distance_m = trial % 4 == 0 ? 0.25 : trial % 4 == 1 ? 0.5 : trial % 4 == 2 ? 0.7 : 1.3;
    const auto found = separator.find(map, distance_m, least);
    ASSERT_EQ(found, separate_slowly(map, distance_m, least)) << "distance " << distance_m;
    removed += found.size();
    kept += map.num_occupied() - found.size();
  }
  EXPECT_GT(removed, 100u);
  EXPECT_GT(kept, 100u);
}

TEST(SeparateBackground, KeepsAllWithoutAMinimumSize) {
  SeparateBackground separator;
  VoxelMap map(box({3.0, 3.0, 3.0}));
  map.set(0, -200.0F);
  map.set(100, -200.0F);
  EXPECT_EQ(separator.find(map, 0.7, 1).size(), 2U);
  for (const int least : {0, -1}) EXPECT_TRUE(separator.find(map, 0.7, least).empty());
}

TEST(SeparateBackground, AnEmptyMapHasNone) {
  SeparateBackground separator;
  const VoxelMap map(box({3.0, 3.0, 3.0}));
  EXPECT_TRUE(separator.find(map, 0.7, 24).empty());
}

}  // namespace
}  // namespace swiftlet
