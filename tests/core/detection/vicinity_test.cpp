// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/vicinity.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

TEST(Vicinity, HoldsNearbyPointsAndNothingFar) {
  const Random random(3, "vicinity");
  const VoxelGrid box = VoxelGrid::covering({5.0, -3.0, 2.0}, {30.0, 20.0, 10.0}, 0.25);
  const Vector3 low = box.edge_m * box.min_cell.cast<double>(), size = box.edge_m * box.size.cast<double>();
  const auto point = [&](std::uint32_t i) -> Eigen::Vector3f {
    const Vector3 u(random.uniform(i, 0), random.uniform(i, 1), random.uniform(i, 2));
    return (low + u.cwiseProduct(size)).cast<float>();
  };
  Vicinity vicinity;
  for (const double distance_m : {0.1, 0.25, 0.7}) {  // below and above the edge of a voxel
    vicinity.begin(box, distance_m);
    std::vector<Eigen::Vector3f> points;
    for (std::uint32_t i = 0; i < 60; ++i) {
      points.push_back(point(i));
      vicinity.add(points.back());
    }
    int near = 0, held = 0;
    for (std::uint32_t i = 100; i < 20'000; ++i) {
      const Eigen::Vector3f p = i % 2 == 0 ? point(i) : (points[i % 60] + 0.05F * Eigen::Vector3f(i % 7, i % 5, i % 3));
      float nearest_m = 1e9F, nearest_by_axis_m = 1e9F;
      for (const Eigen::Vector3f& q : points) {
        nearest_m = std::min(nearest_m, (p - q).norm());
        nearest_by_axis_m = std::min(nearest_by_axis_m, (p - q).cwiseAbs().maxCoeff());
      }
      if (box.index_of(p.cast<double>()) < 0) continue;
      const bool inside = vicinity.contains(p);
      near += nearest_m <= distance_m;
      held += inside;
      ASSERT_TRUE(inside || nearest_m > distance_m) << nearest_m;
      ASSERT_TRUE(!inside || nearest_m < 4.0 * std::max(distance_m, 0.25)) << nearest_m;
      ASSERT_TRUE(!inside || nearest_by_axis_m < 2.01 * std::max(distance_m, 0.25)) << "two cells away";
    }
    EXPECT_GT(near, 100);
    EXPECT_LT(held, 19'000);
  }
  vicinity.begin(box, 0.25);
  EXPECT_FALSE(vicinity.contains(point(0)));
}

}  // namespace
}  // namespace swiftlet
