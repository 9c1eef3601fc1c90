// SPDX-License-Identifier: BSD-3-Clause
// Exploration of rooms that the test knows; the test reveals what is in sight.
#include "swiftlet/core/guidance/explore.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "tests/core/guidance/guidance_driver.hpp"
#include "tests/core/planning/box_map.hpp"

namespace swiftlet {
namespace {

using testing::BoxMap;
using testing::GuidanceDriver;

constexpr double kEdge_m = 0.25;
const Cell kSize(56, 24, 10);

/// Two rooms of 6 m, 6 m x 5.5 m x 2 m each, with an opening of 1.5 m; the second has a pillar. A third one is closed.
BoxMap rooms() {
  BoxMap map(kSize, kEdge_m);
  for (int z = 0; z < kSize.z(); ++z) {
    for (int y = 0; y < kSize.y(); ++y) {
      for (int x = 0; x < kSize.x(); ++x) {
        const bool border =
            x == 0 || y == 0 || z == 0 || x + 1 == kSize.x() || y + 1 == kSize.y() || z + 1 == kSize.z();
        const bool wall = x == 24 && (y < 9 || y >= 15), pillar = x >= 34 && x < 36 && y >= 10 && y < 14, far = x == 48;
        if (border || wall || pillar || far) map.at({x, y, z}) = CellState::kOccupied;
      }
    }
  }
  return map;
}

struct Explorer : GuidanceDriver {
  Explorer(const BoxMap& truth, const ExploreConfig& config, const Vector3& start_m)
      : GuidanceDriver("explore", config, start_m), truth(truth), known(kSize, kEdge_m) {
    for (std::ptrdiff_t i = 0; i < known.grid().num_cells(); ++i) known.at(known.grid().cell(i)) = CellState::kUnknown;
    map = &known;
  }
  void see() {
    constexpr int kRays = 2000;
    for (int i = 0; i < kRays; ++i) {
      const double up = -0.9 + 1.8 * (i + 0.5) / kRays, level = std::sqrt(1.0 - up * up);
      const Vector3 along(level * std::cos(2.39996323 * i), level * std::sin(2.39996323 * i), up);
      for (double range_m = 0.0; range_m < 8.0; range_m += 0.1) {
        const Vector3 at_m = p_m() + range_m * along;
        const Cell cell = (at_m / kEdge_m).array().floor().cast<int>();
        if (!known.grid().contains(cell)) break;
        known.at(cell) = truth.at(cell);
        if (truth.at(cell) == CellState::kOccupied) break;
      }
    }
    ++known.now;
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / dt_s) && out.mission == MissionStatus::kRunning; ++i) {
      if (i % 3 == 0) see();
      step();
      notes.insert(out.note);
      approach();
      if (truth.state(p_m()) == CellState::kOccupied) ++contacts;
      farthest_x_m = std::max(farthest_x_m, p_m().x());
    }
  }
  /// Known share of the free cells in these columns.
  double known_share(int from_x, int to_x) const {
    int num = 0, seen = 0;
    for (std::ptrdiff_t i = 0; i < truth.grid().num_cells(); ++i) {
      const Cell cell = truth.grid().cell(i);
      if (cell.x() < from_x || cell.x() >= to_x || truth.at(cell) != CellState::kFree) continue;
      ++num;
      seen += known.at(cell) == CellState::kFree;
    }
    return static_cast<double>(seen) / num;
  }

  BoxMap truth, known;
  std::set<std::string> notes;
  int contacts = 0;
  double farthest_x_m = 0.0;
};

ExploreConfig explores(const Vector3& box_max_m) {
  ExploreConfig config;
  config.box_min_world_m = Vector3(0, 0, 0);
  config.box_max_world_m = box_max_m;
  config.view.path.clearance_m = 0.4;
  config.view.range_m = 4.0;
  config.retries = 1;
  return config;
}

TEST(Explore, MapsBothOpenRoomsCompletely) {
  Explorer explorer(rooms(), explores({14, 6, 2.5}), {1.5, 1.5, 1.1});
  explorer.run(300.0);
  EXPECT_EQ(explorer.out.mission, MissionStatus::kDone);
  EXPECT_STREQ(explorer.out.note, "exploration complete: no visible unknown space is left");
  EXPECT_GT(explorer.known_share(1, 48), 0.98);
  EXPECT_EQ(explorer.known_share(49, 55), 0.0);
  EXPECT_EQ(explorer.contacts, 0);
  for (const char* note : {"looking around", "planning a view", "flying to a view"}) {
    EXPECT_TRUE(explorer.notes.count(note)) << note;
  }
}

TEST(Explore, RequiresAMap) {
  const AgentSetup agent;
  const auto needs_map = [&](const char* type) {
    return make_guidance(Module(guidance_module_types(), type), {agent, {}})->needs().map;
  };
  EXPECT_TRUE(needs_map("explore"));
  EXPECT_FALSE(needs_map("hover"));
}

TEST(Explore, StaysInItsBox) {
  Explorer explorer(rooms(), explores({6.0, 6, 2.5}), {1.5, 1.5, 1.1});
  explorer.run(300.0);
  EXPECT_EQ(explorer.out.mission, MissionStatus::kDone);
  EXPECT_LT(explorer.farthest_x_m, 6.0);
  EXPECT_GT(explorer.known_share(1, 24), 0.98);
  EXPECT_LT(explorer.known_share(36, 48), 0.8) << "the second room is only seen through the opening";
}

TEST(Explore, FailsWithReasonWithoutFlightSpace) {
  ExploreConfig config = explores({14, 6, 2.5});
  config.view.path.clearance_m = 3.0;
  Explorer explorer(rooms(), config, {1.5, 1.5, 1.1});
  explorer.run(60.0);
  EXPECT_EQ(explorer.out.mission, MissionStatus::kFailed);
  EXPECT_STREQ(explorer.out.note, "no clear space around the start");
}

TEST(Explore, CountsAbandonedSearchesAndNamesBudget) {
  const BoxMap truth = rooms();
  ExploreConfig config = explores({14, 6, 2.5});
  config.view.max_expansions = 1;
  Explorer explorer(truth, config, {3.1, 3.0, 1.1});
  explorer.run(120.0);
  const Counter given_up = explorer.counter();
  EXPECT_GT(given_up.count, 0U);
  EXPECT_EQ(given_up.count, given_up.of);
  EXPECT_EQ(given_up.setting, "view.max_expansions");
}

TEST(Explore, ShowsItsPathAndItsView) {
  Explorer explorer(rooms(), explores({14, 6, 2.5}), {1.5, 1.5, 1.1});
  std::vector<Overlay> overlays;
  explorer.guidance->append_overlays(overlays);
  EXPECT_TRUE(overlays.empty());
  while (explorer.out.note != std::string("flying to a view") && explorer.observation.t < 60 * kNsPerSecond)
    explorer.run(0.15);
  explorer.guidance->append_overlays(overlays);
  ASSERT_EQ(overlays.size(), 2U);
  EXPECT_EQ(overlays[1].positions.size(), 1U);
  EXPECT_EQ(overlays[1].positions[0], overlays[0].positions.back());
}

TEST(Explore, LooksAroundOnlyWhileHovering) {
  ExploreConfig config = explores({14, 6, 2.5});
  config.stage_timeout_s = 2.0;
  config.retry_after_s = 1.0;
  for (const bool rests : {true, false}) {
    Explorer explorer(rooms(), config, {1.5, 1.5, 1.1});
    explorer.see();
    std::set<std::string> notes;
    for (int i = 0; i < 60; ++i) {
      explorer.estimate.v_local_mps = {0.0, rests ? 0.0 : 1.0, 0.0};
      explorer.step();
      EXPECT_EQ(explorer.out.speed_limit_mps, config.speed_mps);
      notes.insert(explorer.out.note);
    }
    EXPECT_EQ(notes.contains("flying to a view"), rests);
    EXPECT_EQ(notes.contains("the vehicle does not come to rest"), !rests);
    EXPECT_EQ(explorer.out.mission == MissionStatus::kFailed, !rests);
  }
}

}  // namespace
}  // namespace swiftlet
