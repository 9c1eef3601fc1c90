// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/pcl/registration.hpp"

#include <gtest/gtest.h>

#include "swiftlet/core/pcl/filters.hpp"
#include "tests/core/pcl/scans.hpp"

namespace swiftlet {
namespace {

/// Two simulated scans of a hall, half a meter and five degrees apart.
struct Pair {
  Pair() {
    const testing::HallScan a = testing::scan_hall({2.0, 1.0, 2.0}, 20.0);
    const testing::HallScan b = testing::scan_hall({2.4, 1.3, 2.1}, 25.0);
    target_m = pcl_voxel_grid(a.points_lidar_m, 0.2);
    source_m = pcl_voxel_grid(b.points_lidar_m, 0.2);
    T_target_source = a.T_world_lidar.inverse() * b.T_world_lidar;
  }
  std::vector<Eigen::Vector3f> source_m, target_m;
  Pose T_target_source;
};

const Pair& pair() {
  static const Pair scans;
  return scans;
}

void expect_near(const PclRegistration& found, double error_m, double error_deg) {
  EXPECT_TRUE(found.converged);
  const Pose off = pair().T_target_source.inverse() * found.T_target_source;
  EXPECT_LT(off.translation().norm(), error_m);
  EXPECT_LT(Eigen::AngleAxisd(off.linear()).angle(), error_deg * kRadPerDeg);
  EXPECT_GT(found.fitness_m2, 0.0);
  EXPECT_LT(found.fitness_m2, 0.3) << "what only one of the scans saw has its nearest point far away";
  EXPECT_TRUE(found.T_target_source.linear().isUnitary(1e-9));
}

TEST(PclGicp, FindsMotionBetweenSimulatedScans) {
  expect_near(pcl_gicp(pair().source_m, pair().target_m, Pose::Identity()), 0.03, 0.3);
}

TEST(PclNdt, FindsMotionFromNearbyGuess) {
  Pose guess = pair().T_target_source;
  guess.translation() += Vector3(0.15, -0.1, 0.05);
  expect_near(pcl_ndt(pair().source_m, pair().target_m, guess), 0.08, 0.8);
}

TEST(PclRegistration, ReturnsUnconvergedGuessForFewPoints) {
  const std::vector<Eigen::Vector3f> few(3, Eigen::Vector3f::Ones());
  const Pose guess = make_pose({1.0, 2.0, 3.0}, Eigen::Quaterniond::Identity());
  for (const PclRegistration& found :
       {pcl_gicp(few, pair().target_m, guess), pcl_gicp(pair().source_m, few, guess), pcl_ndt({}, {}, guess)}) {
    EXPECT_FALSE(found.converged);
    EXPECT_TRUE(found.T_target_source.isApprox(guess));
  }
}

TEST(PclRegistration, IgnoresNonFinitePoints) {
  std::vector<Eigen::Vector3f> source_m = pair().source_m;
  source_m.insert(source_m.begin(), 50, Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  expect_near(pcl_gicp(source_m, pair().target_m, Pose::Identity()), 0.03, 0.3);
}

}  // namespace
}  // namespace swiftlet
