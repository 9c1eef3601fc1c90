// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/air_map.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/config_checks.hpp"

namespace swiftlet {
namespace {

using testing::ConfigChecks;

TEST(AirMap, IgnoresBeamsWithNonFiniteEnds) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  AirMapConfig config;
  config.size_m = {4.0, 4.0, 4.0};
  AirMap map(config);
  map.follow(Vector3::Zero());
  for (const double bad : {kNaN, kInf, -kInf}) {
    for (int axis = 0; axis < 3; ++axis) {
      Vector3 at_m(0.3, 0.3, 0.3);
      at_m[axis] = bad;
      map.pass(at_m, {0.1, 0.2, 0.3});
      map.pass({0.1, 0.2, 0.3}, at_m);
    }
  }
  for (double x = -1.75; x < 2.0; x += 0.5) {
    for (double y = -1.75; y < 2.0; y += 0.5) {
      for (double z = -1.75; z < 2.0; z += 0.5) ASSERT_EQ(map.clutter_share({x, y, z}), map.prior_share());
    }
  }
}

TEST(AirMap, RoundsBoxesToPowersOfTwo) {
  AirMapConfig config;
  config.voxel_m = 0.5;
  const auto voxels = [&](double x, double y, double z) {
    config.size_m = 0.5 * Vector3(x, y, z);
    return config.bytes() / 4.0;
  };
  EXPECT_EQ(voxels(4.0, 5.0, 8.0), 4.0 * 8.0 * 8.0);
  EXPECT_EQ(voxels(9.0, 1.0, 0.2), 16.0);
  EXPECT_EQ(voxels(2.0, 3.0, 1.0), 2.0 * 4.0);
  EXPECT_EQ(voxels(1e6, 1.0, 1.0), 4096.0) << "no axis is longer";
}

TEST(AirMap, ItsSettingsAreBounded) {
  AirMapConfig config;
  config.voxel_m = 0.5;
  const auto refuses = [&](double x, double y, double z) {
    config.size_m = 0.5 * Vector3(x, y, z);
    return ConfigChecks(config).refuses("size_m");
  };
  EXPECT_TRUE(ConfigChecks(AirMapConfig{}).refuses_nothing());
  EXPECT_FALSE(refuses(4096.0, 4096.0, 4.0));
  EXPECT_TRUE(refuses(4097.0, 1.0, 1.0));
  EXPECT_TRUE(refuses(1.0, 1.0, 4097.0));
  EXPECT_FALSE(refuses(1024.0, 1024.0, 512.0));
  EXPECT_TRUE(refuses(1024.0, 1024.0, 1024.0)) << "1.07e9 voxels";
}

}  // namespace
}  // namespace swiftlet
