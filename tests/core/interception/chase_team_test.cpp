// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/chase_team.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "swiftlet/core/messages/kind.hpp"

namespace swiftlet {
namespace {

using Status = ChaseReport::Status;

constexpr VehicleId kSelf = 1, kOther = 2, kThird = 0;

/// One vehicle of three, which receives the messages of the others without delay.
struct Team {
  void receives(VehicleId from, Status status, double arrival_s, const Vector3& p_m = {5, 0, 10},
                const Vector3& v_mps = {0, 2, 0}, const Vector3& target_m = {0, 0, 10}, TimeNs t = -1) {
    ChaseReport report;
    report.t = t < 0 ? observation.t : t;
    report.status = status;
    report.arrival_s = arrival_s;
    report.target_world_m = target_m;
    report.target_world_mps = {1, 0, 0};
    report.interval_s = 0.5;
    for (int i = 0; i < 4; ++i) report.places.push_back({(p_m + 0.5 * i * v_mps).cast<float>()});
    Message message;
    message.from = from;
    write_message(report, message);
    observation.messages = {message};
    team.listen(observation, {});
    team.compare_targets({0, 0, 10}, observation.t, 3.0);
    observation.messages.clear();
  }
  void wait(double duration_s) {
    observation.t += from_seconds(duration_s);
    team.listen(observation, {});
  }
  bool leads(double arrival_s) {
    team.decide(observation.t, arrival_s);
    return team.leads();
  }
  std::vector<MovingObstacle> moving_obstacles() {
    std::vector<MovingObstacle> all;
    all.reserve(8);
    team.append_moving_obstacles(observation.t, 3.0, 6.0, all);
    return all;
  }

  Observation observation;
  ChaseTeam team{kSelf, 3};
};

TEST(PathAhead, FollowsItsWaypointsAndExtrapolatesBeyond) {
  PathAhead path;
  path.interval_s = 0.5;
  path.num_places = 3;
  path.places_local_m = {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1, 2, 0)};
  EXPECT_TRUE(path.at(0.25).isApprox(Vector3(0.5, 0, 0)));
  EXPECT_TRUE(path.at(0.75).isApprox(Vector3(1, 1, 0)));
  EXPECT_TRUE(path.at(1.0).isApprox(Vector3(1, 2, 0)));
  EXPECT_TRUE(path.at(2.0).isApprox(Vector3(1, 6, 0)));
  EXPECT_TRUE(path.velocity_mps(0.25).isApprox(Vector3(2, 0, 0)));
  EXPECT_TRUE(path.velocity_mps(9.0).isApprox(Vector3(0, 4, 0)));
  path.num_places = 1;
  EXPECT_TRUE(path.at(3.0).isZero());
  EXPECT_TRUE(path.velocity_mps(3.0).isZero());
}

TEST(ChaseTeam, LeadsWhenAlone) {
  EXPECT_TRUE(Team().leads(100.0));
  ChaseTeam alone(0, 1);
  alone.decide(0, 5.0);
  EXPECT_TRUE(alone.leads());
  EXPECT_FALSE(alone.is_report_due(0)) << "no other interceptor receives it";
}

TEST(ChaseTeam, LeaderArrivesSoonest) {
  Team here;
  here.receives(kOther, Status::kYields, 2.0);
  EXPECT_TRUE(here.leads(1.5));
  EXPECT_TRUE(here.leads(2.05)) << "a leader stays for a small difference";
  EXPECT_FALSE(here.leads(2.5));
  here.receives(kThird, Status::kYields, 1.0);
  EXPECT_FALSE(here.leads(1.5));
}

// Two vehicles with the same rule never both yield once each has received the other's report.
TEST(ChaseTeam, HasOneLeaderForAnyReports) {
  for (const double first_s : {1.0, 1.2, 1.5, 3.0}) {
    for (const double second_s : {1.0, 1.2, 1.5, 3.0}) {
      for (const bool first_led : {false, true}) {
        for (const bool second_led : {false, true}) {
          ChaseTeam teams[2] = {ChaseTeam(0, 2), ChaseTeam(1, 2)};
          const double arrival_s[2] = {first_s, second_s};
          const bool led[2] = {first_led, second_led};
          for (const VehicleId i : {0, 1}) {
            ChaseReport report;
            report.status = led[1 - i] ? Status::kLeads : Status::kYields;
            report.arrival_s = arrival_s[1 - i];
            report.interval_s = 0.5;
            report.places.resize(2);
            Observation observation;
            observation.messages.resize(1);
            observation.messages[0].from = 1 - i;
            write_message(report, observation.messages[0]);
            // The decision is set directly.
            teams[i].decide(0, led[i] ? std::optional(1.0) : std::nullopt);
            teams[i].listen(observation, {});
            teams[i].compare_targets(Vector3::Zero(), 0, 3.0);
            teams[i].decide(0, arrival_s[i]);
          }
          EXPECT_NE(teams[0].leads(), teams[1].leads()) << first_s << " " << second_s << " " << first_led << second_led;
        }
      }
    }
  }
}

TEST(ChaseTeam, IgnoresVehiclesOnOtherTargets) {
  Team here;
  here.receives(kOther, Status::kLeads, 1.0, {5, 0, 10}, {0, 2, 0}, {4, 0, 10});
  EXPECT_TRUE(here.leads(5.0));
  for (const Status status : {Status::kIdle, Status::kSearches, Status::kCaptured}) {
    here.receives(kOther, status, 1.0);
    EXPECT_TRUE(here.leads(5.0)) << static_cast<int>(status);
  }
}

TEST(ChaseTeam, ForgetsSilentVehicles) {
  Team here;
  here.receives(kOther, Status::kLeads, 1.0);
  here.wait(0.9);
  EXPECT_FALSE(here.leads(5.0));
  EXPECT_EQ(here.moving_obstacles().size(), 1U);
  here.wait(0.2);
  EXPECT_TRUE(here.leads(5.0));
  EXPECT_TRUE(here.moving_obstacles().empty());
  EXPECT_EQ(here.team.chasing({50, 0, 0}, here.observation.t), nullptr);
}

TEST(ChaseTeam, IgnoresOldAndFutureReports) {
  Team here;
  here.wait(1.0);
  const TimeNs earlier = here.observation.t - from_seconds(0.3);
  here.receives(kOther, Status::kLeads, 1.0);
  here.receives(kOther, Status::kIdle, 1.0, {5, 0, 10}, {0, 2, 0}, {0, 0, 10}, earlier);
  EXPECT_FALSE(here.leads(5.0));
  here.receives(kOther, Status::kIdle, 1.0, {5, 0, 10}, {0, 2, 0}, {0, 0, 10}, here.observation.t + 1);
  EXPECT_FALSE(here.leads(5.0));
}

TEST(ChaseTeam, IgnoresInvalidReportsAndForeignVehicles) {
  Team here;
  here.wait(5.0);
  ChaseReport good;
  good.t = here.observation.t;
  good.status = Status::kLeads;
  good.target_world_m = {0, 0, 10};
  good.interval_s = 0.5;
  good.places.resize(2);
  const auto hears = [&](const ChaseReport& report, VehicleId from) {
    Message message;
    message.from = from;
    write_message(report, message);
    here.observation.messages = {message};
    here.team.listen(here.observation, {});
    return !here.moving_obstacles().empty();
  };
  for (const VehicleId stranger : {-1, kSelf, 7}) EXPECT_FALSE(hears(good, stranger)) << stranger;
  std::vector<ChaseReport> bad(10, good);
  bad[0].interval_s = 0.0;
  bad[1].interval_s = -1.0;
  bad[2].interval_s = 1e-300;
  bad[3].interval_s = 1e300;
  bad[4].places.clear();
  bad[5].places[1].p_world_m.x() = 3e38F;
  bad[6].target_world_m.z() = -1e308;
  bad[7].target_world_mps.y() = 1e200;
  bad[8].arrival_s = -1e300;
  bad[9].t = std::numeric_limits<TimeNs>::min();
  for (std::size_t i = 0; i < bad.size(); ++i) EXPECT_FALSE(hears(bad[i], kOther)) << i;
  EXPECT_TRUE(here.leads(5.0));
  EXPECT_TRUE(hears(good, kOther));
}

TEST(ChaseTeam, TruncatesReportsWithTooManyPlaces) {
  Team here;
  ChaseReport report;
  report.interval_s = 0.1;
  for (int i = 0; i < 40; ++i) report.places.push_back({Eigen::Vector3f(static_cast<float>(i), 0, 0)});
  Message message;
  message.from = kOther;
  write_message(report, message);
  here.observation.messages = {message};
  here.team.listen(here.observation, {});
  ASSERT_EQ(here.moving_obstacles().size(), 1U);
  EXPECT_NEAR(here.moving_obstacles()[0].at(2.0).x(), 20.0, 1e-6)
      << "prediction beyond the places that fit into a message";
}

TEST(ChaseTeam, YieldingVehiclesPlanWithMoreClearance) {
  Team here;
  here.receives(kOther, Status::kYields, 2.0);
  ASSERT_TRUE(here.leads(1.0));
  EXPECT_LT(here.moving_obstacles()[0].radius_m, 3.0);
  EXPECT_EQ(here.moving_obstacles()[0].plan_room_m, 0.0);
  here.receives(kOther, Status::kLeads, 2.0);
  here.receives(kThird, Status::kYields, 5.0);
  ASSERT_FALSE(here.leads(3.0));
  const std::vector<MovingObstacle> all = here.moving_obstacles();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].radius_m, 3.0);
  EXPECT_EQ(all[0].plan_room_m, 0.0) << "the third one does not lead";
  EXPECT_EQ(all[1].radius_m, 3.0);
  EXPECT_EQ(all[1].plan_room_m, 3.0);
  for (const Status inactive : {Status::kIdle, Status::kCaptured}) {
    Team other;
    other.receives(kOther, inactive, 2.0);
    ASSERT_TRUE(other.leads(1.0));
    EXPECT_EQ(other.moving_obstacles()[0].radius_m, 3.0) << "an inactive vehicle does not yield";
  }
}

TEST(ChaseTeam, ShiftsReportedPathsToObservedPositions) {
  Team here;
  here.receives(kOther, Status::kYields, 2.0);
  here.wait(0.5);
  std::vector<Track> tracks(1);
  tracks[0].id = 4;
  tracks[0].t = here.observation.t;
  tracks[0].position_m = {5.5, 1.0, 10.0};  // its report gives (5, 1, 10)
  here.team.recognize(tracks, 7);
  EXPECT_TRUE(here.team.is_teammate(4));
  const MovingObstacle other = here.moving_obstacles()[0];
  EXPECT_NEAR((other.at(0.0) - Vector3(5.5, 1.0, 10.0)).norm(), 0.0, 1e-6);
  EXPECT_NEAR((other.at(0.5) - Vector3(5.5, 2.0, 10.0)).norm(), 0.0, 1e-6);
  EXPECT_NEAR((other.velocity_mps(0.5) - Vector3(0, 2, 0)).norm(), 0.0, 1e-6);
}

// A teammate that is about to catch the target hangs its net over it.
TEST(ChaseTeam, DistinguishesTeammatesFromTheirNettedTargets) {
  Team here;
  here.receives(kOther, Status::kLeads, 0.1);
  std::vector<Track> tracks(1);
  tracks[0].id = 7;
  tracks[0].position_m = {5.0, 0.0, 8.4};
  here.team.recognize(tracks, 7);
  EXPECT_FALSE(here.team.is_teammate(7));
  tracks[0].position_m.z() = 9.5;
  here.team.recognize(tracks, 7);
  EXPECT_TRUE(here.team.is_teammate(7)) << "two bodies are not that near";
  tracks.push_back(tracks[0]);
  tracks[1].id = 8;
  tracks[1].position_m.z() = 9.9;
  here.team.recognize(tracks, 7);
  EXPECT_TRUE(here.team.is_teammate(8)) << "the nearest track is the teammate";
  EXPECT_FALSE(here.team.is_teammate(7));
}

TEST(ChaseTeam, AcceptsReportOfItsCapturedTarget) {
  Team here;
  here.receives(kOther, Status::kCaptured, 0.0);
  EXPECT_FALSE(here.team.has_captured()) << "the target is unknown";
  here.receives(kOther, Status::kYields, 1.0);
  here.receives(kOther, Status::kCaptured, 0.0);
  EXPECT_TRUE(here.team.has_captured());
}

TEST(ChaseTeam, IgnoresReportsThatTargetItself) {
  Team here;
  here.receives(kOther, Status::kLeads, 1.0);
  EXPECT_EQ(here.team.chasing({1, 0, 10}, here.observation.t), nullptr);
  EXPECT_NE(here.team.chasing({4, 0, 10}, here.observation.t), nullptr);
}

TEST(ChaseTeam, ReportsSurviveTheRoundTrip) {
  ChaseTeam team(0, 2);
  PathAhead path;
  path.num_places = 2;
  path.places_local_m[0] = {1, 2, 3};
  path.places_local_m[1] = {1.5, 2, 3};
  Outbox outbox(0);
  ASSERT_TRUE(team.is_report_due(0));
  team.report(Status::kYields, 0, 1.25, {{4, 5, 6}, {1, 0, 0}, {0, 0, 0}}, path, {}, outbox);
  EXPECT_FALSE(team.is_report_due(from_seconds(0.05)));
  EXPECT_TRUE(team.is_report_due(from_seconds(0.11)));
  ASSERT_EQ(outbox.messages().size(), 1U);
  Observation observation;
  observation.messages = outbox.messages();
  ChaseTeam other(1, 2);
  other.listen(observation, {});
  ASSERT_NE(other.chasing({50, 0, 0}, 0), nullptr);
  const Teammate& teammate = *other.chasing({50, 0, 0}, 0);
  EXPECT_EQ(teammate.arrival_s, 1.25);
  EXPECT_TRUE(teammate.at(from_seconds(0.25)).isApprox(Vector3(1.5, 2, 3)));
  EXPECT_TRUE(teammate.target_at(from_seconds(2.0)).p_m.isApprox(Vector3(6, 5, 6)));
}

}  // namespace
}  // namespace swiftlet
