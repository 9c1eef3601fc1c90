// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/sharing/map_sharing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <string>

#include "core/slam/graph/global_slam.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/map_closures.hpp"
#include "swiftlet/core/messages/submap_chunk.hpp"
#include "swiftlet/core/messages/submap_descriptor.hpp"
#include "swiftlet/core/messages/submap_places.hpp"
#include "swiftlet/core/messages/submap_request.hpp"
#include "tests/core/slam/shared_yard.hpp"

namespace swiftlet {
namespace {

using testing::level_at;
using testing::YardFlight;

constexpr TimeNs kStep = 50'000'000;
const Pose kT_local_world[] = {level_at(3, 4, 0, 0.5).inverse(), level_at(30, -2, 1, -2.0).inverse()};

struct TestConfig : MapSharingConfig {
  ClosureConfig closures;
};

TestConfig quick_config() {
  TestConfig config;
  config.enabled = true;
  config.latency_s = 0.1;
  config.report_interval_s = 2.0;
  config.retry_after_s = 0.5;
  config.closures.range_max_m = 14.0;
  config.closures.search_radius_m = 4.0;
  return config;
}

/// Two vehicles and a radio with a delay of half a step; `drops` selects lost messages.
struct Pair {
  explicit Pair(const TestConfig& config)
      : sharing{MapSharing(config, config.closures, 0, 2), MapSharing(config, config.closures, 1, 2)} {}

  MapSharing sharing[2];
  std::vector<YardFlight> flights;
  std::vector<Message> inbox[2];
  TimeNs t = 0;
  std::function<bool(const Message&)> drops = [](const Message&) { return false; };
  std::map<std::string, int> sent_by_topic;
  std::vector<std::pair<TimeNs, std::size_t>> sizes[2];

  void step() {
    t += kStep;
    std::vector<Message> out[2];
    for (int i = 0; i < 2; ++i) {
      Outbox outbox(i);
      sharing[i].step(t, flights[static_cast<std::size_t>(i)], inbox[i], outbox);
      outbox.empty_into(out[i]);
    }
    for (int i = 0; i < 2; ++i) {
      inbox[1 - i].clear();
      for (const Message& message : out[i]) {
        ++sent_by_topic[message.topic];
        sizes[i].emplace_back(t, message.size_bytes());
        if (!drops(message)) inbox[1 - i].push_back(message);
      }
    }
  }
  bool joined() const { return !sharing[0].joined_maps().empty() && !sharing[1].joined_maps().empty(); }
  void run(double seconds) {
    for (const TimeNs end = t + from_seconds(seconds); t < end;) step();
  }
  void run_until_joined(double most_s) {
    for (const TimeNs end = t + from_seconds(most_s); t < end && !joined();) step();
  }
};

/// Both fly through the same yard, the second one in the opposite direction, slightly offset and rotated.
Pair two_in_the_yard(const TestConfig& config) {
  Pair pair(config);
  const std::vector<Vector3> world_m = testing::shared_yard_m();
  for (const Pose& T_local_world : kT_local_world) pair.flights.emplace_back(world_m, T_local_world);
  for (int i = 0; i < 6; ++i) {
    pair.flights[0].begin_submap(level_at(8.0 * i, 0.5, 2.0, 0.1 * i));
    pair.flights[1].begin_submap(level_at(41.0 - 8.0 * i, -0.5, 2.4, 3.0 - 0.1 * i));
  }
  return pair;
}

/// Error of the transform at the position of the other vehicle.
double error_m(const Pair& pair, int self) {
  const JoinedMap& joined = pair.sharing[self].joined_maps().front();
  const Pose T_true = kT_local_world[self] * kT_local_world[1 - self].inverse();
  const Vector3 p_m = pair.flights[static_cast<std::size_t>(1 - self)].T_local_submap(5).translation();
  return (joined.T_local_otherlocal * p_m - T_true * p_m).norm();
}

TEST(MapSharing, AlignsFramesWithoutPriorKnowledge) {
  Pair pair = two_in_the_yard(quick_config());
  pair.run_until_joined(30.0);
  ASSERT_TRUE(pair.joined());
  for (int self = 0; self < 2; ++self) {
    EXPECT_LT(error_m(pair, self), 0.1) << self;
    EXPECT_GE(pair.sharing[self].joined_maps().front().num_closures, 2);
    EXPECT_EQ(pair.sharing[self].joined_maps().front().other, 1 - self);
  }
  EXPECT_EQ(pair.sent_by_topic[SubmapDescriptor::kTopic], 10) << "each finished submap once";
  std::vector<Overlay> overlays;
  pair.sharing[0].append_overlays(pair.flights[0], overlays);
  ASSERT_EQ(overlays.size(), 1U);
  EXPECT_EQ(overlays[0].name, "slam.joined");
  EXPECT_GT(overlays[0].positions.size(), 4U);
}

TEST(MapSharing, FollowsCorrectionsOfTheOtherGraph) {
  Pair pair = two_in_the_yard(quick_config());
  pair.run_until_joined(30.0);
  ASSERT_TRUE(pair.joined());
  const Vector3 by_m(0.4, 0.2, 0.0);
  for (int i = 0; i < 6; ++i) pair.flights[1].move(i, by_m);
  pair.run(6.0);
  ASSERT_TRUE(pair.joined());
  const JoinedMap& joined = pair.sharing[0].joined_maps().front();
  const Pose T_true = kT_local_world[0] * kT_local_world[1].inverse();
  const Vector3 p_m = pair.flights[1].T_local_submap(5).translation();
  EXPECT_LT((joined.T_local_otherlocal * p_m - T_true * (p_m - by_m)).norm(), 0.1);
}

TEST(MapSharing, ResendsLostMessages) {
  Pair pair = two_in_the_yard(quick_config());
  std::map<std::string, int> count;
  pair.drops = [&](const Message& message) {
    const int n = count[message.topic]++;
    return n % 3 == 1 || n == 0;
  };
  pair.run_until_joined(60.0);
  ASSERT_TRUE(pair.joined());
  EXPECT_LT(error_m(pair, 0), 0.1);
}

TEST(MapSharing, RequestsOnlyLostChunks) {
  Pair pair = two_in_the_yard(quick_config());
  int lost_submap = -1, lost_chunk = -1;
  std::vector<std::pair<int, int>> sent;
  pair.drops = [&](const Message& message) {
    SubmapChunk chunk;
    if (read_message(message, chunk) != Reading::kDone) return false;
    sent.emplace_back(static_cast<int>(chunk.submap), chunk.chunk);
    if (lost_submap >= 0 || chunk.chunk != 1) return false;
    lost_submap = static_cast<int>(chunk.submap);
    lost_chunk = chunk.chunk;
    return true;
  };
  pair.run_until_joined(30.0);
  ASSERT_TRUE(pair.joined());
  ASSERT_GE(lost_submap, 0);
  std::map<std::pair<int, int>, int> times;
  for (const auto& which : sent) ++times[which];
  for (const auto& [which, n] : times) {
    EXPECT_EQ(n, which == std::pair(lost_submap, lost_chunk) ? 2 : 1) << which.first << ", " << which.second;
  }
}

TEST(MapSharing, KeepsItsBudget) {
  TestConfig config = quick_config();
  for (const double kbps : {10.0, 40.0}) {
    config.budget_kbps = kbps;
    Pair pair = two_in_the_yard(config);
    pair.run(20.0);
    const double rate_bytes_s = 1e3 * kbps / 8.0, burst_bytes = 1200.0 + 0.1 * rate_bytes_s;
    for (const auto& sizes : pair.sizes) {
      ASSERT_FALSE(sizes.empty());
      for (std::size_t i = 0; i < sizes.size(); ++i) {
        double sum = 0.0;
        for (std::size_t j = i; j < sizes.size() && sizes[j].first <= sizes[i].first + from_seconds(2.0); ++j) {
          sum += static_cast<double>(sizes[j].second);
          const double window_s = to_seconds(sizes[j].first - sizes[i].first);
          ASSERT_LE(sum, burst_bytes + rate_bytes_s * window_s + 1.0) << kbps;
        }
      }
    }
  }
}

TEST(MapSharing, ReachesSameResultOverSlowLink) {
  TestConfig config = quick_config();
  double joined_s[2] = {};
  int i = 0;
  for (const double kbps : {300.0, 12.0}) {
    config.budget_kbps = kbps;
    Pair pair = two_in_the_yard(config);
    pair.run_until_joined(90.0);
    ASSERT_TRUE(pair.joined()) << kbps;
    EXPECT_LT(error_m(pair, 0), 0.1);
    joined_s[i++] = to_seconds(pair.t);
  }
  EXPECT_GT(joined_s[1], 2.0 * joined_s[0]);
}

TEST(MapSharing, JoinsNothingInDifferentPlaces) {
  Pair pair(quick_config());
  std::vector<Vector3> elsewhere_m = testing::shared_yard_m();
  for (Vector3& p : elsewhere_m) {  // fences in other directions, around huts
    if (p.z() > 0.1) p = {20.0 + 0.5 * p.y() + 0.2 * p.x(), 9.0 * std::sin(0.35 * p.x()), 0.5 * p.z()};
  }
  pair.flights.emplace_back(testing::shared_yard_m(), kT_local_world[0]);
  pair.flights.emplace_back(elsewhere_m, kT_local_world[1]);
  for (int i = 0; i < 6; ++i) {
    for (YardFlight& flight : pair.flights) flight.begin_submap(level_at(8.0 * i, 0.5, 2.0, 0.0));
  }
  pair.run(30.0);
  EXPECT_TRUE(pair.sharing[0].joined_maps().empty());
  EXPECT_TRUE(pair.sharing[1].joined_maps().empty());
}

/// Equal aisles: racks without end, the same every 3 m along and 6 m across.
std::vector<Vector3> aisles_m() {
  std::vector<Vector3> points_m;
  for (int row = -4; row <= 4; ++row) {
    for (int bay = -8; bay <= 20; ++bay) {
      for (int i = 0; i < 10; ++i) {
        for (int j = 0; j <= 15; ++j) {
          points_m.emplace_back(3.0 * bay + 0.2 * i, 6.0 * row, 0.2 * j);
          points_m.emplace_back(3.0 * bay, 6.0 * row + 0.15 * i, 0.2 * j);
        }
      }
    }
  }
  for (int i = -120; i <= 320; ++i) {
    for (int j = -130; j <= 130; ++j) points_m.emplace_back(0.2 * i, 0.2 * j, 0.0);
  }
  return points_m;
}

TEST(MapSharing, JoinsNothingInEqualAisles) {
  TestConfig config = quick_config();
  config.closures.search_radius_m = 8.0;
  Pair pair(config);
  for (const Pose& T_local_world : kT_local_world) pair.flights.emplace_back(aisles_m(), T_local_world, 10.0);
  for (int i = 0; i < 4; ++i) {
    pair.flights[0].begin_submap(level_at(8.0 * i, -3.0, 2.0, 0.0));
    pair.flights[1].begin_submap(level_at(30.0 - 8.0 * i, 3.0, 2.0, 3.1));
  }
  pair.run(15.0);
  EXPECT_GT(pair.sharing[0].num_searches(), 0) << "candidates were examined";
  EXPECT_TRUE(pair.sharing[0].joined_maps().empty());
  EXPECT_TRUE(pair.sharing[1].joined_maps().empty());
}

TEST(MapSharing, GivesTheSameBitsTwice) {
  std::vector<std::pair<TimeNs, std::size_t>> sizes[2];
  double x_m[2] = {};
  for (int i = 0; i < 2; ++i) {
    Pair pair = two_in_the_yard(quick_config());
    pair.run_until_joined(30.0);
    ASSERT_TRUE(pair.joined());
    sizes[i] = pair.sizes[1];
    x_m[i] = pair.sharing[0].joined_maps().front().T_local_otherlocal.translation().x();
  }
  EXPECT_EQ(sizes[0], sizes[1]);
  EXPECT_EQ(x_m[0], x_m[1]);
}

/// A vehicle that receives invalid messages.
struct Receiver {
  MapSharing sharing{quick_config(), ClosureConfig{}, 0, 3};
  YardFlight flight{testing::shared_yard_m(), Pose::Identity()};
  TimeNs t = 0;

  Receiver() {
    for (int i = 0; i < 3; ++i) flight.begin_submap(level_at(8.0 * i, 0, 2, 0));
  }
  std::uint64_t refused() const {
    std::vector<Counter> counters;
    sharing.append_counters(counters);
    return counters.front().count;
  }
  template <class Kind>
  bool refuses(const Kind& content, VehicleId from = 1) {
    Message message;
    message.from = from;
    write_message(content, message);
    return refuses_message(message);
  }
  bool refuses_message(const Message& message) {
    const std::uint64_t before = refused();
    Outbox outbox(0);
    sharing.step(t += kStep, flight, {&message, 1}, outbox);
    return refused() > before;
  }
};

SubmapDescriptor descriptor(std::uint32_t submap) {
  SubmapDescriptor report;
  report.submap = submap;
  report.num_points = 100;
  report.num_chunks = 2;
  report.directions.assign(120, 9);
  report.heights.assign(16, 200);
  return report;
}

TEST(MapSharing, RefusesImpossibleReports) {
  Receiver receiver;
  EXPECT_FALSE(receiver.refuses(descriptor(3)));
  EXPECT_TRUE(receiver.refuses(descriptor(4096)));
  EXPECT_TRUE(receiver.refuses(descriptor(1), 3)) << "no such vehicle";
  EXPECT_TRUE(receiver.refuses(descriptor(1), 0)) << "its own number";
  SubmapDescriptor wrong = descriptor(1);
  wrong.directions.resize(119);
  EXPECT_TRUE(receiver.refuses(wrong));
  wrong = descriptor(1);
  wrong.num_chunks = 60000;
  EXPECT_TRUE(receiver.refuses(wrong));
  wrong = descriptor(1);
  wrong.num_points = 4000000000U;
  EXPECT_TRUE(receiver.refuses(wrong));

  SubmapPlaces places{
      2, 0, {{{1, 2, 3}, {0, 0, 1}, 0.0F}, {{9, 2, 3}, {0, 0, 1}, 8.0F}, {{17, 2, 3}, {0, 0, 1}, 16.0F}}};
  EXPECT_FALSE(receiver.refuses(places));
  SubmapPlaces strange = places;
  strange.first = 1;
  EXPECT_TRUE(receiver.refuses(strange)) << "more than there are";
  strange = places;
  strange.first = 0xffffffffU;
  EXPECT_TRUE(receiver.refuses(strange));
  strange = places;
  strange.num_finished = 0xffffffffU;
  EXPECT_TRUE(receiver.refuses(strange));
  for (const float x_m : {1e9F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    strange = places;
    strange.places[1].p_local_m.x() = x_m;
    EXPECT_TRUE(receiver.refuses(strange)) << x_m;
  }
  strange = places;
  strange.places[1].turn_local_rad = {2, 0, 0};
  EXPECT_TRUE(receiver.refuses(strange)) << "its z axis does not point up";
  strange = places;
  strange.places[1].path_length_m = -1.0F;
  EXPECT_TRUE(receiver.refuses(strange));

  EXPECT_TRUE(receiver.refuses(SubmapChunk{0, 0, 5, 5, 0.5F, {1, 2, 3}})) << "not requested";
  EXPECT_FALSE(receiver.refuses(SubmapRequest{SubmapRequest::Content::kDescriptors, 0, {3}}));
  EXPECT_TRUE(receiver.refuses(SubmapRequest{SubmapRequest::Content::kDescriptors, 2, {1}})) << "not finished";
  EXPECT_TRUE(receiver.refuses(SubmapRequest{SubmapRequest::Content::kCloud, 0, std::vector<std::uint8_t>(60, 255)}));
  EXPECT_TRUE(receiver.refuses(MapClosures{})) << "the vehicle with the lower number searches";
}

TEST(MapSharing, RefusesImpossibleClosures) {
  MapSharing sharing(quick_config(), ClosureConfig{}, 1, 2);
  YardFlight flight(testing::shared_yard_m(), Pose::Identity());
  for (int i = 0; i < 3; ++i) flight.begin_submap(level_at(8.0 * i, 0, 2, 0));
  TimeNs t = 0;
  const auto accepts = [&](const MapClosures::Closure& closure, std::size_t times = 1) {
    Message message;
    message.from = 0;
    write_message(MapClosures{std::vector<MapClosures::Closure>(times, closure)}, message);
    std::vector<Counter> before, after;
    sharing.append_counters(before);
    Outbox outbox(1);
    sharing.step(t += kStep, flight, {&message, 1}, outbox);
    sharing.append_counters(after);
    return after.front().count == before.front().count;
  };
  EXPECT_TRUE(accepts({5, 1, {1, 2, 0}, {0, 0, 1}}));
  EXPECT_EQ(sharing.num_closures(0), 1);
  EXPECT_FALSE(accepts({5, 2, {1, 2, 0}, {0, 0, 1}})) << "the own submap grows";
  EXPECT_FALSE(accepts({5000, 1, {1, 2, 0}, {0, 0, 1}}));
  EXPECT_FALSE(accepts({5, 1, {1000, 2, 0}, {0, 0, 1}}));
  EXPECT_FALSE(accepts({5, 1, {1, 2, 0}, {0, 0, 4}}));
  EXPECT_FALSE(accepts({5, 1, {1, 2, 0}, {0, 0, 1}}, 33));
  EXPECT_EQ(sharing.num_closures(0), 1);
}

TEST(MapSharing, SurvivesArbitraryBytes) {
  Receiver receiver;
  std::vector<Message> valid(5);
  write_message(descriptor(1), valid[0]);
  write_message(SubmapPlaces{1, 0, {{{1, 2, 3}, {0, 0, 1}, 0.0F}, {{9, 2, 3}, {0, 0, 1}, 8.0F}}}, valid[1]);
  write_message(SubmapRequest{SubmapRequest::Content::kCloud, 0, {255}}, valid[2]);
  write_message(SubmapChunk{1, 0, 50, 5, 0.5F, std::vector<std::uint8_t>(100, 3)}, valid[3]);
  write_message(MapClosures{{{0, 1, {1, 2, 0}, {0, 0, 1}}}}, valid[4]);
  std::mt19937 random(1);
  for (int i = 0; i < 4000; ++i) {
    Message message = valid[random() % valid.size()];
    message.from = static_cast<VehicleId>(random() % 5) - 1;
    for (int n = static_cast<int>(random() % 4); n > 0; --n) {
      message.payload[random() % message.payload.size()] = static_cast<std::byte>(random());
    }
    if (i % 5 == 0) message.payload.resize(random() % (message.payload.size() + 1));
    receiver.refuses_message(message);
  }
  EXPECT_TRUE(receiver.sharing.joined_maps().empty());
  EXPECT_GT(receiver.refused(), 500U);
}

TEST(MapSharing, IsOffByDefault) { EXPECT_FALSE(GlobalSlamConfig{}.share.enabled); }

}  // namespace
}  // namespace swiftlet
