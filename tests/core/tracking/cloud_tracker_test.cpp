// SPDX-License-Identifier: BSD-3-Clause
#include "core/tracking/cloud_tracker.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/bench/reference_tracking.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/config_checks.hpp"
#include "tests/support/target_clouds.hpp"

namespace swiftlet {
namespace {

using testing::CloudMaker;
using testing::detection_at;
using testing::ListedBackground;

constexpr TimeNs kScan = 100'000'000;

CloudTracker make(const CloudTrackerConfig& config = {}) { return {config, make_kalman_filter({})}; }

CloudTrackerConfig reported_at_once() {
  CloudTrackerConfig config;
  config.min_detections = 1;
  return config;
}

std::vector<Track> tracks_of(const CloudTracker& tracker) {
  std::vector<Track> tracks;
  tracker.publish(tracks);
  return tracks;
}

TEST(CloudTracker, FollowsTargetFromSingleDetection) {
  CloudTracker tracker = make(reported_at_once());
  const Vector3 v(4.0, -1.0, 0.3);
  const auto truth = [&](TimeNs t) { return Vector3(Vector3(6, 10, 5) + v * to_seconds(t)); };
  for (TimeNs t = kScan; t <= 40 * kScan; t += kScan) {
    tracker.new_cloud(CloudMaker(t).add_target(truth(t), 0.3).make(), nullptr);
    if (t == kScan) {
      const Detection detection = detection_at(truth(t), t);
      tracker.new_detections({&detection, 1}, nullptr);
    }
  }
  const auto tracks = tracks_of(tracker);
  ASSERT_EQ(tracks.size(), 1U);
  EXPECT_EQ(tracks[0].t, 40 * kScan);
  EXPECT_TRUE(tracks[0].corrected);
  EXPECT_LT((tracks[0].position_m - truth(40 * kScan)).norm(), 0.3) << "no more than the sampling bias";
  EXPECT_LT((tracks[0].velocity_mps - v).norm(), 0.15);
}

// The track of one of two neighboring targets carries the marker's reflectivity and the measured position.
TEST(CloudTracker, ReportsBrightestReturnAndMeasurementPosition) {
  CloudTracker tracker = make(reported_at_once());
  const auto marked = [](TimeNs t) { return Vector3(8.0, 0.5 * to_seconds(t), 5.0); };
  const auto plain = [](TimeNs t) { return Vector3(8.0, 1.5 + 0.5 * to_seconds(t), 5.0); };
  for (TimeNs t = kScan; t <= 10 * kScan; t += kScan) {
    CloudMaker maker(t);
    maker.add_target(marked(t), 0.2, 12).add_target(plain(t), 0.2, 12).add(marked(t), 0.0, 18.0);
    if (t < 10 * kScan) maker.add(plain(t), 0.0, 0.3);
    tracker.new_cloud(maker.make(), nullptr);
    if (t > kScan) continue;
    const Detection detections[] = {detection_at(marked(t), t), detection_at(plain(t), t)};
    tracker.new_detections(detections, nullptr);
  }
  const auto tracks = tracks_of(tracker);
  ASSERT_EQ(tracks.size(), 2U);
  for (const Track& track : tracks) {
    const bool is_marked = (track.position_m - marked(10 * kScan)).norm() < 0.5;
    EXPECT_EQ(track.reflectivity, is_marked ? 18.0 : 0.0) << "reflectivity of the newest measurement";
    const Vector3 truth = is_marked ? marked(10 * kScan) : plain(10 * kScan);
    EXPECT_LT((track.measured_m - truth).norm(), 0.2);
    EXPECT_NEAR(track.measured_covariance(0, 0), 0.09, 1e-12);
  }
}

// Two parts 0.4 m apart: with d_cluster of Table II the track sits on one of them.
TEST(CloudTracker, TracksCenterOfMultipartTarget) {
  for (const double cluster_distance_m : {CloudTrackerConfig{}.cluster_distance_m, 0.25}) {
    CloudTrackerConfig config = reported_at_once();
    config.cluster_distance_m = cluster_distance_m;
    CloudTracker tracker = make(config);
    const auto truth = [&](TimeNs t) { return Vector3(8.0, 0.5 * to_seconds(t), 5.0); };
    double error_m = 0.0;
    for (TimeNs t = kScan; t <= 40 * kScan; t += kScan) {
      CloudMaker maker(t);
      for (const double side : {-0.3, 0.3}) maker.add_target(truth(t) + side * Vector3::UnitY(), 0.1, 6);
      tracker.new_cloud(maker.make(), nullptr);
      if (t == kScan) {
        const Detection detection = detection_at(truth(t), t);
        tracker.new_detections({&detection, 1}, nullptr);
      }
      for (const Track& track : tracks_of(tracker)) error_m = std::max(error_m, (track.position_m - truth(t)).norm());
    }
    EXPECT_EQ(error_m<0.2, cluster_distance_m> 0.5) << cluster_distance_m << ": " << error_m;
  }
}

TEST(CloudTracker, IsAlgorithm2AsPrinted) {
  CloudTrackerConfig printed = reported_at_once();
  printed.assignment = CloudTrackerConfig::Assignment::kNearest;
  printed.association_radius_min_m = 0.0;
  printed.merge_radius_max_m = 0.0;
  printed.max_size_m = 0.0;
  printed.cluster_distance_m = 0.25;
  CloudTracker tracker = make(printed);
  reference::PlainTracker plain;
  ListedBackground background;
  background.centers_m = {{30, 0, 4}, {-20, -20, 4}};

  // Targets that come from far apart; one passes the background, one stays away for a while; and clutter.
  const Random random(7, "test.algorithm2");
  const auto target = [](int i, double t) {
    const Vector3 start(14.0 * i - 20.0, 8.0 * (i % 3) - 10.0, 4.0 + i);
    return Vector3(start + Vector3(std::sin(0.7 * t + i), 1.5 * std::cos(0.5 * t), 0.3 * t));
  };
  for (int k = 1; k <= 60; ++k) {
    const TimeNs t = k * kScan;
    const double t_s = to_seconds(t);
    CloudMaker maker(t);
    for (int i = 0; i < 4; ++i) {
      if (i == 2 && k > 20 && k < 50) continue;
      maker.add_target(target(i, t_s), 0.3, 25);
    }
    maker.add_target({31.0 - 0.05 * k, 0, 4}, 0.2, 10);
    for (std::uint32_t j = 0; j < 30; ++j) {
      const auto r = random.normal3(k, j);
      maker.add({20 * r[0], 20 * r[1], 5 + 3 * r[2]});
    }
    const LocalCloud cloud = maker.make();
    tracker.new_cloud(cloud, &background);
    plain.new_point_cloud(cloud, background);
    std::vector<Detection> detections;  // some of them up to four clouds old
    for (int i = 0; i < 4; ++i) {
      const TimeNs t_detected = t - kScan * ((k + i) % 5);
      if (k > 5 && (k + i) % 3 == 0) detections.push_back(detection_at(target(i, to_seconds(t_detected)), t_detected));
    }
    tracker.new_detections(detections, &background);
    plain.new_detections(detections, background);

    const auto ours = tracks_of(tracker);
    for (const Track& track : ours) {
      double least_m = 1e300;
      const reference::PlainTrack* same = nullptr;
      for (const reference::PlainTrack& other : plain.tracks) {
        const double distance_m = (other.x.head<3>() - track.position_m).norm();
        if (distance_m < least_m) least_m = distance_m, same = &other;
      }
      ASSERT_NE(same, nullptr) << k;
      EXPECT_LT(least_m, 1e-4) << k;
      EXPECT_LT((same->P - track.covariance).norm(), 1e-4) << k;
      EXPECT_LT((same->x.segment<3>(3) - track.velocity_mps).norm(), 1e-3) << k;
    }
    ASSERT_EQ(ours.size(), plain.tracks.size()) << k;
  }
}

TEST(CloudTracker, TreatsLateDetectionLikeEarlyOne) {
  const auto truth = [](TimeNs t) { return Vector3(8.0 + 5.0 * to_seconds(t), 3.0, 5.0); };
  CloudTracker early = make(reported_at_once()), late = make(reported_at_once());
  const Detection detection = detection_at(truth(3 * kScan), 3 * kScan);
  for (int k = 1; k <= 9; ++k) {
    const LocalCloud cloud = CloudMaker(k * kScan).add_target(truth(k * kScan)).make();
    early.new_cloud(cloud, nullptr);
    late.new_cloud(cloud, nullptr);
    if (k == 3) early.new_detections({&detection, 1}, nullptr);
  }
  late.new_detections({&detection, 1}, nullptr);
  const auto a = tracks_of(early), b = tracks_of(late);
  ASSERT_EQ(a.size(), 1U);
  ASSERT_EQ(b.size(), 1U);
  EXPECT_EQ(a[0].t, b[0].t);
  EXPECT_EQ(a[0].position_m, b[0].position_m);
  EXPECT_EQ(a[0].covariance, b[0].covariance);
  EXPECT_LT((b[0].position_m - truth(9 * kScan)).norm(), 0.6) << "though detected 3 m from there";
}

TEST(CloudTracker, CountsWhatCameTooLate) {
  CloudTrackerConfig config = reported_at_once();
  config.buffer_size = 3;
  CloudTracker tracker = make(config);
  const auto count_of = [&](const std::string& setting) {
    std::vector<Counter> counters;
    tracker.append_counters(counters);
    const auto found =
        std::find_if(counters.begin(), counters.end(), [&](const Counter& c) { return c.setting == setting; });
    return found == counters.end() ? std::uint64_t{999} : found->count;
  };
  const Vector3 place(5, 5, 5);
  for (TimeNs t = kScan; t <= 5 * kScan; t += kScan) {
    tracker.new_cloud(CloudMaker(t).add_target(place, 0.3).make(), nullptr);
  }
  EXPECT_EQ(count_of("sensor"), 0U);
  tracker.new_cloud(CloudMaker(4 * kScan).add_target(place, 0.3).make(), nullptr);
  EXPECT_EQ(count_of("sensor"), 1U);

  const Detection buffered = detection_at(place, 3 * kScan), too_old = detection_at(place, 2 * kScan);
  tracker.new_detections({&buffered, 1}, nullptr);
  EXPECT_EQ(count_of("buffer_size"), 0U);
  tracker.new_detections({&too_old, 1}, nullptr);
  EXPECT_EQ(count_of("buffer_size"), 1U);
}

TEST(CloudTracker, AssignsLateDetectionToTrackedTarget) {
  const auto truth = [](TimeNs t) { return Vector3(8.0 + 5.0 * to_seconds(t), 3.0, 5.0); };
  CloudTracker tracker = make(reported_at_once());
  for (int k = 1; k <= 20; ++k) {
    tracker.new_cloud(CloudMaker(k * kScan).add_target(truth(k * kScan)).make(), nullptr);
    if (k < 5) continue;
    const Detection detection = detection_at(truth((k - 4) * kScan), (k - 4) * kScan);
    tracker.new_detections({&detection, 1}, nullptr);
  }
  const auto tracks = tracks_of(tracker);
  ASSERT_EQ(tracks.size(), 1U);
  EXPECT_EQ(tracks[0].num_detections, 16);
}

TEST(CloudTracker, ForgetsDetectionsWithoutSupportingReturns) {
  CloudTrackerConfig config = reported_at_once();
  config.buffer_size = 40;
  CloudTracker tracker = make(config);
  for (int k = 1; k <= 40; ++k) tracker.new_cloud(CloudMaker(k * kScan).add({50, 50, 50}).make(), nullptr);
  const Detection old = detection_at({5, 5, 5}, kScan), fresh = detection_at({5, 5, 5}, 40 * kScan);
  tracker.new_detections({&old, 1}, nullptr);
  EXPECT_EQ(tracker.num_tracks(), 0) << "lost on the way to the newest cloud";
  tracker.new_detections({&fresh, 1}, nullptr);
  EXPECT_EQ(tracker.num_tracks(), 1);
}

TEST(CloudTracker, EndsUnmeasuredTrackAtRadiusLimit) {
  CloudTracker tracker = make(reported_at_once());
  const Vector3 p(8, 3, 5);
  int k = 1;
  for (; k <= 20; ++k) {
    tracker.new_cloud(CloudMaker(k * kScan).add_target(p).make(), nullptr);
    const Detection detection = detection_at(p, k * kScan);
    if (k == 1) tracker.new_detections({&detection, 1}, nullptr);
  }
  int lasted = 0;
  double radius_m = 0.0;
  for (; tracker.num_tracks() > 0 && lasted < 1000; ++k, ++lasted) {
    radius_m = tracker.uncertainty_radius_m(tracks_of(tracker)[0].covariance.topLeftCorner<3, 3>());
    EXPECT_LE(radius_m, CloudTrackerConfig{}.radius_max_m);
    tracker.new_cloud(CloudMaker(k * kScan).add({50, 50, 50}).make(), nullptr);
  }
  EXPECT_GT(radius_m, 0.7 * CloudTrackerConfig{}.radius_max_m);
  EXPECT_GT(lasted, 10) << "a track outlasts a second behind a tree";
  EXPECT_LT(lasted, 40) << "a ghost must not stay";
}

TEST(CloudTracker, ReacquiresReturningTarget) {
  CloudTracker tracker = make(reported_at_once());
  const Vector3 p(8, 3, 5);
  std::uint32_t first_id = 0;
  for (int k = 1; k <= 80; ++k) {
    const bool hidden = k > 20 && k <= 60;
    CloudMaker maker(k * kScan);
    maker.add({50, 50, 50});
    if (!hidden) maker.add_target(p);
    tracker.new_cloud(maker.make(), nullptr);
    const Detection detection = detection_at(p, k * kScan);
    if (!hidden) tracker.new_detections({&detection, 1}, nullptr);
    const auto tracks = tracks_of(tracker);
    if (k == 20) first_id = tracks.at(0).id;
    if (k == 60) {
      EXPECT_TRUE(tracks.empty());
    }
  }
  const auto tracks = tracks_of(tracker);
  ASSERT_EQ(tracks.size(), 1U);
  EXPECT_GT(tracks[0].id, first_id) << "identities are not used twice";
}

TEST(CloudTracker, TracksOfOneTargetBecomeOne) {
  CloudTrackerConfig config = reported_at_once();
  config.association_radius_min_m = 0.0;
  CloudTracker tracker = make(config);
  const Vector3 p(8, 3, 5);
  const std::vector<Detection> twice = {detection_at(p + Vector3(0, 0.8, 0), kScan),
                                        detection_at(p - Vector3(0, 0.8, 0), kScan)};
  tracker.new_cloud(CloudMaker(kScan).add_target(p).make(), nullptr);
  tracker.new_detections(twice, nullptr);
  EXPECT_EQ(tracker.num_tracks(), 2);
  for (int k = 2; k <= 30; ++k) tracker.new_cloud(CloudMaker(k * kScan).add_target(p).make(), nullptr);
  ASSERT_EQ(tracker.num_tracks(), 1);
  EXPECT_LT((tracks_of(tracker)[0].position_m - p).norm(), 0.35);
}

TEST(CloudTracker, BackgroundCorrectsNoTrack) {
  const Vector3 p(8, 3, 5);
  using Background = CloudTrackerConfig::Background;
  for (const auto rule : {Background::kMap, Background::kCloud, Background::kNone}) {
    CloudTrackerConfig config = reported_at_once();
    config.background = rule;
    CloudTracker tracker = make(config);
    ListedBackground wall;
    const Detection detection = detection_at(p, kScan);
    tracker.new_cloud(CloudMaker(kScan).add_target(p).make(), &wall);
    tracker.new_detections({&detection, 1}, &wall);
    // Only a pole 1.6 m beside the position, contained in the map.
    CloudMaker maker(2 * kScan);
    for (int i = 0; i < 100; ++i) {
      const Vector3 on_pole = p + Vector3(0.0, 1.6, -5.0 + 0.1 * i);
      maker.add(on_pole);
      wall.centers_m.push_back(on_pole);
    }
    tracker.new_cloud(maker.make(), &wall);
    const bool corrected = tracks_of(tracker).at(0).corrected;
    EXPECT_EQ(corrected, false) << static_cast<int>(rule) << ": a pole of 3.8 m is no target either";
    // A small object beside it that the map contains, without other points around.
    wall.centers_m = {p + Vector3(0, 1.5, 0)};
    tracker.new_cloud(CloudMaker(3 * kScan).add_target(p + Vector3(0, 1.0, 0), 0.2).make(), &wall);
    EXPECT_EQ(tracks_of(tracker).at(0).corrected, rule != Background::kMap) << static_cast<int>(rule);
    // Such an object with other points around it.
    tracker.new_cloud(CloudMaker(4 * kScan).add_target(p, 0.2).add(p + Vector3(0, 0, 0.9)).make(), nullptr);
    EXPECT_EQ(tracks_of(tracker).at(0).corrected, rule != Background::kCloud) << static_cast<int>(rule);
  }
}

/// Two targets that cross at a distance; how often a track ends on the other one.
int swaps_at_a_crossing(CloudTrackerConfig::Assignment assignment, double miss_m) {
  int swaps = 0;
  for (int trial = 0; trial < 10; ++trial) {
    CloudTrackerConfig config = reported_at_once();
    config.assignment = assignment;
    CloudTracker tracker = make(config);
    const double speed = 1.0 + 0.2 * trial;
    const auto a = [&](double t) { return Vector3(speed * (t - 4.0), 10.0, 5.0 + 0.5 * miss_m); };
    const auto b = [&](double t) { return Vector3(-speed * (t - 4.0), 10.0, 5.0 - 0.5 * miss_m); };
    for (int k = 1; k <= 80; ++k) {
      const double t = 0.1 * k;
      // Near the crossing the one behind is hidden now and then.
      CloudMaker maker(k * kScan);
      maker.add_target(a(t), 0.25, 20);
      if (std::abs(t - 4.0) > 0.3) maker.add_target(b(t), 0.25, 20);
      tracker.new_cloud(maker.make(), nullptr);
      const std::vector<Detection> detections = {detection_at(a(t), k * kScan), detection_at(b(t), k * kScan)};
      if (k <= 3) tracker.new_detections(detections, nullptr);
    }
    const auto tracks = tracks_of(tracker);
    const bool kept = tracks.size() == 2 && (tracks[0].position_m - a(8.0)).norm() < 1.0 &&
                      (tracks[1].position_m - b(8.0)).norm() < 1.0;
    swaps += !kept;
  }
  return swaps;
}

TEST(CloudTracker, CrossingTargetsKeepTheirTracks) {
  const int exclusive = swaps_at_a_crossing(CloudTrackerConfig::Assignment::kExclusive, 1.0),
            nearest = swaps_at_a_crossing(CloudTrackerConfig::Assignment::kNearest, 1.0);
  RecordProperty("exclusive", exclusive);
  RecordProperty("nearest", nearest);
  EXPECT_EQ(exclusive, 0);
  EXPECT_LE(exclusive, nearest);
}

TEST(CloudTracker, KeepsHiddenTargetOffItsNeighbor) {
  CloudTracker tracker = make(reported_at_once());
  const Vector3 a(10, 0, 5), b(10, 1.8, 5);
  for (int k = 1; k <= 30; ++k) {
    CloudMaker maker(k * kScan);
    maker.add_target(a);
    if (k <= 20) maker.add_target(b);
    tracker.new_cloud(maker.make(), nullptr);
    const std::vector<Detection> both = {detection_at(a, k * kScan), detection_at(b, k * kScan)};
    if (k == 1) tracker.new_detections(both, nullptr);
  }
  const auto tracks = tracks_of(tracker);
  ASSERT_EQ(tracks.size(), 2U);
  EXPECT_TRUE(tracks[0].corrected);
  EXPECT_LT((tracks[0].position_m - a).norm(), 0.35);
  EXPECT_FALSE(tracks[1].corrected);
  EXPECT_LT((tracks[1].position_m - b).norm(), 0.6);
}

TEST(CloudTracker, AnyNumberOfTargets) {
  CloudTracker tracker = make(reported_at_once());
  const auto place = [](int i) { return Vector3(6.0 * (i % 10) - 27.0, 6.0 * (i / 10) - 27.0, 8.0); };
  for (int k = 1; k <= 10; ++k) {
    CloudMaker maker(k * kScan);
    std::vector<Detection> detections;
    for (int i = 0; i < 100; ++i) {
      maker.add_target(place(i), 0.3, 8);
      detections.push_back(detection_at(place(i), k * kScan));
    }
    tracker.new_cloud(maker.make(), nullptr);
    if (k == 1) tracker.new_detections(detections, nullptr);
  }
  const auto tracks = tracks_of(tracker);
  ASSERT_EQ(tracks.size(), 100U);
  for (const Track& track : tracks) {
    EXPECT_TRUE(track.corrected);
    EXPECT_EQ(track.id, static_cast<std::uint32_t>(&track - tracks.data()) + 1);
  }
}

// A sweep of 100 ms sees a target of 8 m/s at one moment of it: the track holds for that moment, not for the stamp.
TEST(CloudTracker, StampsTracksWhenTargetIsSeen) {
  CloudTracker tracker = make(reported_at_once());
  const auto truth = [](double t) { return Vector3(-10.0 + 8.0 * t, 12.0, 5.0); };
  for (int k = 1; k <= 30; ++k) {
    const double offset_s = 0.02 + 0.06 * (k % 7) / 7.0, seen_s = 0.1 * k + offset_s;
    tracker.new_cloud(CloudMaker(k * kScan, kScan).add_target(truth(seen_s), 0.1, 20, offset_s).make(), nullptr);
    Detection detection = detection_at(truth(seen_s), from_seconds(seen_s));
    if (k <= 2) tracker.new_detections({&detection, 1}, nullptr);
    if (k < 20) continue;
    const Track track = tracks_of(tracker).at(0);
    EXPECT_NEAR(to_seconds(track.t), seen_s, 1e-6);
    EXPECT_LT((track.position_m - truth(to_seconds(track.t))).norm(), 0.12);
  }
}

TEST(CloudTracker, SigmaWPenalizesRangeAndSize) {
  CloudTrackerConfig config = reported_at_once();
  config.measurement.noise = TrackMeasurementConfig::Noise::kSigmaW;
  config.measurement.sensor.sigma_attitude_rad.setConstant(0.02);
  const auto covariance_at = [&](const Vector3& p) {
    CloudTracker tracker = make(config);
    const Detection detection = detection_at(p, kScan);
    for (int k = 1; k <= 20; ++k) {
      tracker.new_cloud(CloudMaker(k * kScan).add_target(p, 0.1).make(), nullptr);
      if (k == 1) tracker.new_detections({&detection, 1}, nullptr);
    }
    return Matrix3(tracks_of(tracker).at(0).covariance.topLeftCorner<3, 3>());
  };
  const Matrix3 near = covariance_at({5, 0, 0}), far = covariance_at({50, 0, 0});
  EXPECT_GT(far(1, 1), 4.0 * near(1, 1)) << "1 m of sideways error at 50 m";
  EXPECT_LT(far(0, 0), 1.5 * near(0, 0)) << "the range is as good as ever";
}

TEST(CloudTracker, SurvivesAnyCloud) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  CloudTracker tracker = make(reported_at_once());
  const Vector3 p(8, 3, 5);
  TimeNs t = 0;
  const auto feed = [&](LocalCloud cloud) {
    tracker.new_cloud(cloud, nullptr);
    for (const Track& track : tracks_of(tracker)) EXPECT_TRUE(track.position_m.allFinite());
  };
  const auto next = [&] { return CloudMaker(t += kScan); };
  feed(next().add_target(p).make());
  const Detection good = detection_at(p, t), bad = detection_at({nan, 0, 0}, t),
                  far = detection_at({1e30, -1e30, 1e300}, t);
  tracker.new_detections(std::vector{bad, far, good}, nullptr);
  feed(next().make());         // empty
  feed(next().add(p).make());  // one point
  feed(next().add({nan, 0, 0}).add(p).add({0, infinity, 0}).add({-infinity, nan, nan}).make());
  feed(next().add({nan, nan, nan}).make());
  feed(next().add({3e38, -3e38, 3e38}).add(p).make());
  CloudMaker duplicates = next();
  for (int i = 0; i < 300'000; ++i) duplicates.add(p);
  feed(duplicates.make());
  feed(CloudMaker(t).add_target(p).make());              // repeated time
  feed(CloudMaker(t - 5 * kScan).add_target(p).make());  // an old one
  const Random random(1, "test.fuzz");
  for (std::uint32_t trial = 0; trial < 200; ++trial) {
    CloudMaker maker = next();
    const int n = static_cast<int>(200 * random.uniform(trial, 0));
    for (int i = 0; i < n; ++i) {
      const auto r = random.normal3(trial, 10 + i);
      const double scale = std::pow(10.0, random.uniform(-3.0, trial % 5 == 0 ? 38.0 : 1.5, trial, 1000 + i));
      maker.add(p + scale * Vector3(r[0], r[1], r[2]));
    }
    feed(maker.make());
    const Detection detection = detection_at(p, t - static_cast<TimeNs>(3 * kScan * random.uniform(trial, 5)));
    if (trial % 3 == 0) tracker.new_detections({&detection, 1}, nullptr);
  }
  t += 3600 * kNsPerSecond;  // an hour without a cloud
  feed(next().add({50, 50, 50}).make());
}

TEST(CloudTracker, AllocatesNothingOnceWarm) {
  CloudTracker tracker = make(reported_at_once());
  std::vector<LocalCloud> clouds;
  std::vector<Detection> detections;
  for (int k = 1; k <= 60; ++k) {
    clouds.push_back(CloudMaker(k * kScan).add_target({8, 3, 5}).add_target({8, -9, 5}).add({0, 30, 0}).make());
    detections.push_back(detection_at({8, 3, 5}, (k - 1) * kScan));
    detections.push_back(detection_at({8, -9, 5}, (k - 1) * kScan));
  }
  std::vector<Track> tracks;
  std::uint64_t before = 0;
  for (int k = 0; k < 60; ++k) {
    if (k == 20) before = test::num_allocations();
    tracker.new_cloud(clouds[k], nullptr);
    tracker.new_detections(std::span(detections).subspan(2 * k, 2), nullptr);
    tracker.publish(tracks);
  }
  EXPECT_EQ(test::num_allocations() - before, 0U);
  EXPECT_EQ(tracks.size(), 2U);
}

TEST(CloudTrackerConfig, RequiresSearchRadiusForLargestSphere) {
  CloudTrackerConfig config;
  EXPECT_TRUE(test::ConfigChecks(config).problems().empty());
  config.radius_max_m = 2.4;
  EXPECT_TRUE(test::ConfigChecks(config).problems().empty()) << "the printed radius is no length";
  config.radius_law = CloudTrackerConfig::RadiusLaw::kSphere;
  EXPECT_TRUE(test::ConfigChecks(config).refuses("radius_max_m"));
  config.radius_max_m = 2.5;
  EXPECT_TRUE(test::ConfigChecks(config).problems().empty());
}

}  // namespace
}  // namespace swiftlet
