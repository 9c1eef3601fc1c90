// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/detection/vofod.hpp"

#include <gtest/gtest.h>

#include "core/detection/vofod_stages.hpp"
#include "swiftlet/core/detection/ground_truth.hpp"
#include "swiftlet/core/stage_tables/detectors.hpp"
#include "tests/core/detection/detection_support.hpp"

namespace swiftlet {
namespace {

using namespace testing;
constexpr TimeNs kVofodTick = 4'000'000;
constexpr TimeNs kScanPeriod = 100'000'000;

VofodConfig near_config() {
  VofodConfig config;
  config.map.extent = VoxelMapConfig::Extent::kBounded;
  config.map.center_m = {0.0, 0.0, 4.0};
  config.map.size_m = {20.0, 20.0, 10.0};
  config.ray_max_m = 10.0;
  config.ray_weight = 0.03;
  return config;
}

/// Ticks of a detector with a scan every 100 ms.
class Ticker {
 public:
  explicit Ticker(const VofodConfig& config, bool ground_is_known = false) {
    Module module(detector_module_types(), "vofod");
    module.as<VofodConfig>() = config;
    AgentSetup setup;
    if (ground_is_known) setup.prior_map = std::make_shared<const PriorMap>(known_ground());
    detector = make_detector(module, setup);
    estimate_.T_local_body = pose_at({0.0, 0.0, 4.0});
    estimate_.valid = true;
  }
  const DetectorOutput& tick(const World& world) {
    t += kVofodTick;
    clouds_.clear();
    if (t % kScanPeriod == 0) {
      clouds_.push_back(cloud_of(scan_world(world, pose_at({0.0, 0.0, 4.0}), beams_, t)));
    }
    output_.clear();
    estimate_.t = t;
    observation_.t = t;
    detector->step({t, estimate_, poses_, clouds_, observation_}, output_, outbox_);
    return output_;
  }

  std::unique_ptr<Detector> detector;
  TimeNs t = 0;

 private:
  std::shared_ptr<const BeamTable> beams_ = make_beams(32, 256);
  StateEstimate estimate_;
  Observation observation_;
  LocalPoses poses_;
  Outbox outbox_;
  std::vector<std::shared_ptr<const LocalCloud>> clouds_;
  DetectorOutput output_;
};

TEST(VofodDetector, ResultsComeAfterTheirLatency) {
  VofodConfig config = near_config();
  config.timing.classification_latency_s = 0.05;
  Ticker ticker(config);
  int finished = 0;
  for (int i = 0; i < 250; ++i) {
    const DetectorOutput& output = ticker.tick(ground());
    if (!output.has_detections) continue;
    ++finished;
    EXPECT_EQ(output.stamp % kScanPeriod, 0);
    EXPECT_EQ(ticker.t, output.stamp + 52'000'000);  // the first tick at or after 50 ms
  }
  EXPECT_EQ(finished, 9);  // ten scans, the last of which is not ready
}

TEST(VofodDetector, SlowClassificationTakesNewestScans) {
  VofodConfig config = near_config();
  config.timing.classification_latency_s = 0.25;
  Ticker ticker(config);
  int finished = 0;
  for (int i = 0; i < 500; ++i) {
    const DetectorOutput& output = ticker.tick(ground());
    if (!output.has_detections) continue;
    ++finished;
    EXPECT_LT(ticker.t - output.stamp, 250'000'000 + kScanPeriod + 2 * kVofodTick);
  }
  EXPECT_GE(finished, 7);
}

std::uint64_t count_of(const Detector& detector, const std::string& setting) {
  std::vector<Counter> counters;
  detector.append_counters(counters);
  for (const Counter& counter : counters) {
    if (counter.setting == setting) return counter.count;
  }
  ADD_FAILURE() << "no counter names " << setting;
  return 0;
}

TEST(VofodDetector, CountsSkippedSweeps) {
  VofodConfig config = near_config();
  for (const double latency_s : {0.05, 0.25}) {
    config.timing.classification_latency_s = latency_s;
    Ticker ticker(config);
    for (int i = 0; i < 500; ++i) ticker.tick(ground());
    EXPECT_EQ(count_of(*ticker.detector, "timing.classification_latency_s") > 0U, latency_s > 0.1);
  }
}

TEST(VofodDetector, CountsTheReturnsOutsideItsMap) {
  VofodConfig config = near_config();
  config.timing.classification_latency_s = 0.0;
  config.map.voxel_m = 1.0;
  for (const double edge_m : {200.0, 3.0}) {
    config.map.size_m = {edge_m, edge_m, 20.0};
    Ticker ticker(config);
    for (int i = 0; i < 50; ++i) ticker.tick(ground());
    const std::uint64_t outside = count_of(*ticker.detector, "map.size_m");
    EXPECT_EQ(outside == 0, edge_m > 100.0) << outside;
  }
}

TEST(VofodDetector, UpdatesMapWhenRaycastingCompletes) {
  VofodConfig config = near_config();
  config.timing.classification_latency_s = 0.0;
  config.timing.raycasting_latency_s = 0.25;
  Ticker ticker(config);
  const Vector3 inside_air(3.0, 0.1, 4.1);
  const auto value = [&] {
    const VoxelMap& map = *ticker.detector->map();
    return map.value(map.grid().index(map.grid().cell_of(inside_air)));
  };
  while (ticker.t < 100'000'000 + 248'000'000) ticker.tick(ground());
  EXPECT_EQ(value(), -740.0F);
  ticker.tick(ground());  // 352 ms: the rays of the first scan, three classifications (100, 200, 300 ms)
  const float moved = value();
  EXPECT_LT(moved, -740.0F);

  VofodStages once(config);
  const auto cloud = cloud_of(scan_world(ground(), pose_at({0.0, 0.0, 4.0}), make_beams(32, 256), 0));
  once.cast_rays(*cloud);
  once.apply_rays(3);
  EXPECT_EQ(moved, once.map().value(once.map().grid().index(once.map().grid().cell_of(inside_air))));
}

TEST(VofodDetector, RaysWaitForAClassification) {
  VofodConfig config = near_config();
  config.timing.classification_latency_s = 0.4;
  config.timing.raycasting_latency_s = 0.1;
  Ticker ticker(config);
  const auto untouched = [&] {
    const VoxelMap& map = *ticker.detector->map();
    for (std::ptrdiff_t i = 0; i < map.grid().num_cells(); ++i) {
      if (map.value(i) != -740.0F) return false;
    }
    return true;
  };
  while (ticker.t < 496'000'000) ticker.tick(ground());
  EXPECT_TRUE(untouched());
  ticker.tick(ground());
  EXPECT_FALSE(untouched());
}

TEST(VofodDetector, FindsAnObjectAndShowsHow) {
  Ticker ticker(near_config(), true);
  while (ticker.t < 4 * kNsPerSecond) ticker.tick(ground());
  std::vector<Detection> found;
  TimeNs stamp = 0;
  while (found.empty() && ticker.t < 5 * kNsPerSecond) {
    const DetectorOutput& output = ticker.tick(all_of({ground(), sphere({5.0, 0.0, 4.5}, 0.3)}));
    found = output.detections;
    stamp = output.stamp;
  }
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LT((found[0].position_m - Vector3(5.0, 0.0, 4.5)).norm(), 0.3);
  EXPECT_EQ(found[0].t, stamp);

  std::vector<Overlay> overlays;
  ticker.detector->append_overlays(overlays);
  EXPECT_FALSE(overlays.empty());
  for (const Overlay& overlay : overlays) {
    EXPECT_FALSE(overlay.positions.empty()) << overlay.name;
    EXPECT_TRUE(overlay.colors.size() == 1 || overlay.colors.size() == overlay.positions.size()) << overlay.name;
  }
}

TEST(VofodDetector, UsesOnlyItsSensor) {
  VofodConfig config = near_config();
  config.sensor = "another";
  Ticker ticker(config);
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(ticker.tick(ground()).has_detections);
}

TEST(GroundTruthDetector, ReportsNeighborSensorMeasurements) {
  Module module(detector_module_types(), "ground_truth");
  module.as<GroundTruthDetectorConfig>().latency_s = 0.01;
  module.as<GroundTruthDetectorConfig>().range_max_m = 50.0;
  const auto detector = make_detector(module, AgentSetup{});
  StateEstimate estimate;
  estimate.valid = true;
  estimate.t = kVofodTick;
  estimate.T_local_body = pose_at({1.0, 2.0, 3.0}, M_PI / 2.0);
  Observation observation;
  observation.neighbors.push_back({kVofodTick, 1, {10.0, 0.0, 0.0}, 1e-6 * Matrix3::Identity()});
  observation.neighbors.push_back({kVofodTick, 2, {60.0, 0.0, 0.0}, 1e-6 * Matrix3::Identity()});
  DetectorOutput output;
  LocalPoses poses;
  Outbox outbox;
  poses.push(estimate);
  detector->step({kVofodTick, estimate, poses, {}, observation}, output, outbox);
  EXPECT_FALSE(output.has_detections);
  observation.neighbors.clear();
  estimate.t = 4 * kVofodTick;
  poses.push(estimate);
  detector->step({4 * kVofodTick, estimate, poses, {}, observation}, output, outbox);
  ASSERT_EQ(output.detections.size(), 1u);
  EXPECT_EQ(output.stamp, kVofodTick);
  EXPECT_LT((output.detections[0].position_m - Vector3(1.0, 12.0, 3.0)).norm(), 1e-9);
  EXPECT_EQ(output.detections[0].confidence, 1.0);
  const double sigma_m = module.as<GroundTruthDetectorConfig>().sigma_m;
  EXPECT_NEAR(output.detections[0].covariance(0, 0), 1e-6 + sigma_m * sigma_m, 1e-12);
}

TEST(DetectorRegistry, MakesWhatItNames) {
  EXPECT_EQ(make_detector(Module(detector_module_types(), "none"), AgentSetup{}), nullptr);
  EXPECT_NE(make_detector(Module(detector_module_types(), "ground_truth"), AgentSetup{}), nullptr);
  Module unknown(detector_module_types(), "none");
  unknown.type = "radar";
  EXPECT_THROW(make_detector(unknown, AgentSetup{}), std::invalid_argument);
}

}  // namespace
}  // namespace swiftlet
