// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/localization/local_cloud.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace swiftlet {
namespace {

constexpr TimeNs kMs = 1'000'000;

Pose motion_at(double t_s) {
  return make_pose({8.0 * t_s, -2.0 * t_s, 3.0}, Eigen::Quaterniond(Eigen::AngleAxisd(1.5 * t_s, Vector3::UnitZ())));
}

/// Measurements of one world point by a spinning LiDAR on a moving body.
std::shared_ptr<Scan> scan_of(const Vector3& target_world_m, TimeNs stamp, TimeNs duration, int cols) {
  auto beams = std::make_shared<BeamTable>();
  auto scan = std::make_shared<Scan>();
  scan->stamp = stamp;
  scan->duration = duration;
  scan->T_body_lidar = make_pose({0.1, 0.0, 0.2}, Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3::UnitX())));
  beams->rows = 1;
  beams->cols = cols;
  for (int c = 0; c < cols; ++c) {
    beams->column_offset_s.push_back(static_cast<float>(to_seconds(duration) * c / cols));
    const double t = to_seconds(stamp) + (duration ? static_cast<double>(beams->column_offset_s[c]) : 0.0);
    const Vector3 p_lidar = (motion_at(t) * scan->T_body_lidar).inverse() * target_world_m;
    beams->directions_lidar.push_back(p_lidar.normalized().cast<float>());
    beams->origins_lidar.emplace_back(0, 0, 0);
    scan->range_m.push_back(static_cast<float>(p_lidar.norm()));
  }
  scan->beams = beams;
  return scan;
}

StateEstimate estimate_at(TimeNs t) {
  StateEstimate estimate;
  estimate.t = t;
  estimate.valid = true;
  estimate.T_local_body = motion_at(to_seconds(t));
  return estimate;
}

TEST(LocalCloud, RemovesMotionDuringTheSweep) {
  const Vector3 target(12.0, 5.0, 4.0);
  CloudRegistrar registrar(0.4);
  LocalCloud cloud;
  const auto scan = scan_of(target, 900 * kMs, 100 * kMs, 512);
  EXPECT_FALSE(registrar.make(scan, cloud)) << "no pose is known yet";
  for (TimeNs t = 0; t <= 1000 * kMs; t += 4 * kMs) registrar.push(estimate_at(t));
  ASSERT_TRUE(registrar.make(scan, cloud));
  ASSERT_EQ(cloud.size(), 512U);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_LT((cloud.points_local_m[i].cast<double>() - target).norm(), 1e-3) << i;
    EXPECT_NEAR(to_seconds(cloud.time_of(i)), 0.9 + 0.1 * static_cast<double>(i) / 512, 1e-7);
  }
}

TEST(LocalCloud, PlacesFrozenScanByStampedPose) {
  const Vector3 target(12.0, 5.0, 4.0);
  CloudRegistrar registrar(0.4);
  for (TimeNs t = 0; t <= 1000 * kMs; t += 4 * kMs) registrar.push(estimate_at(t));
  LocalCloud cloud;
  ASSERT_TRUE(registrar.make(scan_of(target, 902 * kMs, 0, 16), cloud));
  for (const Eigen::Vector3f& p : cloud.points_local_m) EXPECT_LT((p.cast<double>() - target).norm(), 1e-4);
}

TEST(LocalCloud, PlacesScansByTheirAttachedPoses) {
  const Vector3 shift(0.3, -0.2, 0.1);
  CloudRegistrar registrar(0.4);
  for (TimeNs t = 0; t <= 1000 * kMs; t += 4 * kMs) registrar.push(estimate_at(t));
  auto scan = scan_of({12.0, 5.0, 4.0}, 900 * kMs, 0, 4);
  Pose attached = motion_at(0.9);
  attached.translation() += shift;
  scan->external_poses = {{900 * kMs, attached}};
  LocalCloud cloud;
  ASSERT_TRUE(registrar.make(scan, cloud));
  for (const Eigen::Vector3f& p : cloud.points_local_m)
    EXPECT_LT((p.cast<double>() - shift - Vector3(12.0, 5.0, 4.0)).norm(), 1e-4);
}

TEST(LocalCloud, ExcludesEmptyMaskedAndOwnReturns) {
  CloudRegistrar registrar(0.4);
  registrar.push(estimate_at(0));
  auto scan = scan_of({5.0, 1.0, 3.0}, 0, 0, 6);
  auto beams = std::make_shared<BeamTable>(*scan->beams);
  beams->masked.assign(6, 0);
  beams->masked[1] = 1;
  scan->beams = beams;
  scan->range_m[2] = 0.0F;
  scan->range_m[3] = 0.1F;  // a rotor
  scan->range_m[4] = std::numeric_limits<float>::infinity();
  LocalCloud cloud;
  ASSERT_TRUE(registrar.make(scan, cloud));
  EXPECT_EQ(cloud.beam, (std::vector<std::uint32_t>{0, 5}));
}

TEST(LocalCloud, HoldsEachReturnOnceByRow) {
  CloudRegistrar registrar(0.4);
  for (TimeNs t = 0; t <= 1000 * kMs; t += 4 * kMs) registrar.push(estimate_at(t));
  auto scan = scan_of({12.0, 5.0, 4.0}, 900 * kMs, 0, 8);
  auto beams = std::make_shared<BeamTable>(*scan->beams);
  beams->rows = 2;
  for (int column = 0; column < 8; ++column) {
    beams->directions_lidar.push_back(beams->directions_lidar[column]);
    beams->origins_lidar.push_back(beams->origins_lidar[column]);
    scan->range_m.push_back(2.0F * scan->range_m[column]);
  }
  scan->beams = beams;
  LocalCloud cloud;
  ASSERT_TRUE(registrar.make(scan, cloud));
  ASSERT_EQ(cloud.size(), 16U);
  for (std::uint32_t i = 0; i < 16; ++i) EXPECT_EQ(cloud.beam[i], i);
}

}  // namespace
}  // namespace swiftlet
