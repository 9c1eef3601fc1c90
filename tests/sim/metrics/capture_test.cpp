// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "swiftlet/sim/metrics/capture_record.hpp"
#include "tests/sim/metrics/metrics_run.hpp"

namespace swiftlet::sim {
namespace {

/// uav1 hovers with a net of 2 m radius 1 m below it; uav2 is wherever the test puts it.
struct Chase : MetricsRun {
  Chase() : MetricsRun(2, {}, with_net()) { states[0].p_world_m = {0.0, 0.0, 10.0}; }
  static std::vector<Perception> with_net() {
    std::vector<Perception> perception(2);
    perception[0].net = CaptureVolume{{0.0, 0.0, -1.0}, 2.0, 0.0, 4.0};
    return perception;
  }
  void put_target(const Vector3& p_world_m) {
    states[1].p_world_m = p_world_m;
    tick();
  }
};

TEST(CaptureMetric, CountsTargetsPassingThroughTheNet) {
  Chase run;
  run.put_target({1.0, 0.0, 9.5});
  run.put_target({1.0, 0.0, 9.1});
  EXPECT_EQ(run.value("captures"), 0.0);
  EXPECT_TRUE(std::isnan(run.value("time_to_first_capture_s")));
  run.put_target({1.0, 0.0, 8.9});
  EXPECT_EQ(run.value("captures"), 1.0);
  EXPECT_DOUBLE_EQ(run.value("time_to_first_capture_s"), 3.0 * to_seconds(kTick));
  EXPECT_NEAR(run.value("capture_miss_mean_m"), 1.0, 1e-9);
  EXPECT_NEAR(run.value("least_net_distance_m"), std::hypot(1.0, 0.1), 1e-9);
}

TEST(CaptureMetric, DeterminesOutcomeByCapturesAlone) {
  for (const int required : {0, 1, 2}) {
    std::vector<Perception> perception = Chase::with_net();
    perception[0].captures = required;
    MetricsRun run(2, {}, perception);
    run.states[0].p_world_m = {0.0, 0.0, 10.0};
    run.actions[1].mission = MissionStatus::kEndless;
    for (const double z_m : {9.5, 8.5}) {
      EXPECT_EQ(run.metrics.outcome(), "timeout");
      run.states[1].p_world_m = {0.0, 0.0, z_m};
      run.tick();
    }
    EXPECT_EQ(run.metrics.outcome(), required == 1 ? "done" : "timeout") << required;
    EXPECT_TRUE(std::isnan(run.value("time_to_done_s"))) << "the agent has not reported it";
    run.states[0].crashed = true;
    run.tick();
    EXPECT_EQ(run.metrics.outcome(), "crashed");
  }
}

TEST(CaptureMetric, CompletesOnceAllTargetsAreCaught) {
  std::vector<Perception> perception = Chase::with_net();
  perception.insert(perception.begin(), perception[0]);
  perception[0].captures = perception[1].captures = 1;
  MetricsRun run(3, {}, {perception[0], perception[1], {}});
  run.states[0].p_world_m = {50.0, 0.0, 10.0};
  run.states[1].p_world_m = {0.0, 0.0, 10.0};
  run.actions[2].mission = MissionStatus::kEndless;
  for (const double z_m : {9.5, 8.5}) {
    EXPECT_EQ(run.metrics.outcome(), "timeout");
    run.states[2].p_world_m = {0.0, 0.0, z_m};
    run.tick();
  }
  EXPECT_EQ(run.metrics.outcome(), "done");
}

TEST(CaptureMetric, RecountsTargetOnlyAfterItLeaves) {
  Chase run;
  for (const double z_m : {9.5, 8.5, 9.5, 8.5}) run.put_target({0.0, 0.0, z_m});
  EXPECT_EQ(run.value("captures"), 1.0) << "a target that stays near is counted once";
  run.put_target({0.0, 0.0, 14.0});
  run.put_target({0.0, 0.0, 8.0});
  EXPECT_EQ(run.value("captures"), 2.0);
}

TEST(CaptureMetric, ExcludesMissedAndCrashedTargets) {
  Chase run;
  run.put_target({2.5, 0.0, 9.5});
  run.put_target({2.5, 0.0, 8.5});
  EXPECT_EQ(run.value("captures"), 0.0) << "beside the rim";
  run.states[1].crashed = true;
  run.put_target({0.0, 0.0, 9.5});
  run.put_target({0.0, 0.0, 8.5});
  EXPECT_EQ(run.value("captures"), 0.0);
}

TEST(CaptureMetric, RecordsVehiclePlaceAndSpeedCaptures) {
  Chase run;
  run.states[0].q_world_body = Eigen::AngleAxisd(1.0, Vector3::UnitZ());
  run.put_target({0.6, 0.8, 9.5});
  EXPECT_TRUE(rows_of<CaptureRecord>(run.metrics.series()).empty());
  run.put_target({0.6, 0.8, 8.5});
  const auto rows = rows_of<CaptureRecord>(run.metrics.series());
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].t, 2 * kTick);
  EXPECT_EQ(rows[0].target, 1);
  EXPECT_EQ(rows[0].number, 1);
  EXPECT_NEAR(rows[0].miss_m, 1.0, 1e-9);
  EXPECT_NEAR(rows[0].relative_speed_mps, 1.0 / to_seconds(kTick), 1e-6);
  EXPECT_EQ(rows[0].p_world_m, Vector3(0.6, 0.8, 8.5));
}

TEST(CaptureMetric, CountsPerMinuteUntilOwnCrash) {
  Chase run;
  for (const double z_m : {9.5, 8.5, 20.0, 8.9}) run.put_target({0.0, 0.0, z_m});
  ASSERT_EQ(run.value("captures"), 2.0);
  EXPECT_NEAR(run.value("captures_per_min"), 60.0 * 2.0 / (4.0 * to_seconds(kTick)), 1e-6);
  EXPECT_NEAR(run.value("least_net_distance_m"), 0.1, 1e-9);
  run.states[0].crashed = true;
  for (const double z_m : {20.0, 8.9}) run.put_target({0.0, 0.0, z_m});
  EXPECT_EQ(run.value("captures"), 2.0);
  EXPECT_NEAR(run.value("captures_per_min"), 60.0 * 2.0 / (4.0 * to_seconds(kTick)), 1e-6);
}

TEST(CaptureMetric, IsAbsentForVehiclesWithoutNet) {
  Chase run;
  run.put_target({0.0, 0.0, 9.5});
  EXPECT_THROW(run.value("captures", "uav2"), std::out_of_range);
}

}  // namespace
}  // namespace swiftlet::sim
