// SPDX-License-Identifier: BSD-3-Clause
#include "core/tracking/cloud_buffer.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

/// Random points, some with a coordinate that is NaN.
LocalCloud scattered(std::uint32_t num_points, TimeNs stamp) {
  const Random random(9, "test.buffer");
  auto scan = std::make_shared<Scan>();
  scan->stamp = stamp;
  LocalCloud cloud;
  for (std::uint32_t i = 0; i < num_points; ++i) {
    Eigen::Vector3f p;
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      p[static_cast<int>(axis)] = static_cast<float>(random.uniform(-10.0, 10.0, i, axis));
    if (i % 17 == 3) p.y() = std::numeric_limits<float>::quiet_NaN();
    cloud.points_local_m.push_back(p);
    cloud.beam.push_back(i);
    scan->reflectivity.push_back(0.001F * static_cast<float>(i));
  }
  cloud.scan = scan;
  return cloud;
}

TEST(BufferedCloud, MatchesBruteForceSelection) {
  for (const std::uint32_t num_points : {0U, 1U, 63U, 64U, 65U, 500U}) {
    const LocalCloud cloud = scattered(num_points, 0);
    BufferedCloud buffered;
    buffered.assign(cloud);
    for (const double radius_m : {0.5, 3.0, 9.0, 40.0}) {
      for (const Vector3& center_m : {Vector3(0, 0, 0), Vector3(9, -9, 4), Vector3(-14, 0, 2)}) {
        std::vector<float> expected;
        for (std::uint32_t i = 0; i < num_points; ++i) {
          if ((cloud.points_local_m[i].cast<double>() - center_m).norm() <= radius_m)
            expected.push_back(cloud.reflectivity_of(i));
        }
        std::vector<std::uint32_t> indices;
        buffered.select(center_m, radius_m, indices);
        EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
        std::vector<float> found;
        for (const std::uint32_t i : indices) {
          EXPECT_LE((buffered.point(i).cast<double>() - center_m).norm(), radius_m + 1e-5);
          found.push_back(buffered.reflectivity(i));
        }
        EXPECT_EQ(found, expected) << num_points << ' ' << radius_m;
      }
    }
  }
}

TEST(BufferedCloud, SelectAppends) {
  BufferedCloud buffered;
  buffered.assign(scattered(10, 0));
  std::vector<std::uint32_t> indices = {77};
  buffered.select({0, 0, 0}, 100.0, indices);
  EXPECT_EQ(indices.front(), 77U);
  EXPECT_EQ(indices.size(), 1U + 9U) << "all but the one that is not finite";
}

TEST(BufferedCloud, RefersToMiddleOfSweep) {
  LocalCloud cloud = scattered(3, 1'000);
  auto scan = std::make_shared<Scan>(*cloud.scan);
  scan->duration = 100;
  cloud.scan = scan;
  for (int i = 0; i < 5; ++i) cloud.T_local_lidar.push_back(make_pose({1.0 * i, 0, 0}, Eigen::Quaterniond::Identity()));
  BufferedCloud buffered;
  buffered.assign(cloud);
  EXPECT_EQ(buffered.middle(), 1'050);
  EXPECT_EQ(buffered.T_local_lidar().translation().x(), 2.0);
}

TEST(CloudBuffer, KeepsTheLastCloudsOldestFirst) {
  CloudBuffer buffer(3);
  for (TimeNs t = 1; t <= 8; ++t) {
    buffer.push().assign(scattered(2, t));
    const auto kept = static_cast<std::size_t>(std::min<TimeNs>(t, 3));
    ASSERT_EQ(buffer.size(), kept);
    EXPECT_EQ(buffer.is_full(), t >= 3);
    EXPECT_EQ(buffer.newest().stamp(), t);
    for (std::size_t i = 0; i < kept; ++i) EXPECT_EQ(buffer[i].stamp(), t - static_cast<TimeNs>(kept - 1 - i));
  }
}

}  // namespace
}  // namespace swiftlet
