// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/guidance/share_paths.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <vector>

#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/shared_path.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"
#include "tests/core/guidance/guidance_driver.hpp"

namespace swiftlet {
namespace {

using testing::GuidanceDriver;

PathInTime along_x(double from_m, double speed_mps, double y_m, int places) {
  PathInTime path{0, 0.1, {}};
  for (int i = 0; i < places; ++i) path.places_local_m.emplace_back(from_m + 0.1 * i * speed_mps, y_m, 5.0);
  return path;
}

TEST(PathInTime, RestsBeforeStartAndAfterEnd) {
  PathInTime path = along_x(1.0, 2.0, 0.0, 11);
  path.t = from_seconds(3.0);
  EXPECT_NEAR(path.at_local_m(0).x(), 1.0, 1e-12);
  EXPECT_NEAR(path.at_local_m(from_seconds(3.55)).x(), 2.1, 1e-9);
  EXPECT_NEAR(path.at_local_m(from_seconds(9.0)).x(), 3.0, 1e-12);
  EXPECT_EQ(path.end(), from_seconds(4.0));
}

TEST(PathInTime, ComparesDistancesAtTheSameTime) {
  const PathInTime a = along_x(0.0, 1.0, 0.0, 51), b = along_x(5.0, -1.0, 0.5, 51);
  EXPECT_NEAR(least_distance_m(a, b, 0, 1.0, 1.0), 0.5, 1e-9);
  EXPECT_NEAR(least_distance_m(a, b, from_seconds(4.5), 1.0, 1.0), std::hypot(4.0, 0.5), 1e-6) << "passed by then";
  PathInTime above = b;
  for (Vector3& place_m : above.places_local_m) place_m.z() += 1.5;
  EXPECT_NEAR(least_distance_m(a, above, 0, 1.0, 1.5), std::hypot(0.5, 1.0), 1e-9) << "heights count less";
}

/// Vehicles that fly their references exactly, and a radio between them.
struct SharingTeam {
  SharingTeam(const std::vector<Vector3>& starts_m, const std::vector<Vector3>& goals_m, double delay_s, double check_s)
      : delay(from_seconds(delay_s)) {
    for (std::size_t i = 0; i < starts_m.size(); ++i) {
      SharePathsConfig config;
      config.goal_m = goals_m[i];
      config.check_s = check_s;
      auto& driver = drivers.emplace_back(std::make_unique<GuidanceDriver>("share_paths", config, starts_m[i]));
      driver->dt_s = 0.02;
      driver->setup.self = static_cast<VehicleId>(i);
      driver->setup.num_vehicles = static_cast<int>(starts_m.size());
      driver->make("share_paths", config);
      driver->outbox = Outbox(static_cast<VehicleId>(i));
    }
  }
  void tick() {
    for (std::size_t i = 0; i < drivers.size(); ++i) {
      GuidanceDriver& driver = *drivers[i];
      for (const Message& message : air) {
        if (message.from != driver.setup.self && message.sent + delay <= now && message.sent + delay > now - kTick) {
          driver.observation.messages.push_back(message);
        }
      }
      driver.step();
      driver.put(driver.out.goal.position_m);
      std::vector<Message> sent;
      driver.outbox.empty_into(sent);
      for (Message& message : sent) {
        message.sent = now;
        air.push_back(std::move(message));
      }
    }
    now += kTick;
    while (!air.empty() && air.front().sent + delay < now - kTick) air.pop_front();
    for (std::size_t i = 0; i < drivers.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        least_m = std::min(least_m, (drivers[i]->p_m() - drivers[k]->p_m()).norm());
      }
    }
  }
  bool done() const {
    return std::all_of(drivers.begin(), drivers.end(),
                       [](const auto& driver) { return driver->out.mission == MissionStatus::kDone; });
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / 0.02) && !done(); ++i) tick();
  }

  static constexpr TimeNs kTick = 20'000'000;
  TimeNs delay, now = 0;
  std::deque<Message> air;
  std::vector<std::unique_ptr<GuidanceDriver>> drivers;
  double least_m = 1e9;
};

TEST(SharePaths, FliesStraightToGoalWhenAlone) {
  SharingTeam team({{0, 0, 5}}, {{12, 0, 5}}, 0.0, 0.1);
  team.run(20.0);
  EXPECT_TRUE(team.done());
  EXPECT_LT(to_seconds(team.now), 10.0);
}

TEST(SharePaths, SeparatesFourCrossingVehicles) {
  const std::vector<Vector3> starts_m = {{-8, 0, 5}, {8, 0, 5}, {0, -8, 5}, {0, 8, 5}};
  const std::vector<Vector3> goals_m = {{8, 0, 5}, {-8, 0, 5}, {0, 8, 5}, {0, -8, 5}};
  SharingTeam team(starts_m, goals_m, 0.1, 0.2);
  team.run(60.0);
  EXPECT_TRUE(team.done());
  EXPECT_GT(team.least_m, 1.0);
}

TEST(SharePaths, SpreadsPlanningTurnsOverThePeriod) {
  SharingTeam team({{0, 0, 5}, {0, 9, 5}, {0, 18, 5}, {0, 27, 5}}, {{20, 0, 5}, {20, 9, 5}, {20, 18, 5}, {20, 27, 5}},
                   0.0, 0.1);
  std::vector<double> first_s(4, 1e9);
  for (int i = 0; i < 30; ++i) {
    team.tick();
    for (const Message& message : team.air) {
      SharedPath sent;
      if (read_message(message, sent) == Reading::kDone && sent.kind == SharedPath::Kind::kPlan) {
        first_s[message.from] = std::min(first_s[message.from], to_seconds(message.sent));
      }
    }
  }
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(first_s[i], SharePathsConfig().period_s * i / 4.0, 0.021) << i;
}

TEST(SharePaths, MeetsTheOtherWithoutRadio) {
  SharingTeam team({{-8, 0, 5}, {8, 0, 5}}, {{8, 0, 5}, {-8, 0, 5}}, 1000.0, 0.2);
  team.run(30.0);
  EXPECT_LT(team.least_m, 0.5) << "least distance without radio, the only source of neighbors";
}

}  // namespace
}  // namespace swiftlet
