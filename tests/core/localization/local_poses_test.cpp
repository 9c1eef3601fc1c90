// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/local_poses.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace swiftlet {
namespace {

StateEstimate estimate_on_way(TimeNs t) {
  StateEstimate estimate;
  estimate.t = t;
  estimate.valid = true;
  const double s = to_seconds(t);
  estimate.T_local_body =
      make_pose({2.0 * s, 1.0, 0.0}, Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * s, Vector3::UnitZ())));
  return estimate;
}

double angle_of(const Pose& T) { return yaw_of(T.linear()); }

TEST(LocalPoses, InterpolatesLinearlyWithUniformRotation) {
  LocalPoses poses;
  for (TimeNs i = 1; i <= 20; ++i) poses.push(estimate_on_way(i * i * 10'000'000));
  for (TimeNs t = poses[0].t; t <= poses[poses.size() - 1].t; t += 7'000'000) {
    ASSERT_NEAR(poses.at(t).translation().x(), 2.0 * to_seconds(t), 1e-9);
    ASSERT_NEAR(angle_of(poses.at(t)), 0.5 * to_seconds(t), 1e-9);
  }
}

TEST(LocalPoses, ReturnsNearestPoseOutsideItsRange) {
  LocalPoses poses;
  for (const TimeNs t : {1'000'000'000LL, 2'000'000'000LL, 3'000'000'000LL}) poses.push(estimate_on_way(t));
  EXPECT_EQ(poses.at(0).matrix(), estimate_on_way(1'000'000'000).T_local_body.matrix());
  EXPECT_EQ(poses.at(9'000'000'000).matrix(), estimate_on_way(3'000'000'000).T_local_body.matrix());
  for (const TimeNs t : {1'000'000'000LL, 2'000'000'000LL, 3'000'000'000LL}) {
    EXPECT_LT((poses.at(t).matrix() - estimate_on_way(t).T_local_body.matrix()).norm(), 1e-12);
  }
}

TEST(LocalPoses, KeepsTheLast512InOrder) {
  LocalPoses poses;
  for (int i = 1; i <= 1300; ++i) {
    poses.push(estimate_on_way(i * 4'000'000LL));
    ASSERT_EQ(poses.size(), std::min(i, 512));
    ASSERT_EQ(poses[poses.size() - 1].t, i * 4'000'000LL);
  }
  for (int i = 1; i < poses.size(); ++i) ASSERT_EQ(poses[i].t - poses[i - 1].t, 4'000'000);
  EXPECT_NEAR(poses.at(4'000'000LL * 1000 + 1'000'000).translation().x(), 2.0 * 4.001, 1e-9);
}

TEST(LocalPoses, IgnoresInvalidAndOldEstimates) {
  LocalPoses poses;
  poses.push(estimate_on_way(2'000'000'000));
  StateEstimate bad = estimate_on_way(3'000'000'000);
  bad.valid = false;
  poses.push(bad);
  bad = estimate_on_way(3'000'000'000);
  bad.T_local_body.translation().x() = std::numeric_limits<double>::quiet_NaN();
  poses.push(bad);
  poses.push(estimate_on_way(2'000'000'000));
  poses.push(estimate_on_way(1'000'000'000));
  EXPECT_EQ(poses.size(), 1);
  poses.push(estimate_on_way(2'000'000'001));
  EXPECT_EQ(poses.size(), 2);
}

}  // namespace
}  // namespace swiftlet
