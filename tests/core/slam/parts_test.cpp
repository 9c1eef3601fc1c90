// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/slam/sweep.hpp"
#include "swiftlet/core/slam/symmetric_eigen.hpp"

namespace swiftlet {
namespace {

TEST(SymmetricEigen, ReconstructsMatrixWithAscendingEigenvalues) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 200; ++trial) {
    Matrix6 A;
    for (int i = 0; i < 36; ++i) A(i) = normal(random);
    A = (A * A.transpose()).eval();
    const SymmetricEigen<6> eigen = symmetric_eigen<6>(A);
    EXPECT_LT((eigen.vectors * eigen.values.asDiagonal() * eigen.vectors.transpose() - A).norm(), 1e-12 * A.norm());
    EXPECT_LT((eigen.vectors.transpose() * eigen.vectors - Matrix6::Identity()).norm(), 1e-13);
    for (int i = 1; i < 6; ++i) EXPECT_LE(eigen.values(i - 1), eigen.values(i));
  }
}

TEST(SymmetricEigen, IsExactForDiagonalMatrices) {
  const SymmetricEigen<3> eigen = symmetric_eigen<3>(Vector3(3.0, 1.0, 2.0).asDiagonal());
  EXPECT_EQ(eigen.values, Vector3(1.0, 2.0, 3.0));
  EXPECT_EQ(eigen.vectors.col(0).cwiseAbs(), Vector3(0.0, 1.0, 0.0));
  EXPECT_EQ(symmetric_eigen<3>(Matrix3::Zero()).values, Vector3::Zero());
}

TEST(RotationVector, InvertsItsRotation) {
  for (const double angle : {0.0, 1e-9, 1e-5, 0.1, 1.0, 3.0, 3.14}) {
    const Vector3 v = angle * Vector3(0.36, -0.48, 0.8);
    const Eigen::Quaterniond q = rotation_by(v);
    EXPECT_LT((rotation_vector_rad(q) - v).norm(), 1e-12);
    EXPECT_LT((rotation_vector_rad(Eigen::Quaterniond(-q.w(), -q.x(), -q.y(), -q.z())) - v).norm(), 1e-12);
  }
}

TEST(VoxelThinner, ReplacesThePreviousOutput) {
  const std::vector<Eigen::Vector3f> points{{0.1F, 0.1F, 0.1F}, {0.2F, 0.1F, 0.1F}, {1.5F, 0.1F, 0.1F}};
  std::vector<Eigen::Vector3f> kept(7, Eigen::Vector3f(9, 9, 9));
  VoxelThinner thinner;
  thinner.thin_into(points, 1.0F, kept);
  EXPECT_EQ(kept, (std::vector<Eigen::Vector3f>{points[0], points[2]}));
}

TEST(VoxelThinner, KeepsFirstPointPerCubeOrdered) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> uniform(-5.0F, 5.0F);
  std::vector<Eigen::Vector3f> points(5000);
  for (Eigen::Vector3f& p : points) p = {uniform(random), uniform(random), uniform(random)};
  VoxelThinner thinner;
  for (const float edge_m : {0.7F, 2.5F}) {  // twice with the same table
    std::vector<std::uint32_t> kept, expected;
    thinner.thin(points, edge_m, kept);
    std::vector<Eigen::Vector3i> seen;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3i cube = (points[i] / edge_m).array().floor().cast<int>();
      if (std::find(seen.begin(), seen.end(), cube) != seen.end()) continue;
      seen.push_back(cube);
      expected.push_back(i);
    }
    EXPECT_EQ(kept, expected);
  }
}

/// Four rows that fire one after another, in 50 columns over 0.1 s.
std::shared_ptr<const BeamTable> rolling_beams() {
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 4;
  beams->cols = 50;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 50; ++column) {
      const double azimuth = -0.5 + 0.02 * column, elevation = 0.1 * row;
      beams->directions_lidar.push_back(
          Vector3(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation))
              .cast<float>());
      beams->origins_lidar.push_back(Eigen::Vector3f::Zero());
    }
    beams->row_offset_s.push_back(0.0004F * static_cast<float>(row));
  }
  for (int column = 0; column < 50; ++column) beams->column_offset_s.push_back(0.002F * static_cast<float>(column));
  return beams;
}

TEST(Undistort, KeepsAWallFlatUnderMotion) {
  // 4 m/s and 3 rad/s: without the motion of each beam the wall would be off by 0.4 m and bent by 17 degrees.
  const Vector3 v_mps(4.0, 1.0, -0.5), omega_radps(0.3, -0.5, 3.0);
  const auto pose_at = [&](TimeNs t) {
    const double s = to_seconds(t);
    return make_pose(s * v_mps, rotation_by(s * omega_radps));
  };
  MotionHistory motion;
  for (TimeNs t = 0; t <= 120'000'000; t += 4'000'000) {
    const Pose T = pose_at(t);
    motion.push(t, T.translation(), Eigen::Quaterniond(T.linear()));
  }
  Scan scan;
  scan.stamp = 10'000'000;
  scan.duration = 100'000'000;
  scan.T_body_lidar = make_pose({0.1, 0.0, 0.2}, rotation_by({0.0, 0.3, 0.1}));
  scan.beams = rolling_beams();
  constexpr double kWall_m = 8.0;  // x = 8 m
  for (int i = 0; i < scan.size(); ++i) {
    const Pose T_local_lidar = pose_at(scan.time_of(i)) * scan.T_body_lidar;
    const Vector3 d = T_local_lidar.linear() * scan.beams->directions_lidar[i].cast<double>();
    const double range_m = (kWall_m - T_local_lidar.translation().x()) / d.x();
    scan.range_m.push_back(static_cast<float>(range_m));
  }
  scan.range_m[7] = 0.0F;  // no return
  std::vector<Eigen::Vector3f> points;
  const TimeNs t = 115'000'000;
  undistort(scan, motion, t, 0.3, 100.0, points);
  ASSERT_EQ(points.size(), 199U);
  for (const Eigen::Vector3f& p : points) {
    EXPECT_NEAR((pose_at(t) * p.cast<double>()).x(), kWall_m, 2e-4);
  }
  undistort(scan, motion, t, 0.3, 5.0, points);
  EXPECT_TRUE(points.empty()) << "nothing is nearer than 5 m";
}

TEST(MotionHistory, ShiftsThePastRigidlyUponCorrection) {
  MotionHistory motion;
  for (int i = 0; i <= 10; ++i) motion.push(i * 4'000'000, Vector3(0.1 * i, 0.0, 0.0), rotation_by({0, 0, 0.01 * i}));
  const Pose before = motion.at(6'000'000).inverse() * motion.at(35'000'000);
  motion.move(make_pose({5, 6, 7}, rotation_by({0.1, 0.2, 0.3})));
  const Pose after = motion.at(6'000'000).inverse() * motion.at(35'000'000);
  EXPECT_LT((before.matrix() - after.matrix()).norm(), 1e-12);
  EXPECT_GT(motion.at(0).translation().norm(), 5.0);
}

TEST(MotionHistory, AnswersKnownInstantsInAnyOrder) {
  constexpr TimeNs kTick = 4'000'000;
  constexpr int kPushed = 3000, kKept = 1024;
  const auto pose_at = [](TimeNs t) {
    return make_pose({2.0 * to_seconds(t), 1.0, 0.0}, rotation_by({0, 0, 0.1 * to_seconds(t)}));
  };
  const auto off_m = [&](const MotionHistory& motion, TimeNs t, TimeNs as_of) {
    return (motion.at(t).matrix() - pose_at(as_of).matrix()).norm();
  };
  MotionHistory motion;
  for (TimeNs i = 0; i < kPushed; ++i) {
    const Pose T = pose_at(i * kTick);
    motion.push(i * kTick, T.translation(), Eigen::Quaterniond(T.linear()));
    if (i % 7 == 0) motion.at(i * kTick);  // somewhere, while old ones are dropped
  }
  const TimeNs first = (kPushed - kKept) * kTick, last = (kPushed - 1) * kTick;
  for (const TimeNs t : {last, first, last - kTick / 3, first + kTick / 2, first + 100 * kTick, last - 5 * kTick}) {
    EXPECT_LT(off_m(motion, t, t), 1e-9) << t;
  }
  EXPECT_LT(off_m(motion, 0, first), 1e-9) << "before the first: the first";
  EXPECT_LT(off_m(motion, last + kTick, last), 1e-9) << "after the last: the last";
}

}  // namespace
}  // namespace swiftlet
