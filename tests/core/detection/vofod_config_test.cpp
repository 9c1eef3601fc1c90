// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/vofod_config.hpp"

#include <gtest/gtest.h>

#include "tests/support/config_checks.hpp"

namespace swiftlet {
namespace {

using testing::ConfigChecks;

// Per voxel a value of four bytes and an occupancy bit.
TEST(VofodConfig, ReportsTheMemoryOfItsMap) {
  VofodConfig config;
  config.map.voxel_m = 0.5;
  config.map.size_m = {10.0, 20.0, 5.0};
  EXPECT_DOUBLE_EQ(config.map_bytes(), 20.0 * 40.0 * 10.0 * 4.125);
}

// The window covers the length of rays plus the motion of the sensor in a sweep, or the map plus its scrolling.
TEST(VofodConfig, ReportsMemoryOfItsRayWindow) {
  VofodConfig config;
  config.map.voxel_m = 0.5;
  config.ray_max_m = 15.0;
  config.map.size_m = {200.0, 2.0, 300.0};
  const double around = (15.0 + 15.0 + 10.0) / 0.5, map_y = 4.0 + 32.0 + 32.0;
  EXPECT_DOUBLE_EQ(config.ray_window_bytes(), around * map_y * around * 4.0);
}

TEST(VofodConfig, IsBoundedByItsVoxels) {
  EXPECT_TRUE(ConfigChecks(VofodConfig{}).refuses_nothing());
  const auto with = [](auto&& change) {
    VofodConfig config;
    config.map.voxel_m = 0.1;
    config.map.size_m = {8.0, 8.0, 8.0};
    change(config);
    return ConfigChecks(config);
  };
  for (const auto& [distance, key] : {std::pair(&VofodConfig::separate_distance_m, "separate_distance_m"),
                                      std::pair(&VofodConfig::search_distance_m, "search_distance_m"),
                                      std::pair(&VofodConfig::close_distance_m, "close_distance_m"),
                                      std::pair(&VofodConfig::cluster_distance_m, "cluster_distance_m")}) {
    EXPECT_FALSE(with([&, d = distance](VofodConfig& c) { c.*d = 4.99; }).refuses(key)) << key;
    EXPECT_TRUE(with([&, d = distance](VofodConfig& c) { c.*d = 5.01; }).refuses(key)) << key;
  }
  // 1250 voxels by axis are 1.95e9, 1270 are 2.05e9.
  const auto window = [&](double around_m) {
    return with([&](VofodConfig& c) {
      c.map.size_m.setConstant(1000.0);
      c.ray_max_m = (around_m - 10.0) / 2.0;
    });
  };
  EXPECT_FALSE(window(125.0).refuses("ray_max_m"));
  EXPECT_TRUE(window(127.0).refuses("ray_max_m"));
}

}  // namespace
}  // namespace swiftlet
