// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/vofod_config.hpp"

#include <gtest/gtest.h>

#include "swiftlet/core/map/voxel_map.hpp"
#include "tests/support/config_checks.hpp"

namespace swiftlet {
namespace {

using test::ConfigChecks;

TEST(VofodConfig, ReportsTheMemoryOfItsMap) {
  VofodConfig config;
  config.map.extent = VoxelMapConfig::Extent::kBounded;
  config.map.size_m = {10.0, 20.0, 5.0};
  const double values = sizeof(float) * static_cast<double>(VoxelMap(config.map).grid().num_cells());
  EXPECT_GE(config.map_bytes(), values);
  EXPECT_LE(config.map_bytes(), 1.2 * values);
  config.map.size_m.setConstant(200.0);
  config.ray_max_m = 10.0;
  const double window = config.ray_window_bytes();
  config.ray_max_m = 20.0;
  EXPECT_GT(config.ray_window_bytes(), window) << "longer rays need a larger window";
}

TEST(VofodConfig, IsBoundedByItsVoxels) {
  EXPECT_TRUE(ConfigChecks(VofodConfig{}).problems().empty());
  for (const auto& [distance, key] : {std::pair(&VofodConfig::search_distance_m, "search_distance_m"),
                                      std::pair(&VofodConfig::close_distance_m, "close_distance_m"),
                                      std::pair(&VofodConfig::cluster_distance_m, "cluster_distance_m")}) {
    VofodConfig config;
    config.*distance = 1000.0;
    EXPECT_TRUE(ConfigChecks(config).refuses(key)) << key;
  }
  VofodConfig tiny;
  tiny.map.voxel_m = 0.0139;
  EXPECT_TRUE(ConfigChecks(tiny).refuses("map.voxel_m"));
  tiny.map.voxel_m = 0.0141;
  EXPECT_FALSE(ConfigChecks(tiny).refuses("map.voxel_m"));
  VofodConfig config;
  config.map.voxel_m = 0.1;
  config.map.size_m.setConstant(1000.0);
  config.ray_max_m = 500.0;
  EXPECT_TRUE(ConfigChecks(config).refuses("ray_max_m"));
}

}  // namespace
}  // namespace swiftlet
