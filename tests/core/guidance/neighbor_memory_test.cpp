// SPDX-License-Identifier: BSD-3-Clause
#include "core/guidance/separation/neighbor_memory.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/neighbor_position.hpp"
#include "tests/support/sample_statistics.hpp"

namespace swiftlet {
namespace {

using Source = NeighborSourceConfig::Source;

/// Messages and measurements of one vehicle, tick by tick.
class Listener {
 public:
  explicit Listener(const NeighborSourceConfig& config, std::vector<NeighborView> views = {})
      : memory(config, std::move(views)) {
    at(Pose::Identity());
  }

  void at(const Pose& T_local_body) { estimate.T_local_body = T_local_body; }
  void sees(VehicleId id, const Vector3& p_body_m, double t_s, const Matrix3& covariance = 0.01 * Matrix3::Identity()) {
    observation.neighbors.push_back({from_seconds(t_s), id, p_body_m, covariance});
  }
  void hears(VehicleId from, const Vector3& p_world_m, double t_s) {
    Message& message = observation.messages.emplace_back();
    write_message(NeighborPosition{from_seconds(t_s), p_world_m}, message);
    message.from = from;
  }
  std::span<const Neighbor> update(double t_s) {
    observation.t = estimate.t = from_seconds(t_s);
    estimate.valid = true;
    poses.push(estimate);
    memory.update({.estimate = estimate, .observation = observation, .poses = poses, .tracks = tracks});
    observation.neighbors.clear();
    observation.messages.clear();
    return memory.neighbors();
  }

  NeighborMemory memory;
  StateEstimate estimate;
  Observation observation;
  LocalPoses poses;
  std::vector<Track> tracks;
};

NeighborSourceConfig from(Source source) {
  NeighborSourceConfig config;
  config.source = source;
  return config;
}

// Targets as the filter assumes them: the squared errors match the reported covariances.
TEST(NeighborMemory, ReportsConsistentCovariances) {
  NeighborSourceConfig config = from(Source::kSensor);
  config.acceleration_sigma_mps2 = 0.7;
  SampleStatistics squared_m, squared_mps;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const Random random(seed, "neighbor");
    Listener listener(config);
    const auto normal = [&](std::uint32_t k, std::uint32_t i) { return Vector3(random.normal3(k, i).data()); };
    Vector3 p_m(3.0, 0.0, 0.0), v_mps = config.first_speed_sigma_mps * normal(0, 0);
    double t_s = 0.0;
    for (std::uint32_t k = 0; k < 12; ++k) {
      const double dt_s = k == 0 ? 0.0 : 0.05 + 0.2 * random.uniform(k, 3), sigma_m = 0.1 + 0.2 * random.uniform(k, 4);
      const Vector3 a_mps2 = 0.7 * normal(k, 1);
      p_m += dt_s * v_mps + 0.5 * dt_s * dt_s * a_mps2;
      v_mps += dt_s * a_mps2;
      t_s += dt_s;
      listener.sees(1, p_m + sigma_m * normal(k, 2), t_s, sigma_m * sigma_m * Matrix3::Identity());
      listener.update(t_s);
    }
    const Neighbor known = listener.memory.neighbors()[0];
    const Vector3 error_m = known.position_local_m - p_m, error_mps = known.velocity_local_mps - v_mps;
    squared_m.add(error_m.dot(known.covariance_local_m2.inverse() * error_m));
    squared_mps.add(error_mps.dot(known.velocity_covariance_local_m2ps2.inverse() * error_mps));
  }
  // Chi-squared with three degrees of freedom: mean 3, variance 6.
  EXPECT_NEAR(squared_m.mean(), 3.0, mean_bound(std::sqrt(6.0), squared_m.size()));
  EXPECT_NEAR(squared_mps.mean(), 3.0, mean_bound(std::sqrt(6.0), squared_mps.size()));
}

TEST(NeighborMemory, ReportsBothPositionsAtLastSighting) {
  Listener listener(from(Source::kSensor));
  listener.at(make_pose({1.0, 0.0, 0.0}, Eigen::Quaterniond::Identity()));
  listener.sees(2, {5.0, 0.0, 0.0}, 0.1, 0.04 * Matrix3::Identity());
  listener.update(0.1);
  listener.at(make_pose({3.0, 0.0, 0.0}, Eigen::Quaterniond::Identity()));
  const Neighbor neighbor = listener.update(0.9).front();
  EXPECT_NEAR((neighbor.seen_local_m - Vector3(6.0, 0.0, 0.0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((neighbor.own_seen_local_m - Vector3(1.0, 0.0, 0.0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR(neighbor.seen_covariance_local_m2(0, 0), 0.04, 1e-9);
  EXPECT_GT(neighbor.covariance_local_m2(0, 0), 0.5) << "now it may be elsewhere";
}

TEST(NeighborMemory, EstimatesSampleLatencyAndPeriod) {
  Listener listener(from(Source::kSensor));
  EXPECT_EQ(listener.memory.timing().shortest_s, 0.0);
  for (int i = 1; i <= 40; ++i) {  // every half second, 0.2 s late; one is lost
    if (i % 5 == 2 && i != 22) listener.sees(2, {5.0, 0.0, 0.0}, 0.1 * i - 0.2);
    listener.update(0.1 * i);
  }
  EXPECT_NEAR(listener.memory.timing().latency_s, 0.2, 1e-6);
  EXPECT_NEAR(listener.memory.timing().shortest_s, 0.5, 1e-6);
  EXPECT_NEAR(listener.memory.timing().longest_s, 0.95, 0.11);
  for (int i = 41; i <= 600; ++i) {
    if (i % 5 == 2) listener.sees(2, {5.0, 0.0, 0.0}, 0.1 * i - 0.2);
    listener.update(0.1 * i);
  }
  EXPECT_NEAR(listener.memory.timing().longest_s, 0.5, 0.11) << "what was long ago is forgotten";
}

TEST(NeighborMemory, WeightsDirectionsByMeasurementAccuracy) {
  Listener listener(from(Source::kSensor));
  listener.sees(1, Vector3::Zero(), 0.0, Matrix3::Identity());
  listener.update(0.0);
  listener.sees(1, {1.0, 1.0, 1.0}, 0.0, Vector3(0.01, 1.0, 100.0).asDiagonal());
  const Vector3 p_m = listener.update(0.1)[0].position_local_m;
  EXPECT_NEAR(p_m.x(), 1.0 / 1.01, 1e-9);
  EXPECT_NEAR(p_m.y(), 0.5, 1e-9);
  EXPECT_NEAR(p_m.z(), 1.0 / 101.0, 1e-9);
}

TEST(NeighborMemory, CovarianceTurnsWithTheBody) {
  Listener listener(from(Source::kSensor));
  listener.at(make_pose({5.0, 0.0, 0.0}, Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * M_PI, Vector3::UnitZ()))));
  listener.update(0.0);
  listener.sees(1, {2.0, 0.0, 0.0}, 0.0, Matrix3::Identity());
  EXPECT_LT((listener.update(0.0)[0].position_local_m - Vector3(5.0, 2.0, 0.0)).norm(), 1e-9);
  // Sharp along the body's x, which is the world's y; blunt along the other.
  listener.sees(1, {3.0, 1.0, 0.0}, 0.0, Vector3(1e-6, 1e6, 1.0).asDiagonal());
  const Vector3 p_m = listener.update(0.0)[0].position_local_m;
  EXPECT_NEAR(p_m.x(), 5.0, 1e-3);
  EXPECT_NEAR(p_m.y(), 3.0, 1e-3);
}

TEST(NeighborMemory, PredictsToNow) {
  Listener listener(from(Source::kSensor));
  for (int i = 0; i <= 20; ++i) listener.sees(1, {0.2 * i, 0.0, 0.0}, 0.1 * i, 1e-8 * Matrix3::Identity());
  const auto known = listener.update(2.5);
  ASSERT_EQ(known.size(), 1U);
  EXPECT_NEAR(known[0].velocity_local_mps.x(), 2.0, 1e-3);
  EXPECT_NEAR(known[0].position_local_m.x(), 5.0, 2e-3);
  EXPECT_EQ(known[0].seen, from_seconds(2.0));
}

TEST(NeighborMemory, ForgetsNeighborsExactlyAfterTheTimeout) {
  NeighborSourceConfig config = from(Source::kSensor);
  config.timeout_s = 0.5;
  Listener listener(config);
  listener.sees(1, Vector3::UnitX(), 1.0);
  EXPECT_EQ(listener.update(1.0).size(), 1U);
  EXPECT_EQ(listener.update(1.5).size(), 1U);
  EXPECT_EQ(listener.update(1.51).size(), 0U);
}

NeighborView ahead_only() {
  NeighborView view;
  view.cones.push_back({Vector3::UnitX(), 0.0});
  return view;
}

TEST(NeighborMemory, RemembersNeighborsInTheBlindSector) {
  NeighborSourceConfig config = from(Source::kSensor);
  config.timeout_s = 0.5;
  for (const bool remember : {true, false}) {
    config.remember_hidden = remember;
    Listener listener(config, {ahead_only()});
    listener.sees(1, {-2.0, 0.0, 0.0}, 1.0);
    for (int i = 0; i <= 100; ++i) listener.update(1.0 + 0.1 * i);
    ASSERT_EQ(listener.memory.neighbors().size(), remember ? 1U : 0U);
    if (!remember) continue;
    EXPECT_FALSE(listener.memory.neighbors()[0].in_view);
    // A vehicle that turns and finds no neighbor there forgets it.
    listener.at(Pose(Eigen::AngleAxisd(3.14159, Vector3::UnitZ())));
    for (int i = 0; i <= 6; ++i) listener.update(11.1 + 0.1 * i);
    EXPECT_TRUE(listener.memory.neighbors().empty());
  }
}

TEST(NeighborMemory, ForgetsDistantNeighborsWithoutLostSamples) {
  NeighborSourceConfig config = from(Source::kSensor);
  config.timeout_s = 0.5;
  NeighborView near_ahead = ahead_only();
  near_ahead.range_max_m = 10.0;
  Listener listener(config, {near_ahead});
  listener.sees(1, {10.5, 0.0, 0.0}, 1.0);   // ahead, just out of range
  listener.sees(2, {-10.5, 0.0, 0.0}, 1.0);  // outside the field of view
  for (int i = 0; i <= 5; ++i) EXPECT_EQ(listener.update(1.0 + 0.1 * i).size(), 2U);
  const auto known = listener.update(1.6);
  ASSERT_EQ(known.size(), 1U);
  EXPECT_EQ(known[0].key, 2);
  EXPECT_EQ(listener.memory.timing().longest_s, 0.0);
}

TEST(NeighborMemory, GrowsUncertaintyOfUnseenNeighbors) {
  NeighborSourceConfig config = from(Source::kSensor);
  config.timeout_s = 100.0;
  Listener listener(config);
  for (int i = 0; i <= 20; ++i) {
    listener.sees(1, {3.0 + 0.1 * i, 0.0, 0.0}, 0.1 * i);
    listener.update(0.1 * i);
  }
  double last_m = 0.0;
  for (const double t_s : {2.5, 3.0, 4.0, 8.0}) {
    const Neighbor known = listener.update(t_s)[0];
    const double sigma_m = std::sqrt(known.covariance_local_m2(0, 0));
    EXPECT_GT(sigma_m, last_m);
    last_m = sigma_m;
    EXPECT_NEAR(known.position_local_m.x(), 5.0 + std::min(1.0, t_s - 2.0), 0.1) << "flies on for a second at most";
  }
  EXPECT_NEAR(listener.update(8.0)[0].velocity_local_mps.norm(), 0.0, 1e-12);
  EXPECT_EQ(listener.update(8.0)[0].unpredicted_s, 0.0);
}

TEST(NeighborMemory, IgnoresOutdatedSamples) {
  Listener listener(from(Source::kSensor));
  listener.sees(1, {1.0, 0.0, 0.0}, 1.0);
  listener.sees(1, {9.0, 0.0, 0.0}, 0.9);
  const auto known = listener.update(1.0);
  EXPECT_EQ(known[0].position_local_m, Vector3(1.0, 0.0, 0.0));
  EXPECT_EQ(known[0].seen, from_seconds(1.0));
}

TEST(NeighborMemory, KeepsNeighborsSeparateAndOrdered) {
  Listener listener(from(Source::kSensor));
  for (const VehicleId id : {7, 2, 5}) listener.sees(id, {1.0 * id, 0.0, 0.0}, 0.0);
  const auto known = listener.update(0.0);
  ASSERT_EQ(known.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(known[i].key, (std::vector<std::int64_t>{2, 5, 7}[i]));
    EXPECT_NEAR(known[i].position_local_m.x(), static_cast<double>(known[i].key), 1e-12);
  }
}

TEST(NeighborMemory, TransformsMessagesIntoTheLocalFrame) {
  Listener listener(from(Source::kRadio));
  listener.estimate.correct(make_pose({10.0, 0.0, 1.0}, Eigen::Quaterniond::Identity()));
  listener.hears(3, {12.0, 1.0, 4.0}, 0.0);
  const auto known = listener.update(0.0);
  ASSERT_EQ(known.size(), 1U);
  EXPECT_EQ(known[0].key, 3);
  EXPECT_LT((known[0].position_local_m - Vector3(2.0, 1.0, 3.0)).norm(), 1e-12);
  listener.hears(4, {NAN, 1.0, 4.0}, 0.0);
  EXPECT_EQ(listener.update(0.0).size(), 1U) << "a place that is not finite";
}

TEST(NeighborMemory, BroadcastsWorldPositionByRadioOnly) {
  for (const Source source : {Source::kRadio, Source::kSensor, Source::kTracks, Source::kNone}) {
    Listener listener(from(source));
    listener.at(make_pose({1.0, 2.0, 3.0}, Eigen::Quaterniond::Identity()));
    listener.estimate.correct(make_pose({10.0, 0.0, 1.0}, Eigen::Quaterniond::Identity()));
    listener.update(0.2);
    Outbox outbox;
    listener.memory.announce(listener.estimate, outbox);
    ASSERT_EQ(outbox.messages().size(), source == Source::kRadio ? 1U : 0U);
    if (source != Source::kRadio) continue;
    NeighborPosition sent;
    ASSERT_EQ(read_message(outbox.messages()[0], sent), Reading::kDone);
    EXPECT_LT((sent.p_world_m - Vector3(11.0, 2.0, 4.0)).norm(), 1e-12);
    EXPECT_EQ(sent.t, from_seconds(0.2));
  }
}

TEST(NeighborMemory, PredictsTracksToNow) {
  Listener listener(from(Source::kTracks));
  Track track;
  track.id = 11;
  track.t = from_seconds(1.0);
  track.position_m = {1.0, 0.0, 0.0};
  track.velocity_mps = {0.0, 2.0, 0.0};
  listener.tracks = {track};
  const auto known = listener.update(1.5);
  ASSERT_EQ(known.size(), 1U);
  EXPECT_EQ(known[0].key, 11);
  EXPECT_LT((known[0].position_local_m - Vector3(1.0, 1.0, 0.0)).norm(), 1e-12);
  EXPECT_EQ(known[0].velocity_local_mps, track.velocity_mps);
}

TEST(NeighborMemory, StaysEmptyWithoutASource) {
  Listener listener(from(Source::kNone));
  listener.sees(1, Vector3::UnitX(), 0.0);
  listener.hears(2, Vector3::UnitX(), 0.0);
  EXPECT_TRUE(listener.update(0.0).empty());
}

}  // namespace
}  // namespace swiftlet
