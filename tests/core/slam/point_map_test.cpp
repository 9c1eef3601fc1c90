// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/point_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <span>
#include <vector>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "tests/core/slam/synthetic_room.hpp"

namespace swiftlet {
namespace {

using testing::SyntheticRoom;

/// Points on the walls of a room, as seen from a pose, in body axes.
std::vector<Eigen::Vector3f> scan_of(const SyntheticRoom& room, const Pose& T_world_body, unsigned seed, int num) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::vector<Eigen::Vector3f> points_body_m;
  for (int i = 0; i < num; ++i) {
    const Vector3 d_body = Vector3(normal(random), normal(random), normal(random)).normalized();
    const double range_m = room.range_m(T_world_body.translation(), T_world_body.linear() * d_body);
    points_body_m.emplace_back(((range_m + 0.02 * normal(random)) * d_body).cast<float>());
  }
  return points_body_m;
}

PointMap map_of(std::span<const Eigen::Vector3f> points_m) {
  std::vector<Vector3> points;
  for (const Eigen::Vector3f& p : points_m) points.push_back(p.cast<double>());
  PointMap map;
  map.insert(points);
  return map;
}

TEST(PointMap, FindsNearestOfSparsePoints) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-6.0, 6.0);
  std::vector<Vector3> points;
  for (int i = 0; i < 1500; ++i) points.emplace_back(uniform(random), uniform(random), uniform(random));
  PointMap map;
  for (const Vector3& p : points) {
    if (map.nearest(p, 0.3) == nullptr) map.insert({&p, 1});  // farther apart than any thinning of the map
  }
  std::erase_if(points, [&](const Vector3& p) { return map.nearest(p, 1e-3) == nullptr; });
  ASSERT_GT(points.size(), 500U);
  for (int i = 0; i < 300; ++i) {
    const Vector3 at(uniform(random), uniform(random), uniform(random));
    const auto nearest = std::ranges::min_element(points, {}, [&](const Vector3& p) { return (p - at).norm(); });
    const Eigen::Vector3f* found = map.nearest(at, 1.0);
    if ((*nearest - at).norm() >= 1.0) {
      EXPECT_EQ(found, nullptr);
    } else {
      ASSERT_NE(found, nullptr);
      EXPECT_LT((found->cast<double>() - *nearest).norm(), 1e-4);
    }
  }
}

TEST(PointMap, ForgetsDistantPoints) {
  const std::vector<Vector3> points = {{0, 0, 0}, {20, 0, 0}};
  PointMap map;
  map.insert(points);
  map.keep_around({19, 0, 0}, 5.0);
  EXPECT_EQ(map.nearest(points[0], 1.0), nullptr);
  EXPECT_NE(map.nearest(points[1], 1.0), nullptr);
}

TEST(AlignPoints, RecoversLargeDisplacements) {
  const SyntheticRoom room = SyntheticRoom::box({-5.3, -4.1, -0.2}, {6.4, 5.2, 3.7});
  const PointMap map = map_of(scan_of(room, Pose::Identity(), 1, 8000));
  for (const double turned_rad : {-0.35, -0.1, 0.2}) {
    const Pose T_local_body =
        make_pose({0.6, -0.4, 0.3}, rotation_by(turned_rad * Vector3(1.0, -2.0, 3.0).normalized()));
    const auto aligned = align_points(map, scan_of(room, T_local_body, 2, 800), Pose::Identity(), 1.0);
    ASSERT_TRUE(aligned);
    const Pose error = T_local_body.inverse() * *aligned;
    EXPECT_LT(error.translation().norm(), 0.1) << turned_rad;
    EXPECT_LT(rotation_vector_rad(Eigen::Quaterniond(error.linear())).norm(), 0.02) << turned_rad;
  }
}

TEST(AlignPoints, RefusesScansBesideTheMap) {
  const SyntheticRoom room = SyntheticRoom::box({-5.3, -4.1, -0.2}, {6.4, 5.2, 3.7});
  const std::vector<Eigen::Vector3f> scan = scan_of(room, Pose::Identity(), 1, 800);
  EXPECT_FALSE(align_points(map_of(scan), scan, make_pose({200, 0, 0}, Eigen::Quaterniond::Identity()), 1.0));
  EXPECT_FALSE(align_points({}, scan, Pose::Identity(), 1.0));
}

}  // namespace
}  // namespace swiftlet
