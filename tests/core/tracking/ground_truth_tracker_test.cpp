// SPDX-License-Identifier: BSD-3-Clause
// The bypass that takes its tracks from the mutual-localization sensor.
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/tracking/trackers.hpp"

namespace swiftlet {
namespace {

constexpr TimeNs kSamplePeriod = 100'000'000;

/// A vehicle at a fixed pose, and the samples of its sensor.
struct Watcher {
  explicit Watcher(const GroundTruthTrackerConfig& config) : tracker(make_ground_truth_tracker(config, {})) {
    estimate.valid = true;
    estimate.T_local_body = make_pose({1, 2, 3}, rotation_by({0, 0, 0.5 * std::numbers::pi}));
  }
  bool step(TimeNs t, std::initializer_list<NeighborSample> samples) {
    Observation observation;
    observation.t = estimate.t = t;
    observation.neighbors = samples;
    Outbox outbox;
    return tracker->step({observation, estimate}, tracks, outbox);
  }
  static NeighborSample seen(TimeNs t, VehicleId id, const Vector3& p_body_m) {
    return {t, id, p_body_m, 1e-4 * Matrix3::Identity()};
  }

  std::unique_ptr<Tracker> tracker;
  StateEstimate estimate;
  std::vector<Track> tracks;
};

TEST(GroundTruthTracker, FollowsEachNeighborByItsName) {
  Watcher watcher({});
  for (int k = 0; k < 30; ++k) {
    const TimeNs t = k * kSamplePeriod;
    ASSERT_TRUE(watcher.step(t, {Watcher::seen(t, 7, {10.0 + 0.2 * k, 0, 0}), Watcher::seen(t, 4, {0, 5, 0})}));
  }
  ASSERT_EQ(watcher.tracks.size(), 2U);
  EXPECT_EQ(watcher.tracks[0].id, 5U);
  EXPECT_EQ(watcher.tracks[1].id, 8U);
  const Track& track = watcher.tracks[1];
  EXPECT_EQ(track.t, 29 * kSamplePeriod);
  EXPECT_EQ(track.num_detections, 30);
  EXPECT_TRUE(track.corrected);
  // Forward is along y of the local frame, at 2 m/s.
  EXPECT_LT((track.position_m - Vector3(1, 2 + 15.8, 3)).norm(), 0.05);
  EXPECT_LT((track.velocity_mps - Vector3(0, 2, 0)).norm(), 0.2);
  EXPECT_LT((track.measured_m - Vector3(1, 2 + 15.8, 3)).norm(), 1e-9);
  EXPECT_GE(track.measured_covariance(0, 0), 1e-4) << "never surer than the sensor";
}

TEST(GroundTruthTracker, HoldsBetweenSamplesUntilItsTimeout) {
  GroundTruthTrackerConfig config;
  config.timeout_s = 0.5;
  Watcher watcher(config);
  ASSERT_TRUE(watcher.step(0, {Watcher::seen(0, 1, {10, 0, 0})}));
  EXPECT_FALSE(watcher.step(1'000'000, {}));
  EXPECT_FALSE(watcher.step(500'000'000, {})) << "as old as it may be";
  EXPECT_EQ(watcher.tracks.size(), 1U);
  EXPECT_TRUE(watcher.step(500'000'001, {}));
  EXPECT_TRUE(watcher.tracks.empty());
  EXPECT_FALSE(watcher.step(600'000'000, {}));
}

TEST(GroundTruthTracker, IgnoresFarInvalidOrOlderSamples) {
  GroundTruthTrackerConfig config;
  config.range_max_m = 20.0;
  Watcher watcher(config);
  EXPECT_FALSE(watcher.step(0, {Watcher::seen(0, 1, {20.1, 0, 0})}));
  EXPECT_FALSE(watcher.step(0, {Watcher::seen(0, 1, {std::numeric_limits<double>::quiet_NaN(), 0, 0})}));
  EXPECT_TRUE(watcher.step(kSamplePeriod, {Watcher::seen(kSamplePeriod, 1, {19.9, 0, 0})}));
  ASSERT_EQ(watcher.tracks.size(), 1U);
  watcher.step(2 * kSamplePeriod, {Watcher::seen(0, 1, {5, 0, 0})});
  EXPECT_EQ(watcher.tracks[0].t, kSamplePeriod);
  EXPECT_EQ(watcher.tracks[0].num_detections, 1);
}

}  // namespace
}  // namespace swiftlet
