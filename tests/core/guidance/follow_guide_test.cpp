// SPDX-License-Identifier: BSD-3-Clause
// The guided vehicle: following paths in its own body frame, its reports, and behavior without messages.
#include "swiftlet/core/guidance/follow_guide.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/messages/guiding_path.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/odometry_report.hpp"
#include "tests/core/guidance/guidance_driver.hpp"
#include "tests/support/field_coverage.hpp"

namespace swiftlet {
namespace {

using testing::GuidanceDriver;

constexpr VehicleId kPrimary = 1;

FollowGuideConfig guided_by_uav2() {
  FollowGuideConfig config;
  config.primary = "uav2";
  return config;
}

/// A guided vehicle that is where the test puts it.
struct Guided : GuidanceDriver {
  explicit Guided(const FollowGuideConfig& config = guided_by_uav2(), const Vector3& start_m = {10, 20, 3},
                  double yaw_rad = 0.5 * kPi)
      : GuidanceDriver("follow_guide", config, start_m, yaw_rad), yaw_rad_(yaw_rad) {}
  static constexpr double kPi = 3.14159265358979323846;

  void hears(std::vector<GuidingWaypoint> waypoints, VehicleId from = kPrimary, std::optional<TimeNs> instant = {}) {
    GuidingPath path;
    path.path = ++path_;
    path.has_instant = instant.has_value();
    path.t = instant.value_or(0);
    path.waypoints = std::move(waypoints);
    Message message;
    write_message(path, message);
    message.from = from;
    observation.messages.push_back(message);
  }
  void rest(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / dt_s)); ++i) step();
  }
  std::vector<OdometryReport> reports() {
    std::vector<OdometryReport> all;
    for (const Message& message : outbox.messages()) {
      EXPECT_EQ(message.to, kPrimary);
      OdometryReport report;
      EXPECT_EQ(read_message(message, report), Reading::kDone);
      all.push_back(report);
    }
    return all;
  }
  double yaw_rad_;
  std::uint32_t path_ = 0;
};

TEST(FollowGuide, MapsForwardWaypointAlongItsHeading) {
  Guided guided;
  guided.step();
  guided.hears({{{2.0F, 1.0F, 0.5F}, 0.3F}});
  const GuidanceOutput& out = guided.step();
  // Heading north: ahead is +y, left is -x.
  EXPECT_LT((out.goal.position_m - Vector3(9, 22, 3.5)).norm(), 1e-6);
  EXPECT_NEAR(out.goal.yaw_rad, 0.5 * Guided::kPi + 0.3, 1e-6);
  EXPECT_EQ(out.mission, MissionStatus::kEndless);
}

TEST(FollowGuide, KeepsPathLevelDespiteBodyTilt) {
  Guided guided;
  guided.estimate.T_local_body.linear() =
      (Eigen::AngleAxisd(0.5 * Guided::kPi, Vector3::UnitZ()) * Eigen::AngleAxisd(0.3, Vector3::UnitY()))
          .toRotationMatrix();
  guided.step();
  guided.hears({{{2.0F, 0.0F, 0.0F}, 0.0F}});
  EXPECT_LT((guided.step().goal.position_m - Vector3(10, 22, 3)).norm(), 1e-6);
}

TEST(FollowGuide, IgnoresPathsWithUnknownReferenceTime) {
  Guided guided;
  guided.step();
  guided.hears({{{2.0F, 0.0F, 0.0F}, 0.0F}}, kPrimary, from_seconds(1e5));
  EXPECT_LT((guided.step().goal.position_m - Vector3(10, 20, 3)).norm(), 1e-6);
}

TEST(FollowGuide, DropsAndReportsVisitedWaypoints) {
  Guided guided;
  guided.step();
  guided.hears({{{1.0F, 0.0F, 0.0F}, 0.0F}, {{2.0F, 0.0F, 0.0F}, 0.0F}, {{2.0F, 2.0F, 0.0F}, 0.0F}});
  EXPECT_LT((guided.step().goal.position_m - Vector3(10, 21, 3)).norm(), 1e-6);
  guided.put({10, 20.8, 3}, 0.5 * Guided::kPi);
  EXPECT_LT((guided.step().goal.position_m - Vector3(10, 22, 3)).norm(), 1e-6);
  guided.put({10, 22, 3}, 0.5 * Guided::kPi);
  guided.rest(1.0);
  EXPECT_EQ(guided.reports().back().num_visited, 2);
  EXPECT_EQ(guided.reports().back().path, 1U);
  guided.put({8, 22, 3}, 0.5 * Guided::kPi);
  EXPECT_STREQ(guided.step().note, "hovering as commanded by the guide");
  EXPECT_LT((guided.step().goal.position_m - Vector3(8, 22, 3)).norm(), 1e-6) << "the last waypoint is held";
}

TEST(FollowGuide, IgnoresPathsOfOtherVehicles) {
  Guided guided;
  guided.step();
  guided.hears({{{2.0F, 0.0F, 0.0F}, 0.0F}}, 2);
  EXPECT_LT((guided.step().goal.position_m - Vector3(10, 20, 3)).norm(), 1e-6);
  EXPECT_STREQ(guided.step().note, "waiting for the guide");
}

TEST(FollowGuide, IgnoresOutdatedAndDuplicatePaths) {
  Guided guided;
  guided.step();
  guided.path_ = 5;
  guided.hears({{{2.0F, 0.0F, 0.0F}, 0.0F}});
  guided.step();
  for (const std::uint32_t stale : {3U, 5U}) {  // late, and a duplicate
    guided.path_ = stale;
    guided.hears({{{-2.0F, 0.0F, 0.0F}, 0.0F}});
    EXPECT_LT((guided.step().goal.position_m - Vector3(10, 22, 3)).norm(), 1e-6);
  }
}

TEST(FollowGuide, HoversUntilTheLinkIsBack) {
  Guided guided;
  guided.step();
  guided.hears({{{9.0F, 0.0F, 0.0F}, 0.0F}});
  guided.step();
  EXPECT_STREQ(guided.out.note, "following the guide");
  guided.put({10, 21, 3}, 0.5 * Guided::kPi);
  guided.estimate.v_local_mps = {0, 1.0, 0};
  guided.rest(2.0);
  EXPECT_STREQ(guided.out.note, "hovering: link to the guide lost");
  EXPECT_EQ(guided.out.mission, MissionStatus::kEndless);
  // At 2 m/s^2 it stops from 1 m/s within a quarter of a meter.
  EXPECT_LT((guided.out.goal.position_m - Vector3(10, 21.25, 3)).norm(), 1e-6);
  guided.put({10, 21.2, 3}, 0.5 * Guided::kPi);
  guided.rest(5.0);
  EXPECT_LT((guided.out.goal.position_m - Vector3(10, 21.25, 3)).norm(), 1e-6)
      << "the goal stays at the stopping point";
  guided.estimate.v_local_mps.setZero();
  guided.hears({{{1.0F, 0.0F, 0.0F}, 0.0F}});
  guided.step();
  EXPECT_STREQ(guided.out.note, "following the guide");
  EXPECT_LT((guided.out.goal.position_m - Vector3(10, 22.2, 3)).norm(), 1e-6);
}

TEST(FollowGuide, AcceptsRestartedGuideAfterLinkLoss) {
  Guided guided;
  guided.path_ = 1000;
  guided.step();
  guided.hears({{{2.0F, 0.0F, 0.0F}, 0.0F}});
  guided.rest(3.0);
  guided.path_ = 0;
  guided.hears({{{0.0F, 2.0F, 0.0F}, 0.0F}});
  EXPECT_LT((guided.step().goal.position_m - Vector3(8, 20, 3)).norm(), 1e-6);
}

TEST(FollowGuide, StopsOnAnEmptyPath) {
  Guided guided;
  guided.step();
  guided.hears({{{9.0F, 0.0F, 0.0F}, 0.0F}});
  guided.step();
  guided.put({10, 23, 3}, 0.5 * Guided::kPi);
  guided.hears({});
  EXPECT_LT((guided.step().goal.position_m - Vector3(10, 23, 3)).norm(), 1e-6);
  EXPECT_STREQ(guided.out.note, "hovering as commanded by the guide");
}

TEST(FollowGuide, OscillatesUntilItsGuideResponds) {
  FollowGuideConfig config = guided_by_uav2();
  config.excitation = {1.0, 0.7};
  Guided guided(config);
  double spread_m = 0.0;
  Vector3 mean_m = Vector3::Zero();
  for (int i = 0; i < 126; ++i) {  // one round
    const Vector3 goal_m = guided.step().goal.position_m;
    spread_m = std::max(spread_m, (goal_m - Vector3(10, 20, 3)).norm());
    mean_m += goal_m / 126.0;
  }
  EXPECT_NEAR(spread_m, 1.0, 0.07);
  EXPECT_LT((mean_m - Vector3(10, 20, 3)).norm(), 0.05);
  guided.put({10.5, 20.2, 3}, 0.5 * Guided::kPi);
  for (int i = 0; i < 30; ++i) {
    guided.hears({});  // its guide plans
    EXPECT_LT((guided.step().goal.position_m - Vector3(10.5, 20.2, 3)).norm(), 1e-6)
        << "the goal is the position at the first response";
  }
}

TEST(FollowGuide, RefusesUnknownGuideByName) {
  for (const char* name : {"uav1", "uav99"}) {
    FollowGuideConfig config;
    config.primary = name;
    try {
      const Guided guided(config);
      FAIL() << name;
    } catch (const std::invalid_argument& problem) {
      EXPECT_NE(std::string(problem.what()).find("guidance.primary: expected the name of another vehicle (uav2, uav3"),
                std::string::npos)
          << problem.what();
    }
  }
}

Message message_with(GuidingPath::Command status, double radius_m = 0.0) {
  GuidingPath path;
  path.path = 1;
  path.command = status;
  path.radius_m = radius_m;
  Message message;
  write_message(path, message);
  message.from = kPrimary;
  return message;
}

TEST(FollowGuide, SkipsWaypointsAlreadyPassed) {
  Guided guided(guided_by_uav2(), {10, 20, 3}, 0.0);
  guided.step();
  const OdometryReport report = guided.reports().front();
  guided.put({11.2, 20.1, 3});
  guided.step();
  guided.hears({{{0.5F, 0, 0}, 0}, {{1.0F, 0, 0}, 0}, {{1.5F, 0, 0}, 0}, {{1.5F, 2, 0}, 0}}, kPrimary, report.t);
  EXPECT_LT((guided.step().goal.position_m - Vector3(11.5, 20, 3)).norm(), 1e-6);
  guided.put({11.2, 21.0, 3});  // off the path: back to its beginning
  guided.hears({{{0.5F, 0, 0}, 0}, {{1.0F, 0, 0}, 0}, {{1.5F, 0, 0}, 0}}, kPrimary, report.t);
  EXPECT_LT((guided.step().goal.position_m - Vector3(10.5, 20, 3)).norm(), 1e-6);
}

TEST(FollowGuide, ReportsHeadingRateRegardlessOfTilt) {
  Guided guided;
  guided.estimate.T_local_body.linear() = Eigen::AngleAxisd(0.5, Vector3::UnitX()).toRotationMatrix();
  guided.estimate.omega_body_radps = {0.3, 0.2, 0.7};
  guided.step();
  EXPECT_NEAR(guided.reports().front().yaw_rate_radps, 0.2 * std::sin(0.5) + 0.7 * std::cos(0.5), 1e-12);
}

TEST(FollowGuide, FinishesMissionTogetherWithItsGuide) {
  for (const auto& [status, mission] : {std::pair(GuidingPath::Command::kDone, MissionStatus::kDone),
                                        std::pair(GuidingPath::Command::kFailed, MissionStatus::kFailed)}) {
    Guided guided;
    guided.step();
    guided.observation.messages.push_back(message_with(status));
    EXPECT_EQ(guided.step().mission, mission);
  }
}

TEST(FollowGuide, MovesWithinCommandedRadiusUntilLocalized) {
  for (const double radius_m : {0.4, 0.9, 5.0}) {
    Guided guided;
    guided.step();
    double farthest_m = 0.0;
    for (int i = 0; i < 300; ++i) {
      Message message = message_with(GuidingPath::Command::kMove, radius_m);
      GuidingPath path;
      ASSERT_EQ(read_message(message, path), Reading::kDone);
      path.path = ++guided.path_;
      write_message(path, message);
      guided.observation.messages.push_back(message);
      farthest_m = std::max(farthest_m, (guided.step().goal.position_m - Vector3(10, 20, 3)).norm());
    }
    EXPECT_GT(farthest_m, 0.9 * std::min(radius_m, 1.0)) << radius_m;
    EXPECT_LT(farthest_m, 1.15 * std::min(radius_m, 1.0)) << "a meter at most, for " << radius_m;
    guided.hears({});
    EXPECT_LT((guided.step().goal.position_m - Vector3(10, 20, 3)).norm(), 1e-9);
  }
}

TEST(FollowGuide, StampsReportsWithOffsetDriftingClock) {
  FollowGuideConfig config = guided_by_uav2();
  config.clock = {100.0, 8000.0};
  Guided guided(config);
  guided.rest(4.0);
  for (const OdometryReport& report : guided.reports()) {
    const double clock_s = to_seconds(report.t) - 100.0, t_s = clock_s / 1.008;
    EXPECT_NEAR(2.0 * t_s, std::round(2.0 * t_s), 0.21) << "reports are half a second apart";
  }
  EXPECT_NEAR(to_seconds(guided.reports().back().t), 100.0 + 1.008 * 4.0, 1e-6);
}

TEST(FollowGuide, InterpolatesPoseAtOwnClockTime) {
  FollowGuideConfig config = guided_by_uav2();
  config.clock = {-7.0, 9000.0};
  Guided guided(config, {0, 0, 3}, 0.0);
  for (int i = 1; i <= 60; ++i) {
    guided.put({0.5 * i, 0, 3});  // 5 m/s
    guided.step();
  }
  const double then_s = 4.73;  // between two ticks, and no instant of a report
  guided.hears({{{0.0F, 9.0F, 0.0F}, 0.0F}}, kPrimary, from_seconds(-7.0 + 1.009 * then_s));
  EXPECT_LT((guided.step().goal.position_m - Vector3(5.0 * then_s, 9, 3)).norm(), 1e-6);
}

TEST(FollowGuide, StopsWithinItsBrakingDistanceAhead) {
  Guided guided;
  guided.step();
  guided.hears({{{90.0F, 0.0F, 0.0F}, 0.0F}});
  guided.step();
  guided.estimate.v_local_mps = {3.0, -4.0, -2.0};
  guided.hears({});
  // v^2 / 2a: 5 m/s at 2 m/s^2, and 2 m/s at 1 m/s^2.
  const Vector3 rest_m = Vector3(10, 20, 3) + Vector3(0.6 * 6.25, -0.8 * 6.25, -2.0);
  EXPECT_LT((guided.step().goal.position_m - rest_m).norm(), 1e-9);
  guided.put({11, 18, 2}, 0.0);
  guided.hears({});
  EXPECT_LT((guided.step().goal.position_m - rest_m).norm(), 1e-9) << "the stopping point stays fixed during braking";
  guided.estimate.v_local_mps = {0.0, 0.0, 2.0};
  guided.hears({{{90.0F, 0.0F, 0.0F}, 0.0F}});
  guided.step();
  guided.hears({});
  EXPECT_LT((guided.step().goal.position_m - Vector3(11, 18, 4)).norm(), 1e-9) << "upward, too";
}

TEST(FollowGuide, WrapsPathHeadingsToHalfTurn) {
  Guided guided(guided_by_uav2(), {0, 0, 3}, 2.5);
  guided.step();
  guided.hears({{{9.0F, 0.0F, 0.0F}, 1.5F}});
  EXPECT_NEAR(guided.step().goal.yaw_rad, 4.0 - 2.0 * Guided::kPi, 1e-6);
}

TEST(FollowGuide, ReportsTwiceASecond) {
  for (const double tick_s : {0.02, 0.2, 0.7}) {
    Guided guided;
    guided.dt_s = tick_s;
    guided.observation.t = from_seconds(1000.0);  // switched on late
    guided.estimate.v_local_mps = {0.1, 0.2, 0.3};
    guided.rest(28.0);
    EXPECT_NEAR(static_cast<double>(guided.reports().size()), tick_s > 0.5 ? 40.0 : 56.0, 1.0) << tick_s;
    EXPECT_TRUE(guided.reports().back().T_local_body.isApprox(guided.estimate.T_local_body, 1e-12));
    EXPECT_EQ(guided.reports().back().v_local_mps, Vector3(0.1, 0.2, 0.3));
  }
}

TEST(FollowGuide, ShowsRemainingPathAndHoldPosition) {
  Guided guided(guided_by_uav2(), {0, 0, 3}, 0.0);
  guided.step();
  guided.hears({{{2.0F, 0.0F, 0.0F}, 0.0F}, {{4.0F, 0.0F, 0.0F}, 0.0F}});
  guided.step();
  std::vector<Overlay> overlays;
  guided.guidance->append_overlays(overlays);
  ASSERT_EQ(overlays.size(), 1U);
  ASSERT_EQ(overlays[0].positions.size(), 3U);
  EXPECT_EQ(overlays[0].positions[2], Eigen::Vector3f(4, 0, 3));
}

// ---- sizes [Pritzl 2024, Table IV]: odometry 725 bytes at 2 Hz, paths of 132 to 484 bytes at 5 Hz

TEST(GuidingMessages, AreNoLargerThanPublishedOnes) {
  Message message;
  write_message(OdometryReport{}, message);
  EXPECT_LE(message.size_bytes(), 725U);
  GuidingPath path;
  path.waypoints.resize(1);
  write_message(path, message);
  EXPECT_LE(message.size_bytes(), 132U);
  path.waypoints.resize(26);
  write_message(path, message);
  EXPECT_LE(message.size_bytes(), 484U) << "26 waypoints in the bytes of their largest path";
}

TEST(GuidingMessages, NameEveryFieldAndRoundTrip) {
  EXPECT_TRUE(forgets<OdometryReport>(0));
  EXPECT_TRUE(forgets<GuidingPath>(0));
  EXPECT_TRUE(forgets<GuidingWaypoint>(0));
  GuidingPath path, read;
  path.path = 7;
  path.has_instant = true;
  path.t = -3;
  path.waypoints = {{{1.5F, -2.0F, 0.25F}, 0.5F}, {{3.0F, 0.0F, 1.0F}, -0.5F}};
  Message message;
  write_message(path, message);
  ASSERT_EQ(read_message(message, read), Reading::kDone);
  EXPECT_EQ(read.path, 7U);
  EXPECT_EQ(read.t, -3);
  ASSERT_EQ(read.waypoints.size(), 2U);
  EXPECT_EQ(read.waypoints[1].p_body_m, path.waypoints[1].p_body_m);
  EXPECT_EQ(read.waypoints[1].yaw_rad, -0.5F);
}

}  // namespace
}  // namespace swiftlet
