// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <numeric>

#include "core/tracking/cloud_tracker.hpp"

namespace swiftlet {
namespace {

/// Follows a cluster of points at 4 m/s along x for two seconds.
template <class Filter>
CloudTracker followed(Filter filter) {
  CloudTrackerConfig config;
  config.background = CloudTrackerConfig::Background::kNone;
  CloudTracker tracker(config, std::move(filter));
  for (int k = 0; k < 20; ++k) {
    Detection detection;
    detection.t = k * 100'000'000;
    detection.position_m = {10.0 + 0.4 * k, 0.0, 5.0};
    detection.covariance = 0.01 * Matrix3::Identity();
    tracker.new_detections({&detection, 1}, nullptr);
  }
  return tracker;
}

TEST(CloudTracker, ReportsBeliefsOfItsMotionModels) {
  const CloudTracker tracker = followed(make_imm_filter({}));
  std::vector<Track> tracks;
  std::vector<TrackModes> modes;
  tracker.publish(tracks);
  tracker.publish_modes(modes);
  ASSERT_FALSE(tracks.empty());
  ASSERT_EQ(modes.size(), tracks.size());
  EXPECT_EQ(modes[0].id, tracks[0].id);
  EXPECT_NEAR(std::accumulate(modes[0].probability.begin(), modes[0].probability.end(), 0.0), 1.0, 1e-9);
  Vector3 mixture_m = Vector3::Zero();
  for (std::size_t m = 0; m < TrackModes::kModels; ++m)
    mixture_m += modes[0].probability[m] * modes[0].mean_local_m[m].head<3>();
  EXPECT_LT((mixture_m - tracks[0].position_m).norm(), 1e-9);
}

TEST(CloudTracker, ReportsNoModesWithOneModel) {
  std::vector<TrackModes> modes(3);
  followed(make_kalman_filter({})).publish_modes(modes);
  EXPECT_TRUE(modes.empty());
}

}  // namespace
}  // namespace swiftlet
