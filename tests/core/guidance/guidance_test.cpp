// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "swiftlet/core/control/reference_governor.hpp"
#include "swiftlet/core/guidance/agile.hpp"
#include "swiftlet/core/guidance/takeoff_land.hpp"
#include "swiftlet/core/guidance/trajectory.hpp"
#include "swiftlet/core/guidance/waypoints.hpp"
#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

constexpr double kDt = 0.004;

MotionLimits limits_of(MotionLimitsConfig::Set set) {
  MotionLimitsConfig config;
  config.set = set;
  return config.resolve();
}

/// A vehicle that follows the reference governor exactly; a floor may support it.
class IdealFlight : public testing::GuidanceDriver {
 public:
  template <class Config>
  IdealFlight(const char* type, const Config& config, MotionLimitsConfig::Set set = MotionLimitsConfig::Set::kMedium,
              const Vector3& start_m = Vector3::Zero(), double start_yaw_rad = 0.0)
      : GuidanceDriver(type, config, start_m, start_yaw_rad, limits_of(set)), governor_(limits) {
    dt_s = kDt;
    Reference start;
    start.position_m = start_m;
    start.yaw_rad = start_yaw_rad;
    governor_.reset(start);
  }

  void step() {
    GuidanceDriver::step();
    const Reference& r = governor_.step(out.goal, kDt, out.speed_limit_mps);
    const bool lands = r.position_m.z() < floor_z;
    put({r.position_m.x(), r.position_m.y(), std::max(floor_z, r.position_m.z())}, r.yaw_rad);
    estimate.v_local_mps = r.velocity_mps;
    if (lands) estimate.v_local_mps.z() = 0.0;
  }
  /// Runs until done; the time that took, or -1.
  double run(double longest_s) {
    for (double t = 0.0; t < longest_s; t += kDt) {
      step();
      if (out.mission == MissionStatus::kDone) return t;
    }
    return -1.0;
  }
  Vector3 p() const { return p_m(); }
  Vector3 v() const { return estimate.v_local_mps; }
  double yaw() const { return yaw_of(estimate.T_local_body.linear()); }

  double floor_z = -1e9;

 private:
  ReferenceGovernor governor_;
};

TEST(Guidance, ConstructsEveryTypeFromItsDefaults) {
  AgentSetup setup;
  setup.T_local_body_start.translation() = Vector3(1, 2, 3);
  for (const GuidanceType& type : guidance_registry().rows()) {
    const auto guidance = make_guidance(Module(guidance_module_types(), type.module.name),
                                        {setup, limits_of(MotionLimitsConfig::Set::kAgile)});
    StateEstimate estimate;
    estimate.valid = true;
    estimate.T_local_body = setup.T_local_body_start;
    Observation observation;
    LocalPoses poses;
    GuidanceOutput out;
    Outbox outbox;
    guidance->step({.dt_s = kDt, .estimate = estimate, .observation = observation, .poses = poses}, out, outbox);
    EXPECT_TRUE(out.goal.position_m.allFinite()) << type.module.name;
    EXPECT_NE(out.mission, MissionStatus::kFailed) << type.module.name;
  }
  EXPECT_THROW(Module(guidance_module_types(), "teleport"), std::invalid_argument);
}

TEST(Waypoints, AreVisitedInOrderWithDwell) {
  WaypointsConfig config;
  config.waypoints_m = {{10, 0, 2}, {10, 8, 2}, {0, 8, 4}};
  config.dwell_s = 1.0;
  config.speed_mps = 1.5;
  IdealFlight flight("waypoints", config);
  std::size_t next = 0;
  double fastest = 0.0;
  const double expected_s = (std::sqrt(104.0) + 8 + std::sqrt(104.0)) / 1.5;  // lower bound without the ramps
  double t = 0.0;
  for (; t < 100.0 && flight.out.mission == MissionStatus::kRunning; t += kDt) {
    flight.step();
    fastest = std::max(fastest, flight.v().head<2>().norm());
    if (next < 3 && (flight.p() - config.waypoints_m[next]).norm() < config.arrival_radius_m) ++next;
  }
  EXPECT_EQ(next, 3u);
  EXPECT_EQ(flight.out.mission, MissionStatus::kDone);
  EXPECT_LE(fastest, 1.5 + 0.02);
  EXPECT_GT(t, expected_s + 3 * 1.0 - 3.0);
  EXPECT_LT(t, expected_s + 3 * 1.0 + 9.0);
}

TEST(Waypoints, CompleteTheMissionImmediatelyIfEmpty) {
  IdealFlight flight("waypoints", WaypointsConfig{}, MotionLimitsConfig::Set::kMedium, {1, 2, 3});
  flight.step();
  EXPECT_EQ(flight.out.mission, MissionStatus::kDone);
  EXPECT_EQ(flight.out.goal.position_m, Vector3(1, 2, 3));
}

TEST(Waypoints, LandAtEndAndStopMotors) {
  WaypointsConfig config;
  config.waypoints_m = {{3, 0, 2}};
  config.land_at_end = true;
  IdealFlight flight("waypoints", config, MotionLimitsConfig::Set::kMedium, {0, 0, 2});
  flight.floor_z = 0.4;  // the guidance does not know the ground height
  EXPECT_GT(flight.run(60.0), 3.0);
  EXPECT_FALSE(flight.out.motors_on);
  EXPECT_NEAR(flight.p().z(), 0.4, 1e-6);
  EXPECT_NEAR(flight.p().x(), 3.0, 0.2);
}

TEST(TakeoffLand, ClimbsHoversLandsAndIsDone) {
  TakeoffLandConfig config;
  config.altitude_m = 3.0;
  config.hover_s = 2.0;
  IdealFlight flight("takeoff_land", config, MotionLimitsConfig::Set::kMedium, {1, 1, 0.2});
  flight.floor_z = 0.2;
  double highest = 0.0;
  double t = 0.0;
  for (; t < 60.0 && flight.out.mission == MissionStatus::kRunning; t += kDt) {
    EXPECT_TRUE(flight.out.motors_on);
    flight.step();
    highest = std::max(highest, flight.p().z());
  }
  EXPECT_NEAR(highest, 3.2, 0.01);
  EXPECT_FALSE(flight.out.motors_on);
  EXPECT_NEAR(t, 3.0 / 1.0 + 2.0 + 3.0 / 0.5 + 0.5, 3.0);
}

using Shape = TrajectoryConfig::Shape;

TEST(Trajectory, HasConsistentGoalDerivatives) {
  for (const Shape shape : {Shape::kCircle, Shape::kLissajous, Shape::kLine}) {
    TrajectoryConfig config;
    config.shape = shape;
    config.amplitude_m = {6.0, 3.0, 0.5};
    config.speed_mps = 1.4;
    IdealFlight flight("trajectory", config, MotionLimitsConfig::Set::kFast);
    Reference before;
    double fastest = 0.0;
    int compared = 0;
    for (int i = 0; i < 20000; ++i) {
      flight.step();
      const Reference& now = flight.out.goal;
      if (before.velocity_mps.norm() > 0.0 && now.velocity_mps.norm() > 0.0) {
        ++compared;
        fastest = std::max(fastest, now.velocity_mps.norm());
        ASSERT_LE(now.acceleration_mps2.head<2>().norm(), flight.limits.horizontal_acceleration_mps2);
        ASSERT_LE(std::abs(now.acceleration_mps2.z()), flight.limits.vertical_acceleration_mps2);
        const Vector3 v_mean = (now.position_m - before.position_m) / kDt;
        const Vector3 a_mean = (now.velocity_mps - before.velocity_mps) / kDt;
        ASSERT_LT((v_mean - 0.5 * (now.velocity_mps + before.velocity_mps)).norm(), 1e-4) << static_cast<int>(shape);
        ASSERT_LT((a_mean - 0.5 * (now.acceleration_mps2 + before.acceleration_mps2)).norm(), 1e-3)
            << static_cast<int>(shape);
      }
      before = now;
    }
    EXPECT_GT(compared, 10000) << static_cast<int>(shape);
    EXPECT_NEAR(fastest, 1.4, 1e-3) << static_cast<int>(shape);
  }
}

TEST(Trajectory, IsTrackedExactlyOnceUnderWay) {
  TrajectoryConfig config;
  config.speed_mps = 2.0;
  config.radius_m = 6.0;
  config.center_m = {1, 2, 3};
  IdealFlight flight("trajectory", config);
  for (int i = 0; i < 10000; ++i) {
    flight.step();
    if (i < 6000) continue;
    ASSERT_EQ(flight.p(), flight.out.goal.position_m);
    ASSERT_NEAR((flight.p() - config.center_m).head<2>().norm(), 6.0, 1e-9);
    ASSERT_NEAR(flight.v().norm(), 2.0, 1e-9);
    ASSERT_NEAR(flight.yaw(), std::atan2(flight.v().y(), flight.v().x()), 1e-3);
  }
}

TEST(Trajectory, EndsLapsAtRestAtStart) {
  for (const Shape shape : {Shape::kCircle, Shape::kLissajous, Shape::kLine}) {
    TrajectoryConfig config;
    config.shape = shape;
    config.laps = 2;
    IdealFlight flight("trajectory", config, MotionLimitsConfig::Set::kFast);
    flight.step();
    const Vector3 begin = flight.out.goal.position_m;
    EXPECT_GT(flight.run(200.0), 10.0) << static_cast<int>(shape);
    EXPECT_LT((flight.out.goal.position_m - begin).norm(), 1e-6) << static_cast<int>(shape);
    EXPECT_LT(flight.out.goal.velocity_mps.norm(), 1e-6) << static_cast<int>(shape);
  }
}

TEST(Trajectory, RefusesWhatTheLimitsForbid) {
  TrajectoryConfig config;
  config.speed_mps = 5.0;  // medium: 4 m/s
  EXPECT_THROW(IdealFlight("trajectory", config), std::invalid_argument);
  config.speed_mps = 3.9;
  config.radius_m = 2.0;  // 7.6 m/s^2
  EXPECT_THROW(IdealFlight("trajectory", config), std::invalid_argument);
  config.shape = TrajectoryConfig::Shape::kLine;
  config.from_m = {0, 0, 0};
  config.to_m = {0, 0, 50};  // straight up at 3.9 m/s
  EXPECT_THROW(IdealFlight("trajectory", config), std::invalid_argument);
}

TEST(Trajectory, NeverOvershootsShortTravelLengths) {
  const RampedTravel travel(1.0, 5.0, 2.0);  // too short for 5 m/s
  EXPECT_NEAR(travel.speed, 0.5, 1e-12);
  double last = 0.0;
  for (double t = 0.0; t < travel.duration_s() + 1.0; t += 0.01) {
    const auto [s, ds, dds] = travel.at(t);
    EXPECT_GE(s, last - 1e-12);
    EXPECT_LE(s, 1.0 + 1e-12);
    EXPECT_LE(ds, 0.5 + 1e-12);
    last = s;
  }
  EXPECT_NEAR(last, 1.0, 1e-12);
}

TEST(AgileSpline, KeepsLimitsAndComesNearThem) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
    AgileConfig config;
    config.seed = seed;
    const Vector3 start(0, 0, 6);
    AgileSpline spline(config, start, 8.5, 5.0);
    double fastest = 0.0, hardest = 0.0, jerk = 0.0, length = 0.0;
    Vector3 least = start, greatest = start;
    Vector3 before = start;
    for (int i = 0; i < 150000; ++i) {
      spline.advance(kDt);
      const Reference r = spline.reference();
      fastest = std::max(fastest, r.velocity_mps.norm());
      hardest = std::max(hardest, r.acceleration_mps2.norm());
      jerk = std::max(jerk, spline.jerk_mps3().norm());
      length += (r.position_m - before).norm();
      before = r.position_m;
      least = least.cwiseMin(r.position_m);
      greatest = greatest.cwiseMax(r.position_m);
    }
    EXPECT_LE(fastest, 8.2 * (1 + 1e-12)) << seed;
    EXPECT_LE(hardest, 4.5 * (1 + 1e-12)) << seed;
    EXPECT_LE(jerk, 2 * 4.5 / 0.5 * (1 + 1e-12)) << seed;
    EXPECT_TRUE((least.array() >= config.area_min_m.array() - 1e-9).all()) << least.transpose();
    EXPECT_TRUE((greatest.array() <= config.area_max_m.array() + 1e-9).all()) << greatest.transpose();
    // Vrba 2025, Table IV: 1782 m in 400 s, 8.2 m/s and 4.5 m/s^2 at most: 4.5 m/s on average.
    EXPECT_GT(fastest, 8.0) << seed;
    EXPECT_GT(hardest, 4.4) << seed;
    EXPECT_GT(length / 600.0, 4.0) << seed;
    EXPECT_GT(greatest.x() - least.x(), 40.0) << seed;
    EXPECT_GT(greatest.z() - least.z(), 3.0) << seed;
  }
}

TEST(AgileSpline, IsThreeTimesContinuouslyDifferentiable) {
  AgileSpline spline({}, {0, 0, 6}, 8.5, 5.0);
  const double dt = 1e-3;
  Reference before = spline.reference();
  Vector3 jerk_before = spline.jerk_mps3();
  for (int i = 0; i < 60000; ++i) {
    spline.advance(dt);
    const Reference r = spline.reference();
    const Vector3 jerk = spline.jerk_mps3();
    ASSERT_LT(((r.position_m - before.position_m) / dt - 0.5 * (r.velocity_mps + before.velocity_mps)).norm(), 1e-5);
    ASSERT_LT(
        ((r.velocity_mps - before.velocity_mps) / dt - 0.5 * (r.acceleration_mps2 + before.acceleration_mps2)).norm(),
        1e-4);
    ASSERT_LT(((r.acceleration_mps2 - before.acceleration_mps2) / dt - 0.5 * (jerk + jerk_before)).norm(), 1e-3);
    ASSERT_LT((jerk - jerk_before).norm(), 4 * 4.5 / (0.5 * 0.5) * dt * 1.01) << "snap is at most 4 a / h^2";
    before = r;
    jerk_before = jerk;
  }
}

TEST(AgileSpline, SeedsDifferAndRepeat) {
  AgileConfig config;
  const auto at_20s = [&](std::uint64_t seed, double dt) {
    config.seed = seed;
    AgileSpline spline(config, {0, 0, 6}, 8.5, 5.0);
    for (int i = 0; i < static_cast<int>(20.0 / dt); ++i) spline.advance(dt);
    return spline.reference().position_m;
  };
  EXPECT_EQ(at_20s(1, 0.0625), at_20s(1, 0.0625));
  EXPECT_LT((at_20s(1, 0.0625) - at_20s(1, 0.125)).norm(), 1e-9) << "the step does not matter";
  EXPECT_GT((at_20s(1, 0.0625) - at_20s(2, 0.0625)).norm(), 1.0);
}

TEST(AgileSpline, LegPaceSlowsWithinLimits) {
  // Vrba 2025, Table IV: 1331 m in 355 s, though 8.2 m/s are reached.
  double length_m = 0.0, fastest_mps = 0.0;
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
    AgileConfig config;
    config.seed = seed;
    config.pace_min = 0.23;
    config.area_min_m = {-40.0, -19.0, 7.5};
    config.area_max_m = {40.0, 19.0, 10.0};
    AgileSpline spline(config, {-5, 0, 8}, 8.5, 5.0);
    for (int i = 0; i < 35500; ++i) {
      spline.advance(0.01);
      const double speed_mps = spline.reference().velocity_mps.norm();
      length_m += 0.01 * speed_mps / 5.0;
      fastest_mps = std::max(fastest_mps, speed_mps);
      ASSERT_LE(spline.reference().acceleration_mps2.norm(), 4.5 * (1 + 1e-12));
    }
  }
  EXPECT_NEAR(length_m, 1331.0, 0.1 * 1331.0);
  EXPECT_GT(fastest_mps, 7.5);
  EXPECT_LE(fastest_mps, 8.2 * (1 + 1e-12));
}

TEST(AgileSpline, VerticalLimitsHoldOnTheirOwn) {
  AgileConfig config;
  config.area_max_m.z() = 30.0;
  AgileSpline spline(config, {0, 0, 6}, 2.0, 1.0);
  for (int i = 0; i < 50000; ++i) {
    spline.advance(kDt);
    ASSERT_LE(std::abs(spline.reference().velocity_mps.z()), 2.0 + 1e-12);
    ASSERT_LE(std::abs(spline.reference().acceleration_mps2.z()), 1.0 + 1e-12);
  }
}

TEST(Agile, PassesThroughTheReferenceGovernorUnchanged) {
  IdealFlight flight("agile", AgileConfig{}, MotionLimitsConfig::Set::kAgile, {0, 0, 6});
  for (int i = 0; i < 15000; ++i) {
    flight.step();
    ASSERT_EQ(flight.p(), flight.out.goal.position_m) << "at " << i * kDt;
  }
}

}  // namespace
}  // namespace swiftlet
