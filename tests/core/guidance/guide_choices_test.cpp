// SPDX-License-Identifier: BSD-3-Clause
// Decisions of the guide within its states: goals, planning ahead, replanning when the map changes, and path messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/guidance/guiding/guide_constants.hpp"
#include "tests/core/guidance/guide_support.hpp"

namespace swiftlet {
namespace {

using testing::guides_uav2;
using testing::place_at_viewpoint;
using GuidePair = testing::GuideAndGuided;
using Motion = GuideConfig::Motion;

/// Note of the guide while it replans its own path.
constexpr const char* kOwnPathBlocked = "replanning: the path to the viewpoint is blocked";

GuideConfig config_with_motion(Motion motion, std::vector<Eigen::Vector3d> goals_m) {
  GuideConfig config = guides_uav2(std::move(goals_m));
  config.motion = motion;
  return config;
}

/// Corners of the path in the guide's line overlay `name`, whose positions are the two ends of each segment.
std::vector<Vector3> shown_path(const GuidePair& pair, const std::string& name) {
  std::vector<Overlay> overlays;
  pair.guidance->append_overlays(overlays);
  std::vector<Vector3> corners_local_m;
  for (const Overlay& overlay : overlays) {
    if (overlay.name != name) continue;
    for (std::size_t i = 0; i < overlay.positions.size(); ++i) {
      if (i == 0 || i % 2 == 1) corners_local_m.push_back(overlay.positions[i].cast<double>());
    }
  }
  return corners_local_m;
}

std::size_t num_with_waypoints(const std::vector<GuidingPath>& paths) {
  return static_cast<std::size_t>(
      std::count_if(paths.begin(), paths.end(), [](const GuidingPath& path) { return !path.waypoints.empty(); }));
}

TEST(GuideChoices, RequiresMapAndRelativeLocalizer) {
  const GuidePair pair(guides_uav2({{4, 0, 0.7}}));
  EXPECT_TRUE(pair.guidance->needs().map);
  EXPECT_TRUE(pair.guidance->needs().relatives);
}

TEST(GuideChoices, IdlesForeverWithoutAnyGoal) {
  for (const bool localized : {true, false}) {
    GuideConfig config = guides_uav2({});
    config.stage_timeout_s = 1.0;
    GuidePair pair(config);
    pair.guided.localized = localized;
    testing::hold_for(pair, 2.0);
    EXPECT_STREQ(pair.out.note, localized ? "idle: no goal" : "idle: the guided vehicle is not localized yet");
    EXPECT_EQ(pair.out.mission, MissionStatus::kEndless);
    const std::vector<GuidingPath> paths = sent_paths(pair);
    EXPECT_EQ(paths.empty(), !localized);
    EXPECT_EQ(num_with_waypoints(paths), 0U);
  }
}

TEST(GuideChoices, StaysCompletedAfterStageTimeout) {
  GuideConfig config = guides_uav2({{1, 0, 0.7}});
  config.stage_timeout_s = 3.0;
  GuidePair pair(config);
  place_at_viewpoint(pair);
  fly_to(pair, 1.0);
  hold_for(pair, 4.0);
  EXPECT_EQ(pair.out.mission, MissionStatus::kDone);
  EXPECT_STREQ(pair.out.note, "goal reached");
  EXPECT_EQ(newest(pair).command, GuidingPath::Command::kDone);
}

// ---- goals

TEST(GuideChoices, RetriesTheSameGoal) {
  GuideConfig config = guides_uav2({});
  config.advance.step_m = {4, 0, 0};
  config.stage_timeout_s = 3.0;
  GuidePair pair(config);
  place_at_viewpoint(pair);
  fly_to(pair, 1.0);
  hold_until(pair, "the guided vehicle does not reach its goal", 4.0);
  hold_for(pair, GuideConstants::kRetryAfter_s + config.settle_s + 0.3);
  EXPECT_EQ(pair.counter().of, 2U);
  const std::vector<Vector3> path_local_m = shown_path(pair, "guide.secondary_path");
  ASSERT_FALSE(path_local_m.empty());
  EXPECT_LT((path_local_m.front() - Vector3(1, 0, 0.7)).norm(), 1e-5) << "the new plan starts at the guided vehicle";
  EXPECT_LT((path_local_m.back() - Vector3(4, 0, 0.7)).norm(), 1e-5);
}

TEST(GuideChoices, AdvancesFromStartAndClimbsOnce) {
  for (const Motion motion : {Motion::kAlternate, Motion::kAhead}) {
    GuideConfig config = config_with_motion(motion, {});
    config.advance.step_m = {2, 0, 0.1};
    config.advance.distance_m = 3.9;
    GuidePair pair(config, testing::CellListMap(0.25), {-1, -1, 0.7}, {3, 2, 0.7});
    pair.run(60.0);
    EXPECT_EQ(pair.out.mission, MissionStatus::kDone);
    EXPECT_LT((pair.guided.position_m - Vector3(7, 2, 0.8)).norm(), 0.15) << pair.guided.position_m.transpose();
    EXPECT_EQ(pair.counter().of, 2U) << "one plan per leg";
    EXPECT_EQ(pair.notes["planning"] < 3.0, motion == Motion::kAhead);
  }
}

// ---- planning ahead

TEST(GuideChoices, PlansEachLegAheadOnce) {
  for (const bool loop : {false, true}) {
    GuideConfig config = config_with_motion(Motion::kAhead, {{2, 0, 0.7}, {0, 0, 0.7}});
    config.loop = loop;
    GuidePair pair(config);
    pair.run(40.0);
    EXPECT_EQ(pair.out.mission, loop ? MissionStatus::kRunning : MissionStatus::kDone);
    EXPECT_EQ(pair.counter().of > 3U, loop);
    EXPECT_EQ(pair.counter().of == 2U, !loop);
    EXPECT_LT(pair.notes["planning"], 3.0) << "both hover only before the first leg";
  }
}

TEST(GuideChoices, LeavesViewpointThatIsNextGoal) {
  // On a square route, the viewpoint of one leg is near the goal of the next.
  const std::vector<Eigen::Vector3d> goals_m = {{3, 0, 0.7}, {3, 3, 0.7}, {0, 3, 0.7}};
  for (const Motion motion : {Motion::kAlternate, Motion::kAhead, Motion::kTogether}) {
    GuideConfig config = config_with_motion(motion, goals_m);
    config.loop = true;
    GuidePair pair(config);
    std::size_t num_reached = 0;
    double least_separation_m = 10.0;
    for (int i = 0; i < 1500 && pair.out.mission == MissionStatus::kRunning; ++i) {
      pair.tick();
      least_separation_m = std::min(least_separation_m, (pair.p_m() - pair.guided.position_m).head<2>().norm());
      if ((pair.guided.position_m - goals_m[num_reached % 3]).norm() < 0.3) ++num_reached;
    }
    EXPECT_EQ(pair.out.mission, MissionStatus::kRunning) << pair.out.note;
    EXPECT_GT(num_reached, 6U) << "more than two rounds";
    EXPECT_GT(least_separation_m, 1.3);
  }
}

TEST(GuideChoices, ReportsFailedPlanAheadAtGoal) {
  testing::CellListMap world(0.25);
  world.occupy_box({3.25, 3.25, 0}, {4.75, 4.75, 1.5});
  GuideConfig config = config_with_motion(Motion::kAhead, {{4, 0, 0.7}, {4, 4, 0.7}});
  config.retries = 0;
  GuidePair pair(config, world);
  pair.run_until("goal reached", 60.0);
  EXPECT_EQ(pair.counter().of, 2U);
  pair.run_until("planning", 1.0);
  EXPECT_STREQ(pair.out.note, "planning");
  pair.run(10.0);
  EXPECT_EQ(pair.out.mission, MissionStatus::kFailed);
  EXPECT_STREQ(pair.out.note, "the guided vehicle's path: the goal is too near to an obstacle");
  EXPECT_EQ(pair.counter().of, 3U);
}

// ---- replanning when the map changes

/// The guide starts behind a short wall, so that its path to the viewpoint has a corner.
struct BehindAWall : GuidePair {
  explicit BehindAWall() : GuidePair(guides_uav2({{4, 0, 0.7}}), wall(), {-5, 0, 0.7}) {
    hold_until(*this, "primary moving", 5.0);
    corners_local_m = shown_path(*this, "guide.primary_path");
  }
  static testing::CellListMap wall() {
    testing::CellListMap world(0.25);
    world.occupy_box({-3.0, -1.5, 0.0}, {-2.75, 1.5, 1.5});
    return world;
  }
  std::vector<Vector3> corners_local_m;
};

TEST(GuideChoices, ReplansWhenRemainingPathIsBlocked) {
  for (const bool blocks_last_leg : {false, true}) {
    BehindAWall pair;
    ASSERT_GE(pair.corners_local_m.size(), 3U);
    pair.hold();
    pair.put(pair.corners_local_m[1]);
    hold_for(pair, 0.2);
    const std::size_t last = pair.corners_local_m.size() - 1;
    pair.discover_around(blocks_last_leg ? Vector3(0.5 * (pair.corners_local_m[last - 1] + pair.corners_local_m[last]))
                                         : pair.corners_local_m[0]);
    pair.hold();
    EXPECT_STREQ(pair.out.note, blocks_last_leg ? kOwnPathBlocked : "primary moving");
    EXPECT_EQ(pair.out.goal.position_m == pair.p_m(), blocks_last_leg) << "the guide stops at its position";
  }
  BehindAWall pair;
  const std::size_t last = pair.corners_local_m.size() - 1;
  pair.discover_around(0.5 * (pair.corners_local_m[last - 1] + pair.corners_local_m[last]));
  pair.hold();
  EXPECT_STREQ(pair.out.note, kOwnPathBlocked) << "a blocked later leg also causes replanning";
}

// ---- path messages

TEST(GuideChoices, SendsLastWaypointUntilGuidedHovers) {
  GuidePair pair(guides_uav2({{4, 0, 0.7}}));
  place_at_viewpoint(pair);
  fly_to(pair, 4.0);
  hold_for(pair, 0.4, 0.0, 1.0);
  EXPECT_STREQ(pair.out.note, "secondary moving");
  EXPECT_EQ(newest(pair).waypoints.size(), 1U);
}

TEST(GuideChoices, ResendsOneTimePathAfterHovering) {
  GuideConfig config = guides_uav2({{4, 0, 0.7}});
  config.periodic = false;
  GuidePair pair(config);
  hold_until(pair, "primary moving", 5.0);
  for (int i = 0; i < 20 && pair.out.note == std::string("primary moving"); ++i) {
    pair.hold();
    pair.put(pair.out.goal.position_m);
  }
  hold_for(pair, 1.0);
  ASSERT_STREQ(pair.out.note, "secondary moving");
  const std::vector<GuidingPath> first = sent_paths(pair);
  EXPECT_EQ(num_with_waypoints(first), 1U);
  EXPECT_FALSE(first.back().waypoints.empty()) << "no message follows the path";
  pair.hears = false;
  hold_for(pair, 2.0);
  const std::vector<GuidingPath> lost = sent_paths(pair);
  EXPECT_GE(lost.size(), 2U) << "the command to hover is repeated";
  EXPECT_EQ(num_with_waypoints(lost), 0U);
  pair.hears = true;
  hold_for(pair, 1.0);
  EXPECT_EQ(num_with_waypoints(sent_paths(pair)), 1U);
}

}  // namespace
}  // namespace swiftlet
