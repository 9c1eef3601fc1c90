// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <vector>

#include "swiftlet/core/interception/intercept.hpp"
#include "swiftlet/core/messages/chase_report.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "tests/core/interception/hunt.hpp"

namespace swiftlet {
namespace {

using testing::Hunt;

/// Two interceptors that see each other and exchange reports by radio.
class Pair {
 public:
  Pair(const InterceptConfig& config, const Vector3& first_m, const Vector3& second_m, double delay_s = 0.01)
      : Pair(config, config, first_m, second_m, delay_s) {}
  Pair(const InterceptConfig& first, const InterceptConfig& second, const Vector3& first_m, const Vector3& second_m,
       double delay_s = 0.01)
      : delay_(from_seconds(delay_s)), hunts{Hunt(first, first_m, 0, 2), Hunt(second, second_m, 1, 2)} {}

  /// @param sees  sets the tracks of one of them; the other interceptor is track 50
  void run(double duration_s, const std::function<void(int which, Hunt&)>& sees) {
    const double end_s = hunts[0].now_s() + duration_s;
    while (hunts[0].now_s() < end_s - 1e-9) {
      const Vector3 p_m[2] = {hunts[0].p_m(), hunts[1].p_m()}, v_mps[2] = {hunts[0].v_mps(), hunts[1].v_mps()};
      least_m = std::min(least_m, (p_m[0] - p_m[1]).norm());
      for (const int i : {0, 1}) {
        hunts[i].run(0.004, [&](double, Hunt& hunt) {
          hunt.tracks.clear();
          sees(i, hunt);
          if (sees_other) hunt.sees_also(p_m[1 - i], v_mps[1 - i], 50);
          std::deque<Message>& air = air_[1 - i];
          for (; !air.empty() && air.front().sent + delay_ <= hunt.now(); air.pop_front()) {
            if (radio) hunt.hears(air.front());
          }
        });
        std::vector<Message> sent;
        hunts[i].outbox.empty_into(sent);
        for (Message& message : sent) {
          message.from = i;
          message.sent = hunts[i].now();
          ChaseReport report;
          if (read_message(message, report) == Reading::kDone) statuses[i] = report.status;
          air_[i].push_back(std::move(message));
        }
      }
    }
  }
  bool captured(int i) const { return noted(i, "captured"); }
  bool noted(int i, const char* note) const {
    return std::find(hunts[i].notes.begin(), hunts[i].notes.end(), note) != hunts[i].notes.end();
  }

 private:
  TimeNs delay_;
  std::deque<Message> air_[2];

 public:
  Hunt hunts[2];
  ChaseReport::Status statuses[2] = {};
  double least_m = 1e9;
  bool radio = true, sees_other = true;
};

InterceptConfig for_ever() {
  InterceptConfig config;
  config.captures = 0;
  config.net.rearm_m = 0.0;
  return config;
}

TEST(InterceptTeam, SoonerVehicleCatchesAsIfAlone) {
  const Vector3 near_m(-12.0, 3.0, 16.0), far_m(20.0, -6.0, 16.0);
  const auto circling = [](int, Hunt& hunt) { testing::circling(hunt.now_s(), hunt); };
  Hunt alone({}, near_m);
  while (alone.out.mission == MissionStatus::kRunning && alone.now_s() < 20.0) {
    alone.run(0.004, [&](double, Hunt& hunt) { circling(0, hunt); });
  }
  ASSERT_EQ(alone.out.mission, MissionStatus::kDone);
  for (const double delay_s : {0.01, 0.2, 0.5}) {
    Pair pair({}, near_m, far_m, delay_s);
    while (pair.hunts[0].out.mission == MissionStatus::kRunning && pair.hunts[0].now_s() < 20.0)
      pair.run(0.004, circling);
    EXPECT_TRUE(pair.captured(0)) << delay_s;
    EXPECT_LT(pair.hunts[0].now_s(), alone.now_s() + 0.5) << delay_s;
    EXPECT_GT(pair.least_m, 1.5) << delay_s;
    pair.run(1.0, circling);
    EXPECT_EQ(pair.hunts[1].out.mission, MissionStatus::kDone);
    EXPECT_TRUE(pair.noted(1, "a teammate has captured the target")) << delay_s;
  }
}

TEST(InterceptTeam, KeepsVehiclesClearForAMinute) {
  for (const double delay_s : {0.01, 0.3}) {
    Pair pair(for_ever(), {-12.0, 3.0, 16.0}, {11.0, -6.0, 16.0}, delay_s);
    pair.run(60.0, [](int, Hunt& hunt) { testing::circling(hunt.now_s(), hunt); });
    EXPECT_GT(pair.least_m, 1.4) << delay_s;
    EXPECT_TRUE(pair.captured(0) || pair.captured(1)) << delay_s;
  }
}

TEST(InterceptTeam, ExcludesTeammateHeardByRadio) {
  Pair pair({}, {-10.0, 0.0, 12.0}, {10.0, 0.0, 12.0}, 0.2);
  pair.run(4.0, [](int, Hunt&) {});
  for (const int i : {0, 1}) EXPECT_EQ(pair.hunts[i].notes.back(), "waiting for a target");
  EXPECT_GT(pair.least_m, 19.0);
  pair.radio = false;
  pair.run(3.0, [](int, Hunt&) {});
  EXPECT_EQ(pair.hunts[0].notes.back(), "chasing") << "without radio the teammate is a target";
}

TEST(InterceptTeam, AssignsEachVehicleItsOwnTarget) {
  // Both are nearer to the first one.
  Pair pair({}, {-14.0, 0.0, 14.0}, {-14.0, 12.0, 14.0});
  pair.run(8.0, [](int, Hunt& hunt) {
    hunt.sees({0.0, 5.0, 12.0}, Vector3::Zero(), 7);
    hunt.sees_also({20.0, 8.0, 12.0}, Vector3::Zero(), 8);
  });
  EXPECT_TRUE(pair.captured(0));
  EXPECT_TRUE(pair.captured(1));
  EXPECT_GT(std::max(pair.hunts[0].p_m().x(), pair.hunts[1].p_m().x()), 15.0);
  EXPECT_LT(std::min(pair.hunts[0].p_m().x(), pair.hunts[1].p_m().x()), 5.0);
}

TEST(InterceptTeam, BlindVehicleFollowsTeammateSighting) {
  Pair pair(for_ever(), {0.0, 0.0, 14.0}, {-30.0, 0.0, 14.0});
  const auto one_sees = [](int which, Hunt& hunt) {
    if (which == 0) hunt.sees({14.0, 0.0, 12.0}, Vector3::Zero());
  };
  pair.run(4.0, one_sees);
  EXPECT_TRUE(pair.noted(1, "flying to a target reported by a teammate"));
  EXPECT_GT(pair.hunts[1].p_m().x(), -22.0);
  EXPECT_GT(pair.least_m, 2.9);
  EXPECT_EQ(pair.statuses[1], ChaseReport::Status::kSearches);
  // Received target positions are not forwarded: once the source is gone, both search.
  pair.run(3.0, [](int, Hunt&) {});
  EXPECT_EQ(pair.statuses[0], ChaseReport::Status::kSearches);
  EXPECT_EQ(pair.statuses[1], ChaseReport::Status::kSearches);
}

TEST(InterceptTeam, TakesOverFromSilentLeader) {
  Pair pair(for_ever(), {6.0, 0.0, 14.0}, {-14.0, 0.0, 14.0});
  const auto far_away = [](int, Hunt& hunt) { hunt.sees({40.0, 0.0, 12.0}, Vector3::Zero()); };
  pair.run(0.5, far_away);
  EXPECT_EQ(pair.statuses[0], ChaseReport::Status::kLeads);
  EXPECT_EQ(pair.statuses[1], ChaseReport::Status::kYields);
  pair.radio = false;
  pair.run(1.3, far_away);
  EXPECT_EQ(pair.statuses[1], ChaseReport::Status::kLeads);
}

/// Two of which the first has a wall of its fence between itself and the target.
TEST(InterceptTeam, FencedVehicleDoesNotBlockTeammate) {
  InterceptConfig near_config, far_config;
  near_config.fence.max_m.x() = 5.0;
  near_config.fence.patience_s = 100.0;
  Pair pair(near_config, far_config, {2.0, 0.0, 14.0}, {2.0, 24.0, 14.0});
  pair.run(10.0, [](int, Hunt& hunt) { hunt.sees({9.0, 0.0, 12.0}, Vector3::Zero()); });
  EXPECT_TRUE(pair.captured(1));
  EXPECT_TRUE(pair.noted(0, "a teammate has captured the target"));
}

// The target hovers inside of its fence, so high that the net below cannot be brought there.
TEST(InterceptTeam, UnsuccessfulLeaderYieldsToTeammate) {
  InterceptConfig low_config, polite_config;
  low_config.fence.max_m.z() = 15.0;
  polite_config.yield_clearance_m = 15.0;  // with this clearance it never arrives first
  Pair pair(low_config, polite_config, {-8.0, 0.0, 14.0}, {-20.0, 24.0, 15.0});
  pair.run(25.0, [](int, Hunt& hunt) { hunt.sees({4.0, 0.0, 14.8}, Vector3::Zero()); });
  EXPECT_TRUE(pair.captured(1));
  EXPECT_FALSE(pair.captured(0));
  EXPECT_GT(pair.least_m, 1.4);
}

}  // namespace
}  // namespace swiftlet
