// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "swiftlet/core/interception/intercept.hpp"
#include "tests/core/interception/hunt.hpp"

namespace swiftlet {
namespace {

using testing::Hunt;

/// True if guidance has reported this note so far.
bool noted(const Hunt& hunt, const char* note) {
  return std::find(hunt.notes.begin(), hunt.notes.end(), note) != hunt.notes.end();
}

constexpr const char* kLost = "target lost: searching";

TEST(InterceptDecisions, ChasesTheNearestTrack) {
  for (const double sign : {-1.0, 1.0}) {
    Hunt hunt({}, {0.0, 0.0, 12.0});
    hunt.run(1.5, [&](double, Hunt& h) {
      h.sees({sign * 15.0, 0.0, 12.0}, Vector3::Zero(), 7);
      h.sees_also({-sign * 25.0, 0.0, 12.0}, Vector3::Zero(), 8);
      if (sign > 0.0) std::swap(h.tracks[0], h.tracks[1]);
    });
    EXPECT_GT(sign * hunt.p_m().x(), 1.0);
  }
}

TEST(InterceptDecisions, AcceptsOnlyTracksNearThePrediction) {
  for (const double off_m : {2.0, 4.0}) {
    Hunt hunt({}, {-25.0, 0.0, 12.0});
    hunt.run(1.0, [](double t_s, Hunt& h) { h.sees({10.0, 5.0 * t_s, 12.0}, {0.0, 5.0, 0.0}, 7); });
    hunt.run(0.5, [&](double t_s, Hunt& h) { h.sees({10.0 + off_m, 5.0 * t_s, 12.0}, {0.0, 5.0, 0.0}, 8); });
    EXPECT_EQ(noted(hunt, kLost), off_m > 3.0) << off_m;
  }
}

TEST(InterceptDecisions, LosesATrackAfterItsTimeout) {
  Hunt hunt({}, {-25.0, 0.0, 12.0});
  hunt.run(1.0, [](double, Hunt& h) { h.sees({10.0, 0.0, 12.0}, Vector3::Zero()); });
  hunt.run(0.95);
  EXPECT_FALSE(noted(hunt, kLost));
  hunt.run(0.1);
  EXPECT_TRUE(noted(hunt, kLost));
}

TEST(InterceptDecisions, ReacquiringTheTargetRestartsFencePatience) {
  InterceptConfig config;
  config.fence.max_m.x() = 20.0;
  config.fence.patience_s = 1.0;
  Hunt hunt(config, {0.0, 0.0, 12.0});
  const auto outside = [](double, Hunt& h) { h.sees({22.0, 0.0, 12.0}, Vector3::Zero()); };
  hunt.run(0.9, outside);
  hunt.tracks.clear();
  hunt.run(0.1);
  ASSERT_TRUE(noted(hunt, kLost));
  hunt.run(0.9, outside);
  EXPECT_EQ(hunt.out.mission, MissionStatus::kRunning);
  hunt.run(0.3, outside);
  EXPECT_EQ(hunt.out.mission, MissionStatus::kFailed);
}

// The target drifts toward the fence from outside, so that the pursuit leads straight toward the fence.
TEST(InterceptDecisions, StaysInsideFenceForAnyPeriod) {
  for (const double period_s : {0.02, 0.3, 1.0}) {
    InterceptConfig config;
    config.method = InterceptConfig::Method::kPurePursuit;
    config.period_s = period_s;
    config.fence.max_m.x() = 0.0;
    config.fence.patience_s = 100.0;
    double farthest_m = -20.0;
    Hunt hunt(config, {farthest_m, 0.0, 12.0});
    hunt.run(15.0, [&](double, Hunt& h) {
      h.sees({5.0 - 0.3 * h.now_s(), 0.0, 12.0}, {-0.3, 0.0, 0.0});
      farthest_m = std::max(farthest_m, h.p_m().x());
    });
    EXPECT_LT(farthest_m, 0.1) << "leaves the fence with a planning period of " << period_s << " s";
    EXPECT_GT(farthest_m, -8.0) << "does not pursue with a planning period of " << period_s << " s";
  }
}

TEST(InterceptDecisions, FacesItsTarget) {
  Hunt hunt({}, {0.0, 0.0, 12.0});
  hunt.run(3.0, [](double, Hunt& h) { h.sees({-20.0, -30.0, 12.0}, Vector3::Zero()); });
  const Vector3 to_target_m = Vector3(-20.0, -30.0, 12.0) - hunt.p_m();
  EXPECT_NEAR(
      std::remainder(hunt.out.goal.yaw_rad - std::atan2(to_target_m.y(), to_target_m.x()), 2.0 * std::acos(-1.0)), 0.0,
      0.1);
}

/// Result of an approach to a hovering target.
struct Approach {
  bool captured = false;
  double least_m = 1e9;  // least distance from the target until its capture
};

/// Approaches a hovering target for at most 20 s. The target is far from the origin, so that a position that is used as
/// a displacement fails the test.
/// @param start_from_target_m  start of the vehicle relative to the target
Approach approach(const InterceptConfig& config, const Vector3& start_from_target_m) {
  const Vector3 target_m(30.0, -20.0, 15.0);
  Hunt hunt(config, target_m + start_from_target_m);
  Approach result;
  for (int i = 0; i < 200 && hunt.out.mission == MissionStatus::kRunning; ++i) {
    hunt.run(0.1, [&](double, Hunt& h) {
      h.sees(target_m, Vector3::Zero());
      if (h.out.mission == MissionStatus::kRunning)
        result.least_m = std::min(result.least_m, (h.p_m() - target_m).norm());
    });
  }
  result.captured = hunt.out.mission == MissionStatus::kDone;
  return result;
}

TEST(InterceptDecisions, KeepsTargetClearanceDuringApproach) {
  for (const Vector3& start_m : {Vector3(-12, 0, -7), Vector3(0, 0, -9), Vector3(9, -9, 0), Vector3(3, 20, 10)}) {
    InterceptConfig config;
    const Approach result = approach(config, start_m);
    EXPECT_TRUE(result.captured) << start_m.transpose();
    EXPECT_GT(result.least_m, 0.9 * config.target_clearance_m) << start_m.transpose();
  }
}

TEST(InterceptDecisions, CapturesTargetWithAnyNetOffset) {
  for (const Vector3& offset_m : {Vector3(0, 0, -1.2), Vector3(1.0, 0.5, -1.5), Vector3(-0.8, 0, -1.2)}) {
    InterceptConfig config;
    config.net.offset_m = offset_m;
    EXPECT_TRUE(approach(config, {-14.0, 6.0, 2.0}).captured) << offset_m.transpose();
  }
}

TEST(InterceptDecisions, ClimbsToFenceTopWhenDone) {
  InterceptConfig config;
  config.fence.max_m.z() = 30.0;
  Hunt hunt(config, {-14.0, 0.0, 17.0});
  const auto hovering = [](double, Hunt& h) { h.sees({0.0, 0.0, 15.0}, Vector3::Zero()); };
  hunt.run(12.0, hovering);
  ASSERT_EQ(hunt.out.mission, MissionStatus::kDone);
  hunt.run(10.0, hovering);
  EXPECT_EQ(hunt.out.mission, MissionStatus::kDone);
  EXPECT_NEAR(hunt.p_m().z(), 30.0, 0.1);
  EXPECT_LT((hunt.p_m().head<2>() - Vector3(-14.0, 0.0, 0.0).head<2>()).norm(), 0.2) << "climbs above its start";
}

TEST(InterceptDecisions, RepeatsCapturesWithoutACaptureLimit) {
  InterceptConfig config;
  config.captures = 0;
  Hunt hunt(config, {-14.0, 0.0, 17.0});
  double farthest_m = 0.0;
  hunt.run(30.0, [&](double, Hunt& h) {
    h.sees({0.0, 0.0, 15.0}, Vector3::Zero());
    if (noted(h, "captured")) farthest_m = std::max(farthest_m, (h.p_m() - Vector3(0.0, 0.0, 16.2)).norm());
  });
  EXPECT_EQ(hunt.out.mission, MissionStatus::kRunning);
  EXPECT_GE(std::count(hunt.notes.begin(), hunt.notes.end(), "captured"), 2);
  EXPECT_GT(farthest_m, config.net.rearm_m) << "retreats beyond the distance at which the net is armed again";
  EXPECT_LT(farthest_m, 25.0);
}

TEST(InterceptDecisions, EndsAfterConfiguredCaptures) {
  InterceptConfig config;
  config.captures = 2;
  Hunt hunt(config, {-14.0, 0.0, 17.0});
  double first_capture_s = 0.0;
  const auto hovering = [&](double t_s, Hunt& h) {
    h.sees({0.0, 0.0, 15.0}, Vector3::Zero());
    if (first_capture_s == 0.0 && noted(h, "captured")) first_capture_s = t_s;
  };
  while (hunt.out.mission == MissionStatus::kRunning && hunt.now_s() < 60.0) hunt.run(0.2, hovering);
  EXPECT_EQ(hunt.out.mission, MissionStatus::kDone);
  EXPECT_GT(hunt.now_s(), first_capture_s + 1.0);
}

}  // namespace
}  // namespace swiftlet
