// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/air_map.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/config_checks.hpp"

namespace swiftlet {
namespace {

using test::ConfigChecks;

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

TEST(AirMap, ItsSettingsAreBounded) {
  const auto refuses = [](const Vector3& size_m) {
    AirMapConfig config;
    config.voxel_m = 0.5;
    config.size_m = size_m;
    return ConfigChecks(config).refuses("size_m");
  };
  EXPECT_TRUE(ConfigChecks(AirMapConfig{}).problems().empty());
  EXPECT_TRUE(refuses({1e4, 1.0, 1.0}));
  EXPECT_TRUE(refuses({1.0, 1.0, 1e4}));
  EXPECT_TRUE(refuses({1e3, 1e3, 1e3})) << "too many voxels";
}

}  // namespace
}  // namespace swiftlet
