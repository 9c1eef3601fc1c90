// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/interception/target.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "tests/core/interception/hunt.hpp"

namespace swiftlet {
namespace {

constexpr double kTargetTick_s = 0.02;

/// A target, tick by tick; the vehicle is where its goal is.
struct Intruder : testing::GuidanceDriver {
  explicit Intruder(const TargetConfig& config, const Vector3& start_m = {5.0, -3.0, 10.0})
      : GuidanceDriver("target", config, start_m, 0.0, testing::kFast) {
    dt_s = kTargetTick_s;
  }
  const Reference& step() {
    GuidanceDriver::step();
    put(out.goal.position_m);
    return out.goal;
  }
  /// The only track that it observes.
  void sees(const Vector3& p_m, double age_s = 0.0) {
    tracks.resize(1);
    tracks[0].t = observation.t + from_seconds(dt_s - age_s);
    tracks[0].position_m = p_m;
  }
};

TargetConfig moving(TargetConfig::Motion motion, std::uint64_t seed = 1) {
  TargetConfig config;
  config.motion = motion;
  config.seed = seed;
  config.speed_mps = 3.0;
  config.acceleration_mps2 = 1.5;
  return config;
}

TEST(TargetMotion, StartsInPlaceWithinLimits) {
  using Motion = TargetConfig::Motion;
  for (const Motion motion :
       {Motion::kHover, Motion::kLine, Motion::kCircle, Motion::kFigureEight, Motion::kRandom, Motion::kEvasive}) {
    const TargetConfig config = moving(motion);
    Intruder intruder(config);
    EXPECT_LT((intruder.step().position_m - Vector3(5, -3, 10)).norm(), 0.2) << static_cast<int>(motion);
    double farthest_m = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const Reference& r = intruder.step();
      ASSERT_LE(r.velocity_mps.norm(), 1.01 * config.speed_mps) << static_cast<int>(motion);
      ASSERT_LE(r.acceleration_mps2.norm(), 1.01 * config.acceleration_mps2) << static_cast<int>(motion);
      farthest_m = std::max(farthest_m, (r.position_m - Vector3(5, -3, 10)).norm());
    }
    EXPECT_EQ(farthest_m < 0.01, motion == Motion::kHover) << static_cast<int>(motion);
    EXPECT_LT(farthest_m, 60.0) << static_cast<int>(motion);
  }
}

TEST(TargetMotion, SeedDeterminesTheTrajectory) {
  const auto end_m = [](std::uint64_t seed) {
    Intruder intruder(moving(TargetConfig::Motion::kRandom, seed));
    for (int i = 0; i < 500; ++i) intruder.step();
    return intruder.p_m();
  };
  EXPECT_EQ(end_m(1), end_m(1));
  EXPECT_GT((end_m(2) - end_m(1)).norm(), 1.0);
}

TEST(TargetMotion, CirclesThroughStartTowardBoxCenter) {
  const Vector3 start_m(5, -3, 10), inward = Vector3(-5, 3, 0).normalized();
  int left_turns = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Intruder intruder(moving(TargetConfig::Motion::kCircle, seed), start_m);
    const Vector3 center_m = start_m + 8.0 * inward;
    for (int i = 0; i < 1500; ++i) {
      const Reference& r = intruder.step();
      ASSERT_NEAR((r.position_m - center_m).norm(), 8.0, 1e-9);
      ASSERT_NEAR(r.position_m.z(), 10.0, 1e-12);
      if (i * kTargetTick_s > 8.0) {
        ASSERT_NEAR(r.velocity_mps.norm(), 3.0, 1e-9) << "after the start";
      }
      if (i == 1000) left_turns += (r.position_m - center_m).cross(r.velocity_mps).z() > 0.0;
    }
  }
  EXPECT_GT(left_turns, 0);
  EXPECT_LT(left_turns, 8) << "the sense is drawn";
}

TEST(TargetMotion, CirclesLevelFromBoxCenter) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Intruder intruder(moving(TargetConfig::Motion::kCircle, seed), {0.3, 0.2, 10.0});
    double widest_m = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const Vector3 p_m = intruder.step().position_m;
      ASSERT_NEAR(p_m.z(), 10.0, 1e-9);
      widest_m = std::max(widest_m, (p_m - Vector3(0.3, 0.2, 10.0)).norm());
    }
    EXPECT_NEAR(widest_m, 16.0, 0.01) << "its diameter";
  }
}

TEST(TargetMotion, ClosesFigureEightAtGivenRadius) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Intruder intruder(moving(TargetConfig::Motion::kFigureEight, seed));
    double widest_m = 0.0, fastest_mps = 0.0;
    int passes = 0;
    bool near = true;
    for (int i = 0; i < 4000; ++i) {
      const Reference& r = intruder.step();
      const double off_m = (r.position_m - Vector3(5, -3, 10)).norm();
      ASSERT_NEAR(r.position_m.z(), 10.0, 1e-12);
      passes += off_m < 0.2 && !near;
      near = off_m < 0.2;
      widest_m = std::max(widest_m, off_m);
      fastest_mps = std::max(fastest_mps, r.velocity_mps.norm());
      ASSERT_LE(r.acceleration_mps2.norm(), 1.5 + 1e-9);
    }
    EXPECT_NEAR(widest_m, 8.0, 0.01) << seed;
    EXPECT_GT(fastest_mps, 0.98 * 3.0);
    EXPECT_LE(fastest_mps, 3.0);
    EXPECT_GE(passes, 5);
  }
}

TEST(TargetMotion, MatchesDerivativesOfItsPosition) {
  for (const auto motion : {TargetConfig::Motion::kCircle, TargetConfig::Motion::kFigureEight,
                            TargetConfig::Motion::kRandom, TargetConfig::Motion::kEvasive}) {
    Intruder intruder(moving(motion));
    Reference before = intruder.step();
    for (int i = 0; i < 2000; ++i) {
      const Reference now = intruder.step();
      ASSERT_LT(((now.position_m - before.position_m) / kTargetTick_s - 0.5 * (now.velocity_mps + before.velocity_mps))
                    .norm(),
                0.01)
          << static_cast<int>(motion);
      ASSERT_LT(((now.velocity_mps - before.velocity_mps) / kTargetTick_s -
                 0.5 * (now.acceleration_mps2 + before.acceleration_mps2))
                    .norm(),
                0.6)
          << static_cast<int>(motion);
      before = now;
    }
  }
}

TEST(TargetMotion, FollowsInnerLinesAtConstantSpeed) {
  const TargetConfig config = moving(TargetConfig::Motion::kLine, 3);
  Intruder intruder(config);
  std::vector<Vector3> corners_m;
  Vector3 before_m = Vector3(5, -3, 10), heading = Vector3::Zero();
  for (int i = 0; i < 6000; ++i) {
    const Reference& r = intruder.step();
    ASSERT_LE((r.position_m - before_m).norm(), 3.0 * kTargetTick_s + 1e-9);
    ASSERT_NEAR(r.velocity_mps.norm(), 3.0, 1e-9);
    ASSERT_TRUE((r.position_m.array() >= config.area_min_m.array() - 1e-9).all());
    ASSERT_TRUE((r.position_m.array() <= config.area_max_m.array() + 1e-9).all());
    if ((r.velocity_mps - heading).norm() > 1e-6) corners_m.push_back(before_m);
    heading = r.velocity_mps;
    before_m = r.position_m;
  }
  ASSERT_GT(corners_m.size(), 5U);
  double way_m = 0.0;
  for (std::size_t i = 1; i < corners_m.size(); ++i) {
    const double leg_m = (corners_m[i] - corners_m[i - 1]).norm();
    EXPECT_GT(leg_m, 15.0 - 0.15) << i;
    way_m += leg_m;
  }
  EXPECT_GT(way_m, 200.0);
}

TEST(TargetMotion, AnUndisturbedEvaderCruises) {
  TargetConfig config = moving(TargetConfig::Motion::kEvasive);
  config.area_min_m = {-200, -200, 5};
  config.area_max_m = {200, 200, 100};
  Intruder alone(config, {0, 0, 50}), old(config, {0, 0, 50}), far(config, {0, 0, 50});
  for (int i = 0; i < 300; ++i) {
    old.sees(old.p_m() + Vector3(3, 0, 0), 0.8);
    far.sees(far.p_m() + Vector3(0, config.alarm_m + 0.2, 0));
    const Vector3 p_m = alone.step().position_m;
    ASSERT_EQ(old.step().position_m, p_m) << "an old track is ignored";
    ASSERT_EQ(far.step().position_m, p_m);
  }
  EXPECT_NEAR(alone.step().velocity_mps.norm(), 0.6 * 3.0, 0.01);
}

TEST(TargetMotion, EvadesNearestPursuerAtFullSpeed) {
  TargetConfig config = moving(TargetConfig::Motion::kEvasive);
  config.area_min_m = {-200, -200, 5};
  config.area_max_m = {200, 200, 100};
  for (const Vector3& from : {Vector3(1, 0, 0), Vector3(0, -1, 0), Vector3(-0.6, 0.8, 0)}) {
    Intruder intruder(config, {0, 0, 50});
    double fastest_mps = 0.0;
    for (int i = 0; i < 300; ++i) {
      intruder.sees(intruder.p_m() + 5.0 * from);
      intruder.tracks.push_back(intruder.tracks[0]);
      intruder.tracks[1].position_m = intruder.p_m() - 9.0 * from;  // farther away
      fastest_mps = std::max(fastest_mps, intruder.step().velocity_mps.norm());
    }
    EXPECT_LT(intruder.p_m().dot(from), -0.4 * 3.0 * 6.0);
    EXPECT_NEAR(fastest_mps, 3.0, 0.1);
  }
}

TEST(TargetMotion, JinksButStaysInItsBox) {
  const TargetConfig config = moving(TargetConfig::Motion::kEvasive);
  Intruder intruder(config, {0, 0, 10});
  Vector3 least = Vector3::Constant(1e9), greatest = -least;
  int jinks = 0;
  double side = 0.0;
  for (int i = 0; i < 6000; ++i) {
    const Vector3 chaser = Vector3(3, 4, 0);
    intruder.sees(intruder.p_m() + chaser);
    const Reference& r = intruder.step();
    least = least.cwiseMin(r.position_m);
    greatest = greatest.cwiseMax(r.position_m);
    const double now = r.velocity_mps.cross(chaser).z() > 0.0 ? 1.0 : -1.0;
    jinks += now != side;
    side = now;
  }
  EXPECT_GT(jinks, 10);
  EXPECT_TRUE((least.array() > config.area_min_m.array() - 1.0).all()) << least.transpose();
  EXPECT_TRUE((greatest.array() < config.area_max_m.array() + 1.0).all()) << greatest.transpose();
}

TEST(TargetMotion, HeadsWhereItFlies) {
  for (const auto motion : {TargetConfig::Motion::kCircle, TargetConfig::Motion::kRandom}) {
    Intruder intruder(moving(motion));
    for (int i = 0; i < 1500; ++i) {
      const Reference& r = intruder.step();
      if (r.velocity_mps.head<2>().norm() < 0.6) continue;
      const double heading = std::atan2(r.velocity_mps.y(), r.velocity_mps.x());
      ASSERT_NEAR(std::remainder(r.yaw_rad - heading, 2.0 * std::acos(-1.0)), 0.0, 1e-6);
    }
  }
}

TEST(TargetMotion, RefusesMoreThanItsLimits) {
  TargetConfig config;
  config.speed_mps = 8.0;
  config.acceleration_mps2 = 4.0;
  EXPECT_NO_THROW(Intruder{config});
  config.speed_mps = 8.01;
  EXPECT_THROW(Intruder{config}, std::invalid_argument);
  config.speed_mps = 8.0;
  config.acceleration_mps2 = 4.01;
  EXPECT_THROW(Intruder{config}, std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet
