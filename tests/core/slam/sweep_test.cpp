// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/slam/sweep.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "swiftlet/core/localization/rotation.hpp"

namespace swiftlet {
namespace {

constexpr TimeNs kSweepMs = 1'000'000;

/// A body with poses at irregular times.
struct ToldMotion {
  std::vector<TimeNs> times;
  std::vector<Vector3> places_m;
  std::vector<Eigen::Quaterniond> attitudes;
  MotionHistory history;

  explicit ToldMotion(unsigned seed, int num = 30) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    TimeNs t = 50 * kSweepMs;
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    Vector3 p_m = Vector3::Zero();
    for (int i = 0; i < num; ++i) {
      const double a = uniform(random), b = uniform(random), c = uniform(random), d = uniform(random);
      p_m += 0.05 * Vector3(a, b, c);
      q = q * rotation_by(0.02 * Vector3(b, c, d));
      times.push_back(t);
      places_m.push_back(p_m);
      // q or -q: equal attitudes
      attitudes.push_back(i % 3 == 0 ? q : Eigen::Quaterniond(-q.w(), -q.x(), -q.y(), -q.z()));
      history.push(t, p_m, attitudes.back());
      t += (2 + static_cast<TimeNs>(3.0 * (1.0 + d))) * kSweepMs;
    }
  }
  Pose at(TimeNs t) const {
    if (t <= times.front()) return make_pose(places_m.front(), attitudes.front());
    if (t >= times.back()) return make_pose(places_m.back(), attitudes.back());
    std::size_t i = 0;
    while (times[i + 1] <= t) ++i;
    const double f = static_cast<double>(t - times[i]) / static_cast<double>(times[i + 1] - times[i]);
    return make_pose(places_m[i] * (1.0 - f) + places_m[i + 1] * f, attitudes[i].slerp(f, attitudes[i + 1]));
  }
};

double apart(const Pose& a, const Pose& b) { return (a.matrix() - b.matrix()).norm(); }

TEST(MotionHistory, InterpolatesLinearlyForEitherQuaternionSign) {
  const ToldMotion motion(1);
  std::mt19937 random(2);
  for (int i = 0; i < 400; ++i) {
    const TimeNs t = static_cast<TimeNs>(random() % 300) * kSweepMs + static_cast<TimeNs>(random() % kSweepMs);
    EXPECT_LT(apart(motion.history.at(t), motion.at(t)), 1e-6) << t;
  }
  for (std::size_t i = 0; i < motion.times.size(); ++i) {
    EXPECT_LT(apart(motion.history.at(motion.times[i]), make_pose(motion.places_m[i], motion.attitudes[i])), 1e-12);
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

TEST(MotionHistory, VelocityChangeShiftsThePastLinearly) {
  ToldMotion motion(3);
  MotionHistory changed = motion.history;
  const Vector3 by_mps(0.5, -0.2, 0.1);
  const TimeNs now = motion.times.back();
  changed.change_velocity(now, by_mps);
  for (std::size_t i = 0; i < motion.times.size(); ++i) {
    const Vector3 moved_m = changed.at(motion.times[i]).translation() - motion.places_m[i];
    EXPECT_LT((moved_m - to_seconds(motion.times[i] - now) * by_mps).norm(), 1e-12);
  }
  EXPECT_LT((changed.at(motion.times[0]).linear() - motion.history.at(motion.times[0]).linear()).norm(), 1e-15);
}

TEST(MotionHistory, ACorrectionMovesEveryInstant) {
  ToldMotion motion(4);
  MotionHistory moved_history = motion.history;
  const Pose T = make_pose({5, 6, 7}, rotation_by({0.1, 0.2, 0.3}));
  moved_history.move(T);
  for (const TimeNs t : motion.times) EXPECT_LT(apart(moved_history.at(t), T * motion.at(t)), 1e-12);
}

/// Random beams from random origins; some see nothing, some are masked.
std::shared_ptr<Scan> random_sweep(unsigned seed, bool rows_in_turn, TimeNs duration) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  const auto draw = [&] {
    const float a = uniform(random), b = uniform(random), c = uniform(random);
    return Eigen::Vector3f(a, b, c);
  };
  auto beams = std::make_shared<BeamTable>();
  beams->rows = 3;
  beams->cols = 40;
  auto scan = std::make_shared<Scan>();
  for (int i = 0; i < beams->rows * beams->cols; ++i) {
    beams->directions_lidar.push_back(draw().normalized());
    beams->origins_lidar.push_back(0.05F * draw());
    beams->masked.push_back(i % 17 == 0 ? 1 : 0);
    scan->range_m.push_back(i % 11 == 0 ? 0.0F : 4.0F + 3.9F * uniform(random));
  }
  for (int column = 0; column < beams->cols; ++column) {
    beams->column_offset_s.push_back(static_cast<float>(to_seconds(duration)) * static_cast<float>(column) / 40.0F);
  }
  if (rows_in_turn) beams->row_offset_s = {0.0F, 0.004F, 0.011F};
  scan->sensor = "lidar";
  scan->stamp = 60 * kSweepMs;
  scan->duration = duration;
  scan->T_body_lidar = make_pose({0.1, -0.05, 0.2}, rotation_by({0.1, 0.4, -0.2}));
  scan->beams = beams;
  return scan;
}

TEST(Undistort, CarriesBeamsFromTheirFiringTime) {
  const ToldMotion motion(5, 60);
  for (const bool rows_in_turn : {false, true}) {
    for (const TimeNs duration : {TimeNs{0}, 100 * kSweepMs}) {
      auto scan = random_sweep(6, rows_in_turn, duration);
      if (rows_in_turn && duration != 0) {
        auto unmasked = std::make_shared<BeamTable>(*scan->beams);
        unmasked->masked.clear();
        scan->beams = unmasked;
      }
      const TimeNs now = 170 * kSweepMs;
      constexpr double kOwn_m = 1.5, kFar_m = 6.0;
      std::vector<Eigen::Vector3f> points, expected;
      undistort(*scan, motion.history, now, kOwn_m, kFar_m, points);
      const BeamTable& beams = *scan->beams;
      for (int column = 0; column < beams.cols; ++column) {
        for (int row = 0; row < beams.rows; ++row) {
          const auto i = static_cast<std::size_t>(row * beams.cols + column);
          const float range_m = scan->range_m[i];
          if (range_m == 0.0F || range_m > 6.0F || (!beams.masked.empty() && beams.masked[i] != 0)) continue;
          double after_s = beams.column_offset_s[static_cast<std::size_t>(column)];
          if (rows_in_turn) after_s += beams.row_offset_s[static_cast<std::size_t>(row)];
          const TimeNs fired = scan->stamp + (duration == 0 ? 0 : from_seconds(after_s));
          const Eigen::Vector3f p_lidar = beams.origins_lidar[i] + range_m * beams.directions_lidar[i];
          const Vector3 p = motion.at(now).inverse() * motion.at(fired) * scan->T_body_lidar * p_lidar.cast<double>();
          if (p.norm() >= kOwn_m) expected.push_back(p.cast<float>());
        }
      }
      ASSERT_EQ(points.size(), expected.size()) << rows_in_turn << " " << duration;
      EXPECT_GT(points.size(), 30U);
      for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT((points[i] - expected[i]).norm(), 1e-5F) << i;
    }
  }
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

TEST(VoxelThinner, ThinsAcrossZeroAndFarAway) {
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
    EXPECT_EQ(kept, expected) << half_m << ": after what was there before";
  }
}

}  // namespace
}  // namespace swiftlet
