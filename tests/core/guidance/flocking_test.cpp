// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/flocking.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace swiftlet {
namespace {

TEST(Pacnav, RatesLinesOneAndLoopsZero) {
  EXPECT_NEAR(path_persistence(std::vector<Vector3>{{0, 0, 0}, {1, 0, 0}, {3, 0, 0}}), 1.0, 1e-12);
  EXPECT_NEAR(path_persistence(std::vector<Vector3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}}), 0.0,
              1e-12);
  EXPECT_EQ(path_persistence(std::vector<Vector3>{{1, 1, 1}, {1, 1, 1}}), 0.0);
}

VisualResponse seen(const std::vector<Vector3>& others_m) {
  MezeyConfig config;
  config.retina_pixels = 3600;
  std::vector<Neighbor> neighbors;
  for (const Vector3& other_m : others_m)
    neighbors.push_back({static_cast<std::int64_t>(neighbors.size()), other_m, Vector3::Zero(), 0});
  std::vector<char> retina;
  return visual_response(config, Vector3::Zero(), 0.0, neighbors, retina);
}

TEST(Mezey, RepelsNearAndAttractsFarNeighbors) {
  EXPECT_LT(seen({{1.0, 0, 0}}).acceleration_mps2, 0.0);   // ahead and near: slow down
  EXPECT_GT(seen({{20.0, 0, 0}}).acceleration_mps2, 0.0);  // ahead and far: catch up
  EXPECT_LT(seen({{0, 1.0, 0}}).turn_radps, 0.0);          // near on the left: turn right
  EXPECT_GT(seen({{0, 20.0, 0}}).turn_radps, 0.0);         // far on the left: turn left
}

TEST(Mezey, MirrorsTurnsAndIgnoresEmptyScenes) {
  const VisualResponse left = seen({{2.0, 1.0, 0}}), right = seen({{2.0, -1.0, 0}});
  EXPECT_NEAR(left.turn_radps, -right.turn_radps, 0.01);
  EXPECT_NEAR(left.acceleration_mps2, right.acceleration_mps2, 0.01);
  EXPECT_EQ(seen({}).turn_radps, 0.0);
  EXPECT_EQ(seen({}).acceleration_mps2, 0.0);
}

TEST(Mezey, RespondsByTheDiscIntegral) {
  // One disc ahead of half-angle a: -int cos = -2 sin a, edges: 2 alpha1 cos a.
  const double a = std::asin(0.5 / 3.0);
  EXPECT_NEAR(seen({{3.0, 0, 0}}).acceleration_mps2, -2.0 * std::sin(a) + 2.0 * 0.12 * std::cos(a), 0.01);
}

}  // namespace
}  // namespace swiftlet
