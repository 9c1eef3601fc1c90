// SPDX-License-Identifier: BSD-3-Clause
// One vehicle on paths through its own map; the test moves it to its goals.
#include "swiftlet/core/guidance/navigate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "tests/core/guidance/guidance_driver.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using testing::CellListMap;
using testing::GuidanceDriver;

/// A map that changes by another one.
class ChangingMap : public CellListMap {
 public:
  using CellListMap::CellListMap;
  std::uint64_t revision() const override { return now; }
  std::uint64_t now = 1;
};

NavigateConfig flies_to(std::vector<Eigen::Vector3d> goals_m) {
  NavigateConfig config;
  config.goals_m = std::move(goals_m);
  config.planner.clearance_m = 0.5;
  config.planner.z_min_m = 0.6;
  config.planner.z_max_m = 0.9;
  config.planner.max_expansions = 4000;
  config.retries = 1;
  return config;
}

struct Pilot : GuidanceDriver {
  explicit Pilot(const NavigateConfig& config) : GuidanceDriver("navigate", config, {0, 0, 0.7}) { map = &world; }
  void tick() {
    step();
    notes.insert(out.note);
    approach();
    least_m = std::min(least_m, world.distance_m(p_m(), 10.0));
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / dt_s) && out.mission == MissionStatus::kRunning; ++i) tick();
  }
  ChangingMap world{0.25};
  std::set<std::string> notes;
  double least_m = 10.0;
};

TEST(Navigate, ReplansWhenItsPathIsBlocked) {
  Pilot pilot(flies_to({{6, 0, 0.7}}));
  while (pilot.p_m().x() < 1.0) pilot.tick();
  pilot.world.occupy_box({4.0, -2.0, 0.0}, {4.25, 2.0, 1.5});
  pilot.world.now = 2;
  pilot.run(60.0);
  EXPECT_EQ(pilot.out.mission, MissionStatus::kDone);
  EXPECT_GT(pilot.least_m, 0.3);
}

TEST(Navigate, FailsForGoalInsideAnObstacle) {
  Pilot pilot(flies_to({{4, 0, 0.7}}));
  pilot.world.occupy_box({3, -1, 0}, {5, 1, 1.5});
  pilot.run(60.0);
  EXPECT_EQ(pilot.out.mission, MissionStatus::kFailed);
  EXPECT_STREQ(pilot.out.note, "the goal is too near to an obstacle");
}

TEST(Navigate, CountsAbandonedSearchesAndNamesBudget) {
  NavigateConfig config = flies_to({{6, 0, 0.7}});
  const auto counted = [](const NavigateConfig& flown) {
    Pilot pilot(flown);
    pilot.world.occupy_box({2.0, -2.0, 0.0}, {2.25, 6.0, 1.5});
    pilot.run(60.0);
    EXPECT_EQ(pilot.out.mission == MissionStatus::kDone, pilot.counter().count == 0U);
    return pilot.counter();
  };
  EXPECT_EQ(counted(config).count, 0U);
  for (const bool sampled : {false, true}) {
    config.search = sampled ? NavigateConfig::Search::kRrt : NavigateConfig::Search::kAStar;
    config.planner.max_expansions = 10;
    config.sampling.max_samples = 1;
    const Counter abandoned = counted(config);
    EXPECT_EQ(abandoned.count, 2U) << "once, and one retry";
    EXPECT_EQ(abandoned.of, 2U);
    EXPECT_EQ(abandoned.setting, sampled ? "sampling.max_samples" : "planner.max_expansions");
  }
}

TEST(Navigate, EverySearchAndFollowerAvoidsWall) {
  using Search = NavigateConfig::Search;
  using Follow = NavigateConfig::Follow;
  for (const Search search : {Search::kAStar, Search::kRrt, Search::kInformedRrtStar}) {
    for (const Follow follow : {Follow::kCorners, Follow::kTimed}) {
      NavigateConfig config = flies_to({{4, 0, 0.7}, {0, 0, 0.7}});
      config.search = search;
      config.follow = follow;
      Pilot pilot(config);
      pilot.world.occupy_box({2.0, -2.0, 0.0}, {2.25, 6.0, 1.5});
      pilot.run(90.0);
      EXPECT_EQ(pilot.out.mission, MissionStatus::kDone) << static_cast<int>(search) << static_cast<int>(follow);
      EXPECT_LT((pilot.p_m() - Vector3(0, 0, 0.7)).norm(), 0.3);
      EXPECT_GT(pilot.least_m, 0.3);
    }
  }
}

TEST(Navigate, FliesTimedPathWithoutCornerStops) {
  NavigateConfig config = flies_to({{5, 0, 0.7}});
  Pilot pilot(config);
  pilot.world.occupy_box({2.0, -2.0, 0.0}, {2.25, 6.0, 1.5});
  double fastest_mps = 0.0, slowest_between_mps = 10.0;
  while (pilot.out.mission == MissionStatus::kRunning) {
    pilot.tick();
    const double speed_mps = pilot.out.goal.velocity_mps.norm();
    fastest_mps = std::max(fastest_mps, speed_mps);
    const bool between = pilot.p_m().x() > 1.0 && pilot.p_m().x() < 4.0;
    if (between) slowest_between_mps = std::min(slowest_between_mps, speed_mps);
  }
  EXPECT_EQ(pilot.out.mission, MissionStatus::kDone);
  EXPECT_LE(fastest_mps, config.speed_mps + 0.01);
  EXPECT_GT(slowest_between_mps, 0.3);
}

TEST(Navigate, PathClockWaitsForDelayedVehicle) {
  Pilot pilot(flies_to({{6, 0, 0.7}}));
  while (pilot.p_m().x() < 1.0) pilot.tick();
  const Vector3 held_m = pilot.p_m();
  for (int i = 0; i < 1000; ++i) {
    pilot.step();
    pilot.put(held_m);
  }
  EXPECT_LT((pilot.out.goal.position_m - held_m).norm(), 0.8);
}

TEST(Navigate, RepeatsToursAsConfiguredOrForever) {
  const auto visits_in = [](int rounds, double seconds) {
    NavigateConfig config = flies_to({{2, 0, 0.7}, {0, 0, 0.7}});
    config.rounds = rounds;
    Pilot pilot(config);
    int visits = 0;
    bool was_there = false;
    for (int i = 0; i < static_cast<int>(seconds / pilot.dt_s) && pilot.out.mission == MissionStatus::kRunning; ++i) {
      pilot.tick();
      const bool there = (pilot.p_m() - Vector3(2, 0, 0.7)).norm() < 0.3;
      visits += there && !was_there;
      was_there = there;
    }
    return std::pair(visits, pilot.out.mission);
  };
  EXPECT_EQ(visits_in(1, 300.0), std::pair(1, MissionStatus::kDone));
  EXPECT_EQ(visits_in(3, 300.0), std::pair(3, MissionStatus::kDone));
  const auto [visits, mission] = visits_in(0, 300.0);
  EXPECT_GT(visits, 20);
  EXPECT_EQ(mission, MissionStatus::kRunning);
}

TEST(Navigate, HoversWithoutGoals) {
  Pilot pilot(flies_to({}));
  pilot.run(3.0);
  EXPECT_EQ(pilot.out.mission, MissionStatus::kEndless);
  EXPECT_LT(pilot.p_m().x(), 1e-9);
}

TEST(Navigate, DrawsItsPathOnceOneExists) {
  Pilot pilot(flies_to({{4, 0, 0.7}}));
  std::vector<Overlay> overlays;
  pilot.guidance->append_overlays(overlays);
  EXPECT_TRUE(overlays.empty());
  while (pilot.out.note != std::string("flying to the goal")) pilot.tick();
  pilot.guidance->append_overlays(overlays);
  ASSERT_EQ(overlays.size(), 1U);
  EXPECT_EQ(overlays[0].kind, Overlay::Kind::kPolyline);
  EXPECT_LT((overlays[0].positions.back() - Eigen::Vector3f(4, 0, 0.7F)).norm(), 0.3F);
}

TEST(Navigate, FailsWithoutReachingHoverOrGoal) {
  NavigateConfig config = flies_to({{4, 0, 0.7}});
  config.stage_timeout_s = 2.0;
  config.retry_after_s = 1.0;
  for (const bool rests : {true, false}) {
    Pilot pilot(config);
    for (int i = 0; i < 100; ++i) {  // the position stays constant
      pilot.estimate.v_local_mps = {0.0, rests ? 0.0 : 1.0, 0.0};
      pilot.step();
      EXPECT_EQ(pilot.out.speed_limit_mps, config.speed_mps);
      EXPECT_TRUE(pilot.out.mission == MissionStatus::kRunning || i > 45)
          << "the mission fails only after two attempts";
    }
    EXPECT_EQ(pilot.out.mission, MissionStatus::kFailed);
    EXPECT_STREQ(pilot.out.note, rests ? "the vehicle does not reach its goal" : "the vehicle does not come to rest");
  }
}

}  // namespace
}  // namespace swiftlet
