// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "core/tracking/cloud_tracker.hpp"
#include "swiftlet/core/detection/euclidean_clusters.hpp"
#include "tests/bench/reference_tracking.hpp"
#include "tests/support/target_clouds.hpp"

namespace swiftlet {
namespace {

using testing::CloudMaker;
using testing::detection_at;

constexpr TimeNs kScan = 100'000'000;
constexpr int kTargets = 5;

Vector3 target_at(int i, double t) {
  return {(8.0 + 2.0 * i) * std::cos(1.2 * i + 0.3 * t), (8.0 + 2.0 * i) * std::sin(1.2 * i + 0.3 * t), 1.0 + 0.5 * i};
}

/// Returns of an OS1-128 (1024 x 128, 45 degrees) 3 m above a floor within a round wall of 30 m, with five targets:
/// nearly every beam returns, row by row in the order of the sensor.
LocalCloud ouster_cloud(int k) {
  const double t = 0.1 * k;
  CloudMaker maker(k * kScan);
  for (int row = 0; row < 128; ++row) {
    const double elevation = (22.5 - 45.0 * row / 127.0) * std::numbers::pi / 180.0;
    for (int column = 0; column < 1024; ++column) {
      const double azimuth = 2.0 * std::numbers::pi * column / 1024.0;
      const Vector3 d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                      std::sin(elevation));
      double range_m = 30.0 / std::cos(elevation);
      if (d.z() < 0.0) range_m = std::min(range_m, -3.0 / d.z());
      for (int i = 0; i < kTargets; ++i) {  // a ball of 0.35 m
        const Vector3 c = target_at(i, t);
        const double along = c.dot(d), miss_sq = c.squaredNorm() - along * along;
        if (along > 0.0 && miss_sq < 0.35 * 0.35) range_m = std::min(range_m, along - std::sqrt(0.35 * 0.35 - miss_sq));
      }
      maker.add(range_m * d);
    }
  }
  return maker.make();
}

/// Floor and wall as a map of voxels in closed form.
struct Hall : BackgroundQuery {
  bool occupied_within(const Vector3& p, double radius_m) const override {
    return p.z() + 3.0 < radius_m || 30.0 - p.head<2>().norm() < radius_m;
  }
};

struct Recording {
  std::vector<LocalCloud> clouds;
  std::vector<std::vector<Detection>> detections;
  Recording() {
    for (int k = 1; k <= 20; ++k) {
      clouds.push_back(ouster_cloud(k));
      detections.emplace_back();
      for (int i = 0; i < kTargets; ++i) detections.back().push_back(detection_at(target_at(i, 0.1 * k), k * kScan));
    }
  }
};

const Recording& recording() {
  static const Recording recorded;
  return recorded;
}

CloudTrackerConfig published_at_once() {
  CloudTrackerConfig config;
  config.min_detections = 1;
  return config;
}

/// newPointCloud() with five tracks.
void new_cloud(benchmark::State& state, bool imm) {
  const Recording& r = recording();
  CloudTracker tracker(published_at_once(), imm ? make_imm_filter({}) : make_kalman_filter({}));
  const Hall hall;
  tracker.new_cloud(r.clouds[0], &hall);
  tracker.new_detections(r.detections[0], &hall);
  int k = 0, direction = 1;
  TimeNs t = r.clouds[0].stamp();
  auto clouds = r.clouds;
  std::vector<std::shared_ptr<Scan>> scans;
  for (LocalCloud& cloud : clouds) {
    scans.push_back(std::make_shared<Scan>(*cloud.scan));
    cloud.scan = scans.back();
  }
  for (auto _ : state) {
    if (k + direction < 0 || k + direction >= static_cast<int>(clouds.size())) direction = -direction;
    k += direction;  // back and forth, so that targets never jump
    scans[k]->stamp = t += kScan;
    tracker.new_cloud(clouds[k], &hall);
  }
  if (tracker.num_tracks() != kTargets) std::abort();
  state.counters["points"] = static_cast<double>(clouds[0].size());
}
BENCHMARK_CAPTURE(new_cloud, kalman, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(new_cloud, imm, true)->Unit(benchmark::kMillisecond);

/// newDetections() with five detections delayed by three clouds.
void new_detections(benchmark::State& state) {
  const Recording& r = recording();
  CloudTracker tracker(published_at_once(), make_kalman_filter({}));
  const Hall hall;
  for (int k = 0; k < 20; ++k) {
    tracker.new_cloud(r.clouds[k], &hall);
    if (k == 0) tracker.new_detections(r.detections[0], &hall);
  }
  for (auto _ : state) tracker.new_detections(r.detections[16], &hall);
  if (tracker.num_tracks() != kTargets) std::abort();
}
BENCHMARK(new_detections)->Unit(benchmark::kMillisecond);

/// Algorithm 2 as printed; its tracks must equal those of CloudTracker.
void new_cloud_as_printed(benchmark::State& state) {
  const Recording& r = recording();
  const Hall hall;
  CloudTrackerConfig printed = published_at_once();
  printed.assignment = CloudTrackerConfig::Assignment::kNearest;
  printed.association_radius_min_m = printed.merge_radius_max_m = printed.max_size_m = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    CloudTracker ours(printed, make_kalman_filter({}));
    reference::PlainTracker plain;
    state.ResumeTiming();
    for (int k = 0; k < 10; ++k) {
      plain.new_point_cloud(r.clouds[k], hall);
      if (k == 0) plain.new_detections(r.detections[k], hall);
    }
    state.PauseTiming();
    for (int k = 0; k < 10; ++k) {
      ours.new_cloud(r.clouds[k], &hall);
      if (k == 0) ours.new_detections(r.detections[k], &hall);
    }
    std::vector<Track> tracks;
    ours.publish(tracks);
    if (tracks.size() != plain.tracks.size()) std::abort();
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      if ((tracks[i].position_m - plain.tracks[i].x.head<3>()).norm() > 1e-4) std::abort();
    }
    state.ResumeTiming();
  }
  state.SetItemsProcessed(state.iterations() * 10);  // clouds
}
BENCHMARK(new_cloud_as_printed)->Unit(benchmark::kMillisecond)->Iterations(2);

/// Clusters of a whole scan.
void euclidean_clusters(benchmark::State& state) {
  const LocalCloud& cloud = recording().clouds[0];
  EuclideanClusters clusters;
  for (auto _ : state) {
    clusters.compute(cloud.points_local_m, 0.25);
    benchmark::DoNotOptimize(clusters.size());
  }
}
BENCHMARK(euclidean_clusters)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace swiftlet
