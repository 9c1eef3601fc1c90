// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/radio/radio.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "swiftlet/core/math/random.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/sample_statistics.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

constexpr TimeNs kTick = 4'000'000;

RadioConfig plain_radio() {
  RadioConfig config;
  config.rate_kbps = 8.0;  // a byte takes a millisecond
  config.delay_s = 0.005;
  config.jitter_s = 0.0;
  return config;
}

Message message(const std::string& topic, std::size_t size_bytes, VehicleId to = kNoVehicle) {
  Message m;
  m.to = to;
  m.topic = topic;
  m.payload.resize(size_bytes - Message::kHeaderBytes - topic.size());
  return m;
}

/// A radio with its vehicles and its clock.
struct Network {
  explicit Network(const RadioConfig& config, int num_vehicles = 2, std::shared_ptr<const StaticScene> world = nullptr,
                   std::uint64_t seed = 1)
      : states(num_vehicles), inboxes(num_vehicles), radio(config, seed, names(num_vehicles), std::move(world)) {}

  static std::vector<std::string> names(int n) {
    std::vector<std::string> names;
    for (int i = 0; i < n; ++i) names.push_back("uav" + std::to_string(i + 1));
    return names;
  }

  void post(VehicleId from, const std::vector<Message>& messages) { radio.post(from, now, messages, states); }
  void tick() {
    now += kTick;
    for (std::size_t i = 0; i < states.size(); ++i) radio.deliver(static_cast<VehicleId>(i), now, inboxes[i]);
  }
  void ticks(int n) {
    for (int i = 0; i < n; ++i) tick();
  }

  TimeNs now = 0;
  std::vector<VehicleState> states;
  std::vector<std::vector<Message>> inboxes;
  Radio radio;
};

TEST(Radio, TakesTransmissionTimePlusDelay) {
  Network network(plain_radio());
  network.ticks(3);
  Message sent = message("hello", 100, 1);
  sent.payload[3] = std::byte{42};
  network.post(0, {sent});
  network.ticks(26);  // 104 ms later
  EXPECT_TRUE(network.inboxes[1].empty());
  network.tick();
  ASSERT_EQ(network.inboxes[1].size(), 1U);
  const Message& received = network.inboxes[1][0];
  EXPECT_EQ(received.sent, 12'000'000);
  EXPECT_EQ(received.received, 12'000'000 + 100'000'000 + 5'000'000);
  EXPECT_EQ(received.from, 0);
  EXPECT_EQ(received.topic, "hello");
  EXPECT_EQ(received.payload, sent.payload);
  EXPECT_TRUE(network.inboxes[0].empty());
}

TEST(Radio, NeverDeliversInPostingTick) {
  RadioConfig config;
  config.rate_kbps = 1e9;
  config.delay_s = config.jitter_s = 0.0;
  Network network(config);
  network.post(0, {message("a", 50)});
  network.radio.deliver(1, network.now, network.inboxes[1]);
  EXPECT_TRUE(network.inboxes[1].empty());
  network.tick();
  EXPECT_EQ(network.inboxes[1].size(), 1U);
}

TEST(Radio, TransmitsSequentiallyPerSender) {
  Network network(plain_radio(), 3);
  network.post(0, {message("a", 50), message("b", 30)});
  network.post(2, {message("c", 60)});  // another sender does not wait
  network.ticks(50);
  const auto& inbox = network.inboxes[1];
  ASSERT_EQ(inbox.size(), 3U);
  EXPECT_EQ(inbox[0].topic, "a");
  EXPECT_EQ(inbox[0].received, 55'000'000);
  EXPECT_EQ(inbox[1].topic, "c");
  EXPECT_EQ(inbox[1].received, 65'000'000);
  EXPECT_EQ(inbox[2].topic, "b");
  EXPECT_EQ(inbox[2].received, 85'000'000);
}

TEST(Radio, BreaksArrivalTiesBySenderOrder) {
  Network network(plain_radio(), 4);
  network.post(2, {message("x", 40)});
  network.post(0, {message("x", 40)});
  network.post(3, {message("x", 40)});
  network.ticks(20);
  ASSERT_EQ(network.inboxes[1].size(), 3U);
  EXPECT_EQ(network.inboxes[1][0].from, 0);
  EXPECT_EQ(network.inboxes[1][1].from, 2);
  EXPECT_EQ(network.inboxes[1][2].from, 3);
}

TEST(Radio, BroadcastReachesOthersAndUnicastOne) {
  Network network(plain_radio(), 3);
  network.post(0, {message("all", 40), message("one", 40, 2), message("self", 40, 0)});
  network.ticks(50);
  EXPECT_EQ(network.inboxes[0].size(), 0U);
  EXPECT_EQ(network.inboxes[1].size(), 1U);
  EXPECT_EQ(network.inboxes[2].size(), 2U);
  EXPECT_THROW(network.post(0, {message("unknown", 40, 3)}), std::invalid_argument);
}

TEST(Radio, LosesMessagesIndependentlyAtStatedRate) {
  RadioConfig config = plain_radio();
  config.rate_kbps = 1e6;
  config.loss_probability = 0.2;
  Network network(config, 3);
  const int n = 5000;
  int both = 0;
  for (int i = 0; i < n; ++i) {
    network.inboxes.assign(3, {});
    network.post(0, {message("a", 40)});
    network.ticks(3);
    both += network.inboxes[1].size() + network.inboxes[2].size() == 2U;
  }
  const RadioStatistics& statistics = network.radio.statistics();
  EXPECT_EQ(statistics.sent, static_cast<std::uint64_t>(n));
  EXPECT_EQ(statistics.lost + statistics.delivered, 2U * n);
  EXPECT_NEAR(statistics.lost / (2.0 * n), 0.2, share_bound(0.2, 2 * n));
  EXPECT_NEAR(both / static_cast<double>(n), 0.64, share_bound(0.64, n));
}

TEST(Radio, DrawsJitterFromHalfNormal) {
  RadioConfig config = plain_radio();
  config.rate_kbps = 1e6;
  config.jitter_s = 0.01;
  Network network(config);
  SampleStatistics delay_s;
  for (int i = 0; i < 5000; ++i) {
    network.post(0, {message("a", 40)});
    network.ticks(20);
    ASSERT_EQ(network.inboxes[1].size(), 1U);
    const Message& m = network.inboxes[1][0];
    delay_s.add(to_seconds(m.received - m.sent) - 0.005 - 40 * 8 / 1e9);
    EXPECT_GT(m.received, m.sent + 5'000'000);
    network.radio.recycle(network.inboxes[1]);
  }
  const double mean = 0.01 * std::sqrt(2.0 / M_PI);
  const double variance = 1e-4 * (1.0 - 2.0 / M_PI);
  EXPECT_NEAR(delay_s.mean(), mean, mean_bound(std::sqrt(variance), delay_s.size()));
  EXPECT_NEAR(network.radio.statistics().mean_delay_s, delay_s.mean() + 0.005 + 40 * 8 / 1e9, 1e-9);
}

// A message of zero duration still arrives after earlier ones.
TEST(Radio, TakesAtLeastOneNanosecond) {
  RadioConfig config;
  config.rate_kbps = 1e12;
  config.delay_s = config.jitter_s = 0.0;
  Network network(config);
  network.post(0, {message("a", 50), message("b", 50)});
  network.ticks(1);
  ASSERT_EQ(network.inboxes[1].size(), 2U);
  EXPECT_EQ(network.inboxes[1][0].received, 1);
  EXPECT_EQ(network.inboxes[1][1].received, 2);
}

TEST(Radio, DeliversNothingBeyondRange) {
  RadioConfig config = plain_radio();
  config.range_m = 50.0;
  Network network(config, 3);
  network.states[1].p_world_m = {49.9, 0.0, 0.0};
  network.states[2].p_world_m = {0.0, 50.1, 0.0};
  network.post(0, {message("a", 40)});
  network.ticks(20);
  EXPECT_EQ(network.inboxes[1].size(), 1U);
  EXPECT_EQ(network.inboxes[2].size(), 0U);
  EXPECT_EQ(network.radio.statistics().out_of_range, 1U);
}

TEST(Radio, RequiresLineOfSightWhenConfigured) {
  TestScene wall;
  wall.add_box({5, -1, 0}, {6, 1, 10});
  const auto world = std::make_shared<const StaticScene>(wall.scene());
  for (const bool line_of_sight : {true, false}) {
    RadioConfig config = plain_radio();
    config.line_of_sight = line_of_sight;
    Network network(config, 3, world);
    network.states[0].p_world_m = {0.0, 0.0, 2.0};
    network.states[1].p_world_m = {10.0, 0.0, 2.0};
    network.states[2].p_world_m = {10.0, 8.0, 2.0};
    network.post(0, {message("a", 40)});
    network.ticks(20);
    EXPECT_EQ(network.inboxes[1].size(), line_of_sight ? 0U : 1U);
    EXPECT_EQ(network.inboxes[2].size(), 1U);
    EXPECT_EQ(network.radio.statistics().blocked, line_of_sight ? 1U : 0U);
  }
}

TEST(Radio, UsesSenderPositionAtTransmissionStart) {
  RadioConfig config = plain_radio();
  config.range_m = 50.0;
  Network network(config);
  network.post(0, {message("first", 100), message("second", 100)});
  network.states[1].p_world_m = {80.0, 0.0, 0.0};  // gone before the second one starts
  for (int i = 0; i < 60; ++i) {
    network.tick();
    network.post(0, {});
  }
  ASSERT_EQ(network.inboxes[1].size(), 1U);
  EXPECT_EQ(network.inboxes[1][0].topic, "first");
}

TEST(Radio, DropsOldestWaitingMessageWhenFull) {
  RadioConfig config = plain_radio();
  config.queue_limit_kB = 0.1;
  Network network(config);
  network.post(0, {message("a", 50), message("b", 50), message("c", 50), message("d", 50)});
  network.ticks(60);
  // "a" is transmitted at once; "b" is replaced by "d".
  ASSERT_EQ(network.inboxes[1].size(), 3U);
  EXPECT_EQ(network.inboxes[1][0].topic, "a");
  EXPECT_EQ(network.inboxes[1][1].topic, "c");
  EXPECT_EQ(network.inboxes[1][1].received, 105'000'000);
  EXPECT_EQ(network.inboxes[1][2].topic, "d");
  EXPECT_EQ(network.radio.statistics().dropped, 1U);
}

// Table IV of "Drones Guiding Drones": odometry of 0.725 kB at 2 Hz is 1.45 kB/s.
TEST(Radio, CountsTrafficByTopic) {
  RadioConfig config;
  Network network(config, 2);
  const double duration_s = 10.0;
  for (int i = 0; i < duration_s / 0.5; ++i) {
    network.post(1, {message("odometry", 725, 0)});
    network.post(0, {message("path", 484, 1), message("path", 132, 1)});
    network.ticks(125);
  }
  const auto topics = network.radio.topics();
  ASSERT_EQ(topics.size(), 2U);
  EXPECT_EQ(topics[0].topic, "path");
  EXPECT_EQ(topics[0].messages, 40U);
  EXPECT_EQ(topics[1].topic, "odometry");
  EXPECT_EQ(topics[1].from, 1);
  EXPECT_NEAR(topics[1].bytes / duration_s / 1e3, 1.45, 1e-12);
  EXPECT_EQ(network.radio.statistics().bytes_sent, topics[0].bytes + topics[1].bytes);
}

TEST(Radio, DoesNotAllocateForRecycledMessages) {
  Network network(RadioConfig{}, 3);
  const std::vector<Message> messages = {message("odometry", 700), message("path", 400, 1)};
  std::uint64_t before = 0;
  std::size_t num_received = 0;
  for (int i = 0; i < 400; ++i) {
    if (i == 200) before = test::num_allocations();
    for (auto& inbox : network.inboxes) {
      num_received += inbox.size();
      network.radio.recycle(inbox);
    }
    for (VehicleId from = 0; from < 3; ++from) network.post(from, messages);
    network.ticks(3);
  }
  EXPECT_EQ(test::num_allocations(), before);
  EXPECT_GT(num_received, 2000U);
}

TEST(Radio, IsUnaffectedByAdditionalVehicle) {
  RadioConfig config;
  config.loss_probability = 0.3;
  config.jitter_s = 0.01;
  const auto received_by_second = [&](int num_vehicles) {
    Network network(config, num_vehicles);
    std::vector<TimeNs> times;
    for (int i = 0; i < 300; ++i) {
      for (VehicleId from = 0; from < num_vehicles; ++from) network.post(from, {message("a", 200)});
      network.ticks(5);
    }
    for (const Message& m : network.inboxes[1]) {
      if (m.from == 0) times.push_back(m.received);
    }
    return times;
  };
  const auto of_two = received_by_second(2);
  EXPECT_GT(of_two.size(), 150U);
  EXPECT_EQ(received_by_second(4), of_two);
}

}  // namespace
}  // namespace swiftlet::sim
