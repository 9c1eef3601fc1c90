// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/metrics/detection_score.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "tests/sim/metrics/metrics_run.hpp"
#include "tests/support/allocation_counter.hpp"

namespace swiftlet::sim {
namespace {

constexpr TimeNs kScan = 100'000'000;

/// An observer (vehicle 0 by default) that detects and tracks the others, with detections set by the tests.
struct SightRun : MetricsRun {
  explicit SightRun(int num_vehicles, MetricsConfig config = {}, std::size_t index = 0)
      : MetricsRun(num_vehicles, config, perceived(num_vehicles, index)), observer(index) {
    for (Action& action : actions) action.estimate.valid = true;
  }
  static std::vector<Perception> perceived(int n, std::size_t index) {
    std::vector<Perception> out(n);
    out[index] = {true, true, {}};
    return out;
  }

  /// A frozen scan with that many returns on each vehicle.
  void scan(const std::vector<int>& points) {
    auto labeled = std::make_shared<LabeledScan>();
    labeled->scan.stamp = now + kTick;
    for (std::size_t vehicle = 0; vehicle < points.size(); ++vehicle) {
      for (int k = 0; k < points[vehicle] + 1; ++k) {
        labeled->scan.range_m.push_back(k < points[vehicle] ? 5.0F : 0.0F);  // the last one is not returned
        labeled->truth.surface_class.push_back(static_cast<std::uint16_t>(SurfaceClass::kVehicle));
        labeled->truth.instance.push_back(static_cast<std::uint16_t>(vehicle + 1));
      }
    }
    scans[observer] = {labeled};
  }
  void detect(const std::vector<Vector3>& positions, TimeNs t, TimeNs stamp) {
    actions[observer].has_detections = true;
    actions[observer].detections_stamp = stamp;
    for (const Vector3& p : positions) {
      actions[observer].detections.emplace_back();
      actions[observer].detections.back().t = t;
      actions[observer].detections.back().position_m = p;
    }
  }
  void track(std::uint32_t id, const Vector3& p, const Vector3& v, TimeNs t, double sigma_m = 0.1) {
    actions[observer].has_tracks = true;
    Track track;
    track.id = id;
    track.t = t;
    track.position_m = p;
    track.velocity_mps = v;
    track.covariance *= sigma_m * sigma_m;
    actions[observer].tracks.push_back(track);
  }
  void tick() {
    for (std::size_t i = 0; i < states.size(); ++i) {
      actions[i].estimate.t = now + kTick;
      if (i != observer || !own_estimate) actions[i].estimate.T_local_body = states[i].T_world_body();
    }
    MetricsRun::tick();
    for (Action& action : actions) {
      action.clear_outputs();
      action.tracks.clear();
    }
    scans[observer].clear();
  }

  std::size_t observer = 0;
  bool own_estimate = false;  // the test sets the observer's estimate itself
};

TEST(DetectionMetric, RecallPrecisionAndErrorOfDetections) {
  SightRun run(3);
  run.states[1].p_world_m = {8, 0, 0};
  run.states[2].p_world_m = {0, 12, 0};
  // The first target is found in every scan with an error of 0.5 m, the second in every fourth with 1 m (and the other
  // times 4 m beside it: no true positive).
  for (int k = 0; k < 40; ++k) {
    for (int i = 1; i < 10; ++i) run.tick();
    run.scan({0, 20, k % 4 == 0 ? 3 : 0});
    run.detect({{8, 0.5, 0}, {0, k % 4 == 0 ? 13.0 : 16.0, 0}}, run.now + kTick, run.now + kTick);
    run.tick();
  }
  EXPECT_DOUBLE_EQ(run.value("detection_recall"), 50.0 / 80.0);
  EXPECT_DOUBLE_EQ(run.value("detection_recall_visible"), 1.0);
  EXPECT_DOUBLE_EQ(run.value("detection_precision"), 50.0 / 80.0);
  EXPECT_NEAR(run.value("detection_error_mean_m"), (40 * 0.5 + 10 * 1.0) / 50.0, 1e-9);
  EXPECT_NEAR(run.value("detection_error_std_m"), 0.2, 1e-9);
  EXPECT_NEAR(run.value("false_detections_per_min"), 30.0 / (3.9 / 60.0), 1e-6);
  const MetricTable table = run.metrics.report();
  ASSERT_EQ(table.bins().size(), 2U);
  EXPECT_EQ(table.bins()[0].from_m, 5.0);
  EXPECT_EQ(table.bins()[0].recall, 1.0);
  EXPECT_EQ(table.bins()[1].from_m, 10.0);
  EXPECT_EQ(table.bins()[1].recall, 0.25);
  EXPECT_NEAR(table.bins()[1].error_mean_m, 1.0, 1e-9);
}

TEST(DetectionMetric, JudgesVelocitiesBySpeedAndDirection) {
  SightRun run(2);
  for (int i = 1; i < 10; ++i) {
    run.states[1].p_world_m = {8.0 + 2.0 * run.next_s(), 0, 0};
    run.states[1].v_world_mps = {2, 0, 0};
    run.tick();
  }
  run.states[1].p_world_m.x() = 8.0 + 2.0 * run.next_s();
  run.scan({0, 20});
  run.track(1, run.states[1].p_world_m, 5.0 * Vector3(std::cos(0.3), std::sin(0.3), 0), run.now + kTick);
  run.tick();
  const auto series = run.metrics.series();
  const auto rows = rows_of<DetectionScore>(series);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_NEAR(rows[0].speed_error_mps, 3.0, 1e-9);
  EXPECT_NEAR(rows[0].direction_error_rad, 0.3, 1e-9);
}

TEST(DetectionMetric, ComparesEstimatesWithTruthOfTime) {
  SightRun run(2);
  const Vector3 v(10.0, 0.0, 0.0);
  const auto truth = [&](TimeNs t) { return Vector3(Vector3(-5, 6, 0) + v * to_seconds(t)); };
  for (int k = 1; k <= 100; ++k) {
    run.states[1].p_world_m = truth(run.now + kTick);
    run.states[1].v_world_mps = v;
    const TimeNs seen = run.now + kTick - 73'000'000;  // between two ticks
    if (k % 10 == 1) run.scan({0, 5});
    if (k > 20 && k % 10 == 1) {
      run.detect({truth(seen)}, seen, run.now + kTick - kScan);
      run.track(4, truth(seen), 1.1 * v, seen);
    }
    run.tick();
  }
  EXPECT_NEAR(run.value("detection_error_mean_m"), 0.0, 1e-9);
  EXPECT_NEAR(run.value("detection_latency_s"), 0.073, 1e-12);
  EXPECT_NEAR(run.value("track_error_mean_m"), 0.0, 1e-9);
  EXPECT_NEAR(run.value("track_speed_error_mean_mps"), 1.0, 1e-9);
  EXPECT_NEAR(run.value("track_direction_error_mean_rad"), 0.0, 1e-7);
}

// An odometry frame that is turned and shifted: what counts is where the target is as seen from the observer.
TEST(DetectionMetric, ExcludesObserverFrameErrorsFromTracking) {
  SightRun run(2);
  run.own_estimate = true;
  const Pose T = make_pose({100, -40, 3}, Eigen::Quaterniond(Eigen::AngleAxisd(2.0, Vector3::UnitZ())));
  run.states[1].p_world_m = {8, 0, 0};
  run.states[1].v_world_mps = {2, 0, 0};
  run.actions[0].estimate.T_local_body = T;
  run.scan({0, 5});
  run.track(1, T * Vector3(8, 0.3, 0), T.linear() * Vector3(0, 2, 0), kTick);
  run.tick();
  EXPECT_NEAR(run.value("track_error_mean_m"), 0.3, 1e-9);
  EXPECT_NEAR(run.value("track_speed_error_mean_mps"), 0.0, 1e-9);
  EXPECT_NEAR(run.value("track_direction_error_mean_rad"), 0.5 * std::numbers::pi, 1e-9);
}

TEST(DetectionMetric, IgnoresVehiclesOnTheGround) {
  SightRun run(3);
  run.states[1].p_world_m = {8, 0, 0};
  run.states[2].p_world_m = {0, 8, 0};
  run.clearances[2].surface_m = -0.1;
  for (int k = 0; k < 10; ++k) {
    run.scan({0, 5, 5});
    run.detect({{8, 0, 0}, {0, 8, 0}}, run.now + kTick, run.now + kTick);
    run.tick();
  }
  EXPECT_EQ(run.value("detection_recall"), 1.0);
  EXPECT_EQ(run.value("detection_precision"), 1.0);
}

TEST(DetectionMetric, IdentitiesAreFollowed) {
  SightRun run(3);
  run.states[1].p_world_m = {8, 0, 0};
  run.states[2].p_world_m = {0, 8, 0};
  const auto scan = [&](std::uint32_t of_first, std::uint32_t of_second) {
    run.scan({0, 5, 5});
    if (of_first != 0) run.track(of_first, {8, 0, 0.1}, Vector3::Zero(), run.now + kTick);
    if (of_second != 0) run.track(of_second, {0, 8, 0.1}, Vector3::Zero(), run.now + kTick);
    run.track(99, {20, 20, 20}, Vector3::Zero(), run.now + kTick);  // one ghost, all along
    run.actions[0].has_tracks = true;
    run.tick();
  };
  scan(1, 2);
  scan(1, 2);
  EXPECT_EQ(run.value("track_identity_switches"), 0);
  scan(0, 2);
  scan(3, 2);  // lost and found again under another name
  EXPECT_EQ(run.value("track_identity_switches"), 1);
  EXPECT_EQ(run.value("track_cross_associations"), 0);
  scan(2, 3);  // the tracks change places
  EXPECT_EQ(run.value("track_identity_switches"), 3);
  EXPECT_EQ(run.value("track_cross_associations"), 2);
  EXPECT_NEAR(run.value("false_tracks_per_min"), 1.0 / (4 * 0.01 / 60.0), 1e-6) << "a ghost is counted once";
  EXPECT_NEAR(run.value("track_precision"), 9.0 / 14.0, 1e-12);
}

TEST(DetectionMetric, OspaIsThatOfItsDefinition) {
  SightRun run(3);
  run.states[1].p_world_m = {8, 0, 0};
  run.states[2].p_world_m = {0, 8, 0};
  run.scan({0, 5, 5});
  run.track(1, {8, 0.6, 0}, Vector3::Zero(), kTick);
  run.tick();
  EXPECT_NEAR(run.value("track_ospa_m"), (0.6 + 3.0) / 2.0, 1e-9);
  run.scan({0, 5, 5});
  run.track(1, {8, 0.6, 0}, Vector3::Zero(), 2 * kTick);
  run.track(2, {0, 8.2, 0}, Vector3::Zero(), 2 * kTick);
  run.track(3, {50, 8, 0}, Vector3::Zero(), 2 * kTick);
  run.tick();
  EXPECT_NEAR(run.value("track_ospa_m"), 0.5 * ((0.6 + 3.0) / 2.0 + (0.6 + 0.2 + 3.0) / 3.0), 1e-9);
}

TEST(DetectionMetric, NeesReflectsCovarianceConsistency) {
  SightRun run(2);
  run.states[1].p_world_m = {8, 0, 0};
  for (int k = 0; k < 4; ++k) {
    run.scan({0, 5});
    run.track(1, Vector3(8, 0, 0) + Vector3(0.1, 0.2, k == 0 ? 0.3 : -0.2), {}, run.now + kTick);
    run.tick();
  }
  EXPECT_NEAR(run.value("track_nees"), (14.0 + 3 * 9.0) / 4.0, 1e-9);
  EXPECT_EQ(run.value("track_nees_within_95"), 0.0);
}

TEST(DetectionMetric, TimesDetectionFromFirstVisibleScan) {
  SightRun run(2);
  run.states[1].p_world_m = {8, 0, 0};
  for (int k = 1; k <= 300; ++k) {
    if (k % 10 == 0) {
      run.scan({0, k >= 100 ? 7 : 0});
      run.detect(k >= 160 ? std::vector<Vector3>{{8, 0, 0}} : std::vector<Vector3>{}, run.now + kTick, run.now + kTick);
    }
    run.tick();
  }
  EXPECT_NEAR(run.value("time_to_first_detection_s"), 0.6, 1e-9);
  EXPECT_TRUE(std::isnan(run.value("time_to_first_track_s")));
}

TEST(DetectionMetric, CountsDistantTargetsOnlyInBin) {
  SightRun run(2);
  run.states[1].p_world_m = {33, 0, 0};
  run.scan({0, 1});
  run.detect({}, kTick, kTick);
  run.tick();
  EXPECT_TRUE(std::isnan(run.value("detection_recall")));
  const MetricTable table = run.metrics.report();
  ASSERT_EQ(table.bins().size(), 1U);
  EXPECT_EQ(table.bins()[0].from_m, 30.0);
  EXPECT_EQ(table.bins()[0].recall, 0.0);
}

TEST(DetectionMetric, RecordsItsScores) {
  SightRun run(2);
  run.states[1].p_world_m = {8, 0, 0};
  run.scan({0, 6});
  run.detect({{8, 0, 0.4}, {30, 0, 0}}, kTick, kTick);
  run.tick();
  const auto scores = rows_of<DetectionScore>(run.metrics.series());
  ASSERT_EQ(scores.size(), 2U);
  EXPECT_EQ(scores[0].target, 1);
  EXPECT_EQ(scores[0].visible_points, 6);
  EXPECT_TRUE(scores[0].found);
  EXPECT_NEAR(scores[0].position_error_m, 0.4, 1e-12);
  EXPECT_EQ(scores[1].target, kNoVehicle);
  EXPECT_NEAR(scores[1].distance_m, 30.0, 1e-9);
  run.tick();
  EXPECT_TRUE(rows_of<DetectionScore>(run.metrics.series()).empty());
}

TEST(DetectionMetric, IsAbsentWithoutPerception) {
  Metrics metrics({}, {"uav1"});
  EXPECT_EQ(metrics.report().find("detection_recall", "uav1"), nullptr);
  EXPECT_EQ(metrics.report().find("track_recall", "uav1"), nullptr);
}

TEST(DetectionMetric, PairsEstimatesBestOfAllAssignments) {
  const Random random(1, "pairs");
  const MetricsConfig config;
  for (std::uint32_t k = 0; k < 200; ++k) {
    SightRun run(4, config, 1);
    const auto place = [&](std::uint32_t i) {
      return Vector3(8.0 + 4.0 * random.uniform(k, 3 * i), 4.0 * random.uniform(k, 3 * i + 1),
                     4.0 * random.uniform(k, 3 * i + 2));
    };
    const Vector3 targets_m[] = {place(0), place(1), place(2)};
    for (int i = 0; i < 3; ++i) run.states[i == 0 ? 0 : i + 1].p_world_m = targets_m[i];
    std::vector<Vector3> estimates_m;
    for (std::uint32_t i = 3; i < 7; ++i) estimates_m.push_back(place(i));
    run.scan({5, 0, 5, 5});
    run.detect(estimates_m, kTick, kTick);
    run.tick();
    const auto gain_m = [&](int target, int estimate) {
      if (estimate < 0) return 0.0;
      return std::max(0.0, config.true_positive_m - (targets_m[target] - estimates_m[estimate]).norm());
    };
    double best_m = 0.0, reported_m = 0.0;
    for (int a = -1; a < 4; ++a) {
      for (int b = -1; b < 4; ++b) {
        for (int c = -1; c < 4; ++c) {
          const bool twice = (a >= 0 && (a == b || a == c)) || (b >= 0 && b == c);
          if (!twice) best_m = std::max(best_m, gain_m(0, a) + gain_m(1, b) + gain_m(2, c));
        }
      }
    }
    for (const DetectionScore& score : rows_of<DetectionScore>(run.metrics.series())) {
      if (score.found) reported_m += config.true_positive_m - score.position_error_m;
    }
    EXPECT_NEAR(reported_m, best_m, 1e-9) << k;
  }
}

TEST(DetectionMetric, ConsistencyMeansWithin95PercentChiSquare) {
  for (const double nees : {7.8, 7.83}) {
    SightRun run(2);
    run.states[1].p_world_m = {8, 0, 0};
    run.scan({0, 5});
    run.track(1, {8, 0.1 * std::sqrt(nees), 0}, {}, kTick, 0.1);
    run.tick();
    EXPECT_NEAR(run.value("track_nees"), nees, 1e-9);
    EXPECT_EQ(run.value("track_nees_within_95"), nees < 7.815 ? 1.0 : 0.0);
  }
}

TEST(DetectionMetric, AllocatesNothingOnceWarm) {
  SightRun run(3);
  run.states[1].p_world_m = {8, 0, 0};
  run.states[2].p_world_m = {0, 8, 0};
  std::uint64_t during = 0;
  for (int k = 0; k < 200; ++k) {
    run.scan({0, 5, 5});
    run.detect({{8, 0, 0}, {0, 8, 0}, {30, 0, 0}}, run.now + kTick, run.now + kTick);
    run.track(1 + k / 20, {8, 0, 0}, {1, 0, 0}, run.now + kTick);
    run.now += kTick;
    run.pointers.clear();
    for (Action& action : run.actions) run.pointers.push_back(&action);
    TickView view;
    view.t = run.now;
    view.states = run.states;
    view.observations = run.observations;
    view.actions = run.pointers;
    view.scans = run.scans;
    const std::uint64_t before = test::num_allocations();
    run.metrics.update(view, run.clearances);
    if (k > 50) during += test::num_allocations() - before;
    run.actions[0].clear_outputs();
    run.actions[0].tracks.clear();
  }
  EXPECT_EQ(during, 0U);
}

}  // namespace
}  // namespace swiftlet::sim
