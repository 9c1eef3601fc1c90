// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/sweep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "swiftlet/core/localization/rotation.hpp"

namespace swiftlet {
namespace {

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
    const Eigen::Quaterniond q(T.linear());
    motion.push(i * kTick, T.translation(), i % 3 == 0 ? q : Eigen::Quaterniond(-q.coeffs()));  // equal attitudes
    if (i % 7 == 0) motion.at(i * kTick);
  }
  const TimeNs first = (kPushed - kKept) * kTick, last = (kPushed - 1) * kTick;
  for (const TimeNs t : {last, first, last - kTick / 3, first + kTick / 2, first + 100 * kTick, last - 5 * kTick}) {
    EXPECT_LT(off_m(motion, t, t), 1e-9) << t;
  }
  EXPECT_LT(off_m(motion, 0, first), 1e-9) << "before the first: the first";
  EXPECT_LT(off_m(motion, last + kTick, last), 1e-9) << "after the last: the last";
}

TEST(MotionHistory, BendsBetweenSamplesFarApart) {
  constexpr TimeNs kTick = 20'000'000;
  const auto pose_at = [](TimeNs t) {  // accelerates by 10 m/s^2 and 40 rad/s^2
    const double half_square = 0.5 * to_seconds(t) * to_seconds(t);
    return make_pose({10.0 * half_square, 0.0, 1.0}, rotation_by({0.0, 40.0 * half_square, 0.0}));
  };
  MotionHistory motion;
  for (TimeNs i = 0; i <= 5; ++i)
    motion.push(i * kTick, pose_at(i * kTick).translation(), Eigen::Quaterniond(pose_at(i * kTick).linear()));
  for (TimeNs t = 0; t <= 5 * kTick; t += kTick / 4) {
    EXPECT_LT((motion.at(t).translation() - pose_at(t).translation()).norm(), 1e-9) << t;
    EXPECT_LT((motion.at(t).linear() - pose_at(t).linear()).norm(), 1e-4) << t;
  }
}

TEST(MotionHistory, CoversItsIntervalAndRejectsOlder) {
  MotionHistory history;
  EXPECT_TRUE(history.empty());
  EXPECT_FALSE(history.covers(5));
  history.push(5, {1, 0, 0}, Eigen::Quaterniond::Identity());
  EXPECT_FALSE(history.empty());
  EXPECT_TRUE(history.covers(5));
  EXPECT_FALSE(history.covers(4));
  history.push(5, {2, 0, 0}, Eigen::Quaterniond::Identity());
  history.push(4, {3, 0, 0}, Eigen::Quaterniond::Identity());
  EXPECT_EQ(history.at(5).translation().x(), 1.0);
  EXPECT_EQ(history.at(9).translation().x(), 1.0);
  history.push(6, {4, 0, 0}, Eigen::Quaterniond::Identity());
  EXPECT_EQ(history.at(9).translation().x(), 4.0);
}

TEST(MotionHistory, CorrectionsMoveEveryInstant) {
  MotionHistory motion;
  for (int i = 0; i <= 10; ++i) motion.push(i * 4'000'000, Vector3(0.1 * i, 0.0, 0.0), rotation_by({0, 0, 0.01 * i}));
  const TimeNs now = 40'000'000;
  MotionHistory moved = motion, faster = motion;
  const Pose T = make_pose({5, 6, 7}, rotation_by({0.1, 0.2, 0.3}));
  const Vector3 by_mps(0.5, -0.2, 0.1);
  moved.move(T);
  faster.change_velocity(now, by_mps);
  for (const TimeNs t : {TimeNs{0}, TimeNs{6'000'000}, TimeNs{35'000'000}, now}) {
    EXPECT_LT((moved.at(t).matrix() - (T * motion.at(t)).matrix()).norm(), 1e-9) << t;
    const Vector3 off_m = faster.at(t).translation() - motion.at(t).translation();
    EXPECT_LT((off_m - to_seconds(t - now) * by_mps).norm(), 1e-9) << t;
    EXPECT_EQ(faster.at(t).linear(), motion.at(t).linear());
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
      beams->origins_lidar.emplace_back(0.02F, -0.03F, 0.01F * static_cast<float>(row));
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
    const double range_m = (kWall_m - (T_local_lidar * scan.beams->origins_lidar[i].cast<double>()).x()) / d.x();
    scan.range_m.push_back(static_cast<float>(range_m));
  }
  scan.range_m[7] = 0.0F;  // no return
  auto masked = std::make_shared<BeamTable>(*scan.beams);
  masked->masked.assign(masked->directions_lidar.size(), 0);
  masked->masked[11] = 1;
  scan.beams = masked;
  std::vector<Eigen::Vector3f> points;
  const TimeNs t = 115'000'000;
  undistort(scan, motion, t, 0.3, 100.0, points);
  ASSERT_EQ(points.size(), 198U);
  for (const Eigen::Vector3f& p : points) {
    EXPECT_NEAR((pose_at(t) * p.cast<double>()).x(), kWall_m, 2e-4);
  }
  undistort(scan, motion, t, 0.3, 5.0, points);
  EXPECT_TRUE(points.empty()) << "nothing is nearer than 5 m";
}

TEST(Undistort, IncludesPointsAtBothRadii) {
  MotionHistory still;
  still.push(0, Vector3::Zero(), Eigen::Quaterniond::Identity());
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 1;
  Scan scan;
  scan.range_m = {0.499F, 0.5F, 5.0F, 5.001F, std::numeric_limits<float>::infinity()};
  beams->cols = 5;
  beams->directions_lidar.assign(5, Eigen::Vector3f::UnitX());
  beams->origins_lidar.assign(5, Eigen::Vector3f::Zero());
  beams->column_offset_s.assign(5, 0.0F);
  scan.beams = beams;
  std::vector<Eigen::Vector3f> points = {{9, 9, 9}};
  undistort(scan, still, 0, 0.5, 5.0, points);
  ASSERT_EQ(points.size(), 2U) << "what was in it is replaced";
  EXPECT_EQ(points[0].x(), 0.5F);
  EXPECT_EQ(points[1].x(), 5.0F);
}

TEST(VoxelThinner, ReplacesThePreviousOutput) {
  const std::vector<Eigen::Vector3f> points{{0.1F, 0.1F, 0.1F}, {0.2F, 0.1F, 0.1F}, {1.5F, 0.1F, 0.1F}};
  std::vector<Eigen::Vector3f> kept(7, Eigen::Vector3f(9, 9, 9));
  VoxelThinner thinner;
  thinner.thin_into(points, 1.0F, kept);
  EXPECT_EQ(kept, (std::vector<Eigen::Vector3f>{points[0], points[2]}));
}

TEST(VoxelThinner, KeepsFirstPointPerCube) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  for (const float half_m : {0.5F, 50.0F, 3000.0F}) {
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 400; ++i) {
      const float a = uniform(random), b = uniform(random), c = uniform(random);
      points.emplace_back(half_m * Eigen::Vector3f(a, b, c));
      points.emplace_back(points.back() + Eigen::Vector3f::Constant(0.05F));
    }
    std::vector<std::uint32_t> kept = {77}, expected = {77};
    VoxelThinner().thin(points, 0.25F, kept);
    std::vector<Eigen::Vector3f> cubes;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3f cube = (points[i] * 4.0F).array().floor();
      if (std::find(cubes.begin(), cubes.end(), cube) != cubes.end()) continue;
      cubes.push_back(cube);
      expected.push_back(i);
    }
    EXPECT_EQ(kept, expected) << half_m;
  }
}

}  // namespace
}  // namespace swiftlet
