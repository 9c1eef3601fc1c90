// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/interception/intercept.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "swiftlet/core/stage_tables/guidances.hpp"
#include "tests/core/interception/hunt.hpp"
#include "tests/core/planning/cell_list_map.hpp"

namespace swiftlet {
namespace {

using testing::circling;
using testing::Hunt;
using testing::kFast;

TEST(Intercept, CatchesTargetsOnKnownPaths) {
  for (const auto method : {InterceptConfig::Method::kMpc, InterceptConfig::Method::kFrpn,
                            InterceptConfig::Method::kProportionalNavigation}) {
    InterceptConfig config;
    config.method = method;
    Hunt hunt(config, {-20.0, 0.0, 12.0});
    hunt.run(25.0, circling);
    EXPECT_EQ(hunt.out.mission, MissionStatus::kDone) << static_cast<int>(method);
    EXPECT_EQ(hunt.notes.back(), "captured");
  }
}

/// Time at which the vehicle reports the capture of the circling target; 60 s: no capture.
double time_to_capture_s(InterceptConfig::Method method) {
  InterceptConfig config;
  config.method = method;
  Hunt hunt(config, {-25.0, 0.0, 16.2});
  while (hunt.out.mission == MissionStatus::kRunning && hunt.now_s() < 60.0) {
    hunt.run(0.1, circling);
  }
  return hunt.now_s();
}

TEST(Intercept, OutperformsPursuitAndProportionalNavigation) {
  const double mpc_s = time_to_capture_s(InterceptConfig::Method::kMpc);
  EXPECT_LT(mpc_s, time_to_capture_s(InterceptConfig::Method::kProportionalNavigation));
  EXPECT_LT(mpc_s, time_to_capture_s(InterceptConfig::Method::kPurePursuit));
}

TEST(Intercept, WaitsForATarget) {
  Hunt hunt({}, {0.0, 0.0, 10.0});
  hunt.run(2.0);
  EXPECT_LT((hunt.p_m() - Vector3(0, 0, 10)).norm(), 1e-6);
  EXPECT_EQ(hunt.notes, std::vector<std::string>{"waiting for a target"});
}

TEST(Intercept, DrawsPredictionPlanAndSearchViews) {
  const auto shown = [](const Hunt& hunt) {
    std::vector<Overlay> overlays;
    hunt.guidance->append_overlays(overlays);
    std::set<std::string> names;
    for (const Overlay& overlay : overlays) names.insert(overlay.name);
    return names;
  };
  Hunt hunt({}, {-30.0, 0.0, 14.0});
  hunt.run(0.5);
  const std::set<std::string> waiting = shown(hunt);
  EXPECT_FALSE(waiting.contains("intercept.prediction") || waiting.contains("intercept.plan"));
  hunt.run(2.0, circling);
  const std::set<std::string> chasing = shown(hunt);
  EXPECT_TRUE(chasing.contains("intercept.prediction") && chasing.contains("intercept.plan"));
  hunt.tracks.clear();
  hunt.run(1.0);
  const std::set<std::string> searching = shown(hunt);
  EXPECT_FALSE(searching.contains("intercept.prediction"));
  EXPECT_EQ(searching.size(), waiting.size() + 1) << "where the target may be";
}

TEST(Intercept, AbandonsATargetOutsideTheFence) {
  InterceptConfig config;
  config.fence.max_m.x() = 20.0;
  config.fence.patience_s = 1.0;
  Hunt hunt(config, {0.0, 0.0, 10.0});
  double farthest_m = 0.0;
  hunt.run(20.0, [&](double t_s, Hunt& h) {
    h.sees({12.0 + 7.5 * t_s, 0.0, 10.0}, {7.5, 0.0, 0.0});
    farthest_m = std::max(farthest_m, h.p_m().x());
  });
  EXPECT_EQ(hunt.out.mission, MissionStatus::kFailed);
  EXPECT_EQ(hunt.notes.back(), "gave up: the target left the fence");
  EXPECT_LT(farthest_m, 20.1) << "the interceptor stays within the fence";
  EXPECT_LT((hunt.p_m() - Vector3(0, 0, 10)).norm(), 0.5) << "distance from the waiting position";
}

TEST(Intercept, SearchesForLostTargetAndResumes) {
  Hunt hunt({}, {-30.0, 0.0, 14.0});
  hunt.run(2.0, circling);
  hunt.tracks.clear();
  hunt.run(1.0);
  EXPECT_EQ(hunt.out.mission, MissionStatus::kRunning);
  EXPECT_EQ(hunt.notes.back(), "target lost: searching");
  hunt.run(20.0, [](double t_s, Hunt& h) {
    circling(t_s, h);
    h.tracks[0].id = 8;  // another track by now
  });
  EXPECT_EQ(hunt.out.mission, MissionStatus::kDone);
}

// An unseen track continues by its prediction, which does not count as a capture.
TEST(Intercept, RejectsCatchesOfLongUnmeasuredTargets) {
  InterceptConfig config;
  const auto blind = [](double t_s, Hunt& h) {
    circling(t_s, h);
    h.tracks[0].corrected = t_s < 0.5;
  };
  Hunt hunt(config, {-30.0, 0.0, 14.0});
  hunt.run(20.0, blind);
  EXPECT_EQ(hunt.out.mission, MissionStatus::kRunning);
  Hunt sees(config, {-30.0, 0.0, 14.0});
  sees.run(20.0, circling);
  EXPECT_EQ(sees.out.mission, MissionStatus::kDone);
}

TEST(Intercept, AbandonsATargetNeverFoundAgain) {
  InterceptConfig config;
  config.search.timeout_s = 5.0;
  Hunt hunt(config, {-30.0, 0.0, 14.0});
  hunt.run(2.0, circling);
  const Vector3 there_m = hunt.p_m();
  hunt.tracks.clear();
  hunt.run(4.0);
  EXPECT_LT((hunt.p_m() - Vector3(0, 0, 15)).norm(), (there_m - Vector3(0, 0, 15)).norm())
      << "the search approaches the expected position of the target";
  hunt.run(3.0);
  EXPECT_EQ(hunt.out.mission, MissionStatus::kFailed);
  EXPECT_EQ(hunt.notes.back(), "gave up: the target was not found again");
}

// A wall of cells stands between interceptor and target; the ground is the fence's.
TEST(Intercept, AvoidsEverythingInTheMap) {
  std::vector<Vector3> cells_m;
  for (int y = -25; y <= 25; ++y) {
    for (int z = 0; z < 60; ++z) cells_m.emplace_back(-6.0, 0.2 * y, 0.2 * z);
  }
  const testing::CellListMap wall(0.2, cells_m);
  for (const auto method : {InterceptConfig::Method::kMpc, InterceptConfig::Method::kPurePursuit}) {
    InterceptConfig config;
    config.method = method;
    config.walls = InterceptConfig::Walls::kMap;
    config.clearance_m = 1.5;
    Hunt hunt(config, {-14.0, 0.0, 6.0});
    hunt.map = &wall;
    double least_m = 10.0, lowest_m = 10.0;
    hunt.run(8.0, [&](double, Hunt& h) {
      h.sees({4.0, 0.0, 3.0}, Vector3::Zero());
      least_m = std::min(least_m, wall.distance_m(h.p_m(), 10.0));
      lowest_m = std::min(lowest_m, h.p_m().z());
    });
    EXPECT_GT(least_m, 1.4) << static_cast<int>(method);
    EXPECT_GT(lowest_m, config.fence.min_m.z() - 0.1);
  }
}

TEST(Intercept, KeepsClearOfABystander) {
  Hunt hunt({}, {-20.0, 0.3, 10.0});
  double least_m = 100.0;
  hunt.run(12.0, [&](double, Hunt& h) {
    const Vector3 bystander_m(-8.0, 0.0, 10.2);
    if (h.out.mission == MissionStatus::kRunning) least_m = std::min(least_m, (h.p_m() - bystander_m).norm());
    h.sees({6.0, 0.0, 9.0}, Vector3::Zero());
    if (h.now_s() >= 0.1) h.sees_also(bystander_m, Vector3::Zero(), 9);  // the target is the first track
  });
  EXPECT_EQ(hunt.out.mission, MissionStatus::kDone);
  EXPECT_GT(least_m, 2.7);
}

TEST(Intercept, RequiresNamedTargetToBeVehicle) {
  InterceptConfig config;
  config.target = "unknown";
  try {
    Hunt hunt(config, {0, 0, 10});
    FAIL() << "an unknown target is accepted";
  } catch (const std::invalid_argument& problem) {
    EXPECT_STREQ(problem.what(), "guidance intercept: target: expected the name of a vehicle, found 'unknown'");
  }
}

TEST(Intercept, NeedsAMapToAvoidWalls) {
  const AgentSetup agent;
  for (const auto walls : {InterceptConfig::Walls::kNone, InterceptConfig::Walls::kMap}) {
    Module module(guidance_module_types(), "intercept");
    module.as<InterceptConfig>().walls = walls;
    const GuidanceNeeds needs = make_guidance(module, {agent, kFast})->needs();
    EXPECT_EQ(needs.map, walls == InterceptConfig::Walls::kMap);
    EXPECT_TRUE(needs.track_modes);
  }
}

}  // namespace
}  // namespace swiftlet
