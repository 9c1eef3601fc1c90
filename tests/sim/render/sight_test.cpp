// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/sight.hpp"

#include <gtest/gtest.h>

#include "render_support.hpp"

namespace swiftlet::sim {
namespace {

TEST(Sight, IsBlockedByWallsNotLeaves) {
  BoxWorld world;
  world.add({4, -1, 0}, {5, 1, 2}, {0.5F, 0.5F, 0.5F}, SurfaceClass::kWall);
  world.add({-5, -1, 0}, {-4, 1, 2}, {0.1F, 0.5F, 0.1F}, SurfaceClass::kVegetation);
  world.add({-9, -1, 0}, {-8, 1, 2}, {0.4F, 0.3F, 0.1F}, SurfaceClass::kTrunk);
  const BlocksSight blocks = sight_in(std::make_shared<const StaticScene>(world.scene()));
  const Eigen::Vector3d middle(0, 0, 1);
  EXPECT_TRUE(blocks(middle, {7, 0, 1}));
  EXPECT_TRUE(blocks({7, 0, 1}, middle));
  EXPECT_FALSE(blocks(middle, {3.9, 0, 1})) << "in front of the wall";
  EXPECT_FALSE(blocks(middle, {7, 0, 6})) << "over it";
  EXPECT_FALSE(blocks(middle, {-7, 0, 1})) << "through leaves";
  EXPECT_TRUE(blocks(middle, {-10, 0, 1})) << "a trunk behind leaves";
  EXPECT_FALSE(blocks(middle, middle));
}

TEST(Sight, IsFreeWithoutAWorld) { EXPECT_FALSE(sight_in(nullptr)); }

}  // namespace
}  // namespace swiftlet::sim
