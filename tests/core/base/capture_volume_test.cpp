// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/base/capture_volume.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace swiftlet {
namespace {

TEST(CaptureVolume, IsMetWherePathCrossesDisc) {
  const CaptureVolume net;  // radius 2 m
  EXPECT_NEAR(net.met_m({1.0, 0.0, 0.5}, {2.0, 0.0, -0.5}).value_or(-1.0), 1.5, 1e-12);
  EXPECT_FALSE(net.met_m({1.0, 0.0, 0.5}, {1.0, 0.0, 0.1})) << "the path ends above the disc";
  EXPECT_FALSE(net.met_m({2.0, 0.0, 0.5}, {3.0, 0.0, -0.5}))
      << "the path crosses the plane of the disc outside its rim";
  EXPECT_TRUE(net.met_m({0.0, 0.0, 100.0}, {0.0, 0.0, -100.0})) << "a fast target between two ticks";
}

TEST(CaptureVolume, HangsBelowVehicleAndFollowsHeading) {
  CaptureVolume net;
  net.offset_m = {1.0, 0.0, -2.0};
  EXPECT_LT((net.center({5, 5, 5}, 0.5 * std::numbers::pi) - Vector3(5, 6, 3)).norm(), 1e-9);
  // A quarter of a turn would hide what the cosine does. With 3-4-5 the sums are whole.
  net.offset_m = {5.0, 10.0, -2.0};
  EXPECT_LT((net.center({0, 0, 5}, std::atan2(3.0, 4.0)) - Vector3(4 - 6, 3 + 8, 3)).norm(), 1e-9);
}

// Compared with ten thousand positions along each path.
TEST(CaptureVolume, IsMetWherePathLiesInside) {
  int met = 0, missed = 0;
  for (std::uint32_t round = 0; round < 400; ++round) {
    std::minstd_rand random(round + 1);
    const auto draw = [&](double min, double max) {
      return min + (max - min) * static_cast<double>(random()) / std::minstd_rand::max();
    };
    const auto place = [&] {
      const double x = draw(-3.0, 3.0), y = draw(-3.0, 3.0);
      return Vector3(x, y, draw(-2.0, 2.0));
    };
    CaptureVolume net;
    net.radius_m = draw(1.0, 2.0);
    net.height_m = draw(0.4, 2.4);
    const Vector3 from_m = place();
    Vector3 to_m = place();
    if (round % 5 == 0) to_m.z() = from_m.z();
    if (round % 7 == 0) to_m.head<2>() = from_m.head<2>();
    double least_m = 1e9;
    for (int i = 0; i <= 10000; ++i) {
      const Vector3 at_m = from_m + i / 10000.0 * (to_m - from_m);
      if (std::abs(at_m.z()) <= 0.5 * net.height_m) least_m = std::min(least_m, at_m.head<2>().norm());
    }
    if (std::abs(least_m - net.radius_m) < 1e-3) continue;
    const auto got = net.met_m(from_m, to_m);
    ASSERT_EQ(got.has_value(), least_m <= net.radius_m) << round;
    if (got) {
      ASSERT_NEAR(*got, least_m, 1e-3) << round;
    }
    ++(got ? met : missed);
  }
  EXPECT_GT(met, 60);
  EXPECT_GT(missed, 100);
}

TEST(CaptureVolume, ItsRimsCount) {
  CaptureVolume net;
  net.height_m = 1.0;
  for (const double z_m : {-0.5, 0.5}) EXPECT_TRUE(net.met_m({-5.0, 0.0, z_m}, {5.0, 0.0, z_m})) << z_m;
  EXPECT_TRUE(net.met_m({-5.0, 2.0, 0.0}, {5.0, 2.0, 0.0}));
  EXPECT_TRUE(net.met_m({0.0, 0.0, 2.0}, {0.0, 0.0, 0.5})) << "the path ends at the upper rim";
  net.height_m = 0.0;
  EXPECT_TRUE(net.met_m({1.0, 0.0, 1.0}, {1.0, 0.0, 0.0})) << "the path ends on the disc";
  EXPECT_TRUE(net.met_m({-3.0, 0.0, 0.0}, {3.0, 0.0, 0.0})) << "the path lies in the plane of the disc";
}

}  // namespace
}  // namespace swiftlet
