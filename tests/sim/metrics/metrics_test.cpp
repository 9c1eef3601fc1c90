// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/metrics/metrics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/sim/metrics/metrics_run.hpp"
#include "tests/support/allocation_counter.hpp"

namespace swiftlet::sim {
namespace {

TEST(Metrics, MotionOnACircleIsMeasured) {
  MetricsRun run(1);
  const double radius = 5.0, rate = 0.8;
  for (int i = 0; i < 1001; ++i) {
    const double phase = rate * run.next_s();
    run.states[0].p_world_m = {radius * std::cos(phase), radius * std::sin(phase), 3.0};
    run.states[0].v_world_mps = radius * rate * Vector3(-std::sin(phase), std::cos(phase), 0.0);
    run.tick();
  }
  EXPECT_NEAR(run.value("path_length_m"), radius * rate * 10.0, 1e-3);
  EXPECT_NEAR(run.value("max_speed_mps"), radius * rate, 1e-12);
  EXPECT_NEAR(run.value("mean_speed_mps"), radius * rate, 0.01);
  EXPECT_NEAR(run.value("max_acceleration_mps2"), radius * rate * rate, 1e-4);
  EXPECT_NEAR(run.value("flight_time_s"), 10.01, 1e-9);
}

TEST(Metrics, ExcludesStandingOnGroundFromFlight) {
  MetricsRun run(1);
  run.clearances[0].surface_m = -0.2;
  for (int i = 0; i < 100; ++i) run.tick();
  EXPECT_EQ(run.value("flight_time_s"), 0.0);
  EXPECT_TRUE(std::isnan(run.value("min_clearance_surface_m")));
  run.clearances[0].surface_m = 1.5;
  for (int i = 0; i < 100; ++i) run.tick();
  EXPECT_NEAR(run.value("flight_time_s"), 1.0, 1e-9);
  EXPECT_EQ(run.value("min_clearance_surface_m"), 1.5);
  for (const char* name : {"path_length_m", "max_speed_mps", "max_acceleration_mps2"}) EXPECT_EQ(run.value(name), 0.0);
}

TEST(Metrics, MeasuresEstimateErrorsAgainstTheTruth) {
  MetricsRun run(1);
  for (int i = 0; i < 400; ++i) {
    const double t = run.next_s();
    run.states[0].p_world_m = {t, 2.0 * std::sin(t), 3.0};
    run.states[0].q_world_body = Eigen::AngleAxisd(3.1, Vector3::UnitZ());
    StateEstimate& estimate = run.actions[0].estimate;
    estimate.valid = true;
    const double error = i % 2 == 0 ? 0.3 : -0.1;
    estimate.T_local_body = make_pose(run.states[0].p_world_m + Vector3(0.0, error, 0.0),
                                      Eigen::Quaterniond(Eigen::AngleAxisd(-3.1, Vector3::UnitZ())));
    estimate.v_local_mps = {0.0, error, 0.0};
    run.tick();
  }
  EXPECT_NEAR(run.value("estimate_position_rmse_m"), std::sqrt(0.05), 1e-12);
  EXPECT_NEAR(run.value("estimate_velocity_rmse_mps"), std::sqrt(0.05), 1e-12);
  EXPECT_NEAR(run.value("estimate_position_max_m"), 0.3, 1e-12);
  EXPECT_NEAR(run.value("estimate_yaw_rmse_rad"), 2.0 * std::numbers::pi - 6.2, 1e-9) << "wrapped";
  // The mean error of 0.1 m is a shift of the frame, which the alignment removes.
  EXPECT_NEAR(run.value("ate_position_rmse_m"), 0.2, 1e-4);
}

// The best of many headings, each with its best shift, by search.
TEST(Metrics, AlignmentFindsBestHeadingAndShift) {
  MetricsRun run(1);
  run.actions[0].estimate.valid = true;
  std::vector<Vector3> p, q;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.1 * i;
    p.emplace_back(50.0 + 4.0 * std::cos(t), 3.0 * std::sin(1.3 * t), 0.5 * t);
    q.push_back(Eigen::AngleAxisd(0.9, Vector3::UnitZ()) * p.back() + Vector3(7, 8, 9) +
                Vector3(0.3 * std::sin(5.0 * t), 0.2 * std::cos(3.0 * t), 0.1 * std::sin(7.0 * t)));
    run.states[0].p_world_m = p.back();
    run.actions[0].estimate.T_local_body.translation() = q.back();
    run.tick();
  }
  double best_m = 1e9;
  for (double yaw = -3.2; yaw < 3.2; yaw += 1e-3) {
    const Matrix3 R = Eigen::AngleAxisd(yaw, Vector3::UnitZ()).toRotationMatrix();
    Vector3 shift = Vector3::Zero();
    for (std::size_t i = 0; i < p.size(); ++i) shift += (p[i] - R * q[i]) / static_cast<double>(p.size());
    double sum = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) sum += (p[i] - R * q[i] - shift).squaredNorm();
    best_m = std::min(best_m, std::sqrt(sum / static_cast<double>(p.size())));
  }
  EXPECT_GT(best_m, 0.1);
  EXPECT_NEAR(run.value("ate_position_rmse_m"), best_m, 1e-5);
}

TEST(Metrics, WithoutAnEstimateNothingIsMeasured) {
  MetricsRun run(1);
  run.tick();
  for (const char* name : {"estimate_position_rmse_m", "ate_position_rmse_m", "tracking_error_rms_m"}) {
    EXPECT_TRUE(std::isnan(run.value(name))) << name;
  }
}

TEST(Metrics, JudgesControlByTheEstimate) {
  MetricsRun run(1);
  run.actions[0].estimate.valid = true;
  run.actions[0].estimate.T_local_body.translation() = Vector3(1.0, 0.0, 0.1);
  run.actions[0].reference.position_m = {1.0, 0.0, 0.0};
  run.states[0].p_world_m = {1.0, 0.4, 0.3};
  run.tick();
  EXPECT_NEAR(run.value("tracking_error_rms_m"), 0.5, 1e-12);
  EXPECT_NEAR(run.value("control_error_rms_m"), 0.1, 1e-12);
  run.states[0].p_world_m = {1.0, 0.0, 0.0};
  run.tick();
  EXPECT_NEAR(run.value("tracking_error_rms_m"), std::sqrt(0.125), 1e-12);
  EXPECT_NEAR(run.value("tracking_error_max_m"), 0.5, 1e-12);
}

TEST(Metrics, LeastDistancesNameTimeAndPartner) {
  MetricsRun run(3);
  // uav1 passes uav3 at 2 m in y when it is at x = 5, that is after 5 s.
  run.states[1].p_world_m = {0.0, -30.0, 5.0};
  run.states[2].p_world_m = {5.0, 2.0, 5.0};
  for (int i = 0; i < 1000; ++i) {
    run.states[0].p_world_m = {run.next_s(), 0.0, 5.0};
    run.clearances[0].surface_m = 1.0 + std::abs(run.next_s() - 3.0);
    run.clearances[0].vehicle_m = (run.states[0].p_world_m - run.states[2].p_world_m).norm() - 0.8;
    run.clearances[0].nearest_vehicle = 2;
    run.tick();
  }
  EXPECT_NEAR(run.value("min_clearance_surface_m"), 1.0, 1e-12);
  EXPECT_NEAR(run.value("min_clearance_surface_time_s"), 3.0, 1e-12);
  EXPECT_NEAR(run.value("min_clearance_vehicle_m"), 1.2, 1e-12);
  EXPECT_NEAR(run.value("min_clearance_vehicle_time_s"), 5.0, 1e-12);
  EXPECT_EQ(run.text("min_clearance_vehicle_partner"), "uav3");
  EXPECT_NEAR(run.value("min_separation_m", ""), 2.0, 1e-12);
  EXPECT_NEAR(run.value("min_separation_time_s", ""), 5.0, 1e-12);
  EXPECT_EQ(run.text("min_separation_pair", ""), "uav1 uav3");
  EXPECT_NEAR(run.value("min_separation_m", "uav2"), 30.0, 1e-3);
  EXPECT_EQ(run.text("min_separation_partner", "uav2"), "uav1");
}

TEST(Metrics, ALoneVehicleHasNoSeparation) {
  MetricsRun run(1);
  run.tick();
  EXPECT_TRUE(std::isnan(run.value("min_separation_m", "")));
  EXPECT_TRUE(std::isnan(run.value("min_clearance_vehicle_m")));
  EXPECT_EQ(run.text("min_clearance_vehicle_partner"), "none");
}

TEST(Metrics, TakesOutcomeOfWorstVehicle) {
  MetricsRun run(4);
  run.tick();
  EXPECT_EQ(run.metrics.outcome(), "timeout");
  for (Action& action : run.actions) action.mission = MissionStatus::kDone;
  run.tick();
  EXPECT_EQ(run.metrics.outcome(), "done");
  EXPECT_NEAR(run.value("time_to_done_s"), 0.02, 1e-12);
  run.actions[1].mission = MissionStatus::kRunning;
  run.tick();
  EXPECT_EQ(run.metrics.outcome(), "timeout");
  run.actions[2].mission = MissionStatus::kFailed;
  run.tick();
  EXPECT_EQ(run.metrics.outcome(), "failed");
  run.states[3].crashed = true;
  run.events.push_back({run.now + 3'000'000, "crash", 3, "trunk 17", Vector3::Zero(), ""});
  run.tick();
  EXPECT_EQ(run.metrics.outcome(), "crashed");
  EXPECT_EQ(run.text("outcome", "uav1"), "done");
  EXPECT_EQ(run.text("outcome", "uav2"), "timeout");
  EXPECT_EQ(run.text("outcome", "uav3"), "failed");
  EXPECT_EQ(run.text("outcome", "uav4"), "crashed");
  EXPECT_EQ(run.text("crash_partner", "uav4"), "trunk 17");
  EXPECT_NEAR(run.value("crash_time_s", "uav4"), 0.043, 1e-12);
}

TEST(Metrics, RefusesMissionCompletionAfterACrash) {
  MetricsRun run(3);
  run.actions[1].mission = MissionStatus::kDone;
  run.tick();
  run.states[0].crashed = run.states[1].crashed = true;
  run.tick();
  for (Action& action : run.actions) action.mission = MissionStatus::kDone;
  run.tick();
  EXPECT_EQ(run.text("outcome", "uav1"), "crashed");
  EXPECT_EQ(run.text("outcome", "uav2"), "crashed");
  EXPECT_TRUE(std::isnan(run.value("time_to_done_s", "uav1")));
  EXPECT_TRUE(std::isnan(run.value("time_to_done_s", "uav2"))) << "uav2 was done before, but the run counts as a crash";
  EXPECT_NEAR(run.value("time_to_done_s", "uav3"), 0.03, 1e-12);
}

TEST(Metrics, AWreckIsMeasuredNoMore) {
  MetricsRun run(2);
  run.states[1].p_world_m.x() = 10.0;
  run.tick();
  run.clearances[0].surface_m = -0.1;
  run.states[0].crashed = true;
  run.tick();
  EXPECT_EQ(run.value("min_clearance_surface_m"), -0.1) << "the tick of the crash counts";
  run.clearances[0].surface_m = -0.4;
  run.states[0].p_world_m.x() = 8.0;
  run.tick();
  EXPECT_EQ(run.value("min_clearance_surface_m"), -0.1);
  EXPECT_EQ(run.value("min_separation_m", "uav1"), 10.0);
  EXPECT_EQ(run.value("min_separation_m", "uav2"), 2.0) << "others still keep their distance to it";
}

TEST(Metrics, UpdatesDoNotAllocate) {
  MetricsRun run(5);
  for (Action& action : run.actions) action.estimate.valid = true;
  run.tick();
  const std::uint64_t before = test::num_allocations();
  for (int i = 0; i < 100; ++i) run.tick();
  EXPECT_EQ(test::num_allocations(), before);
}

/// A user-defined metric with a table of its own.
struct Height {
  static constexpr const char* kName = "height";
  TimeNs t = 0;
  double height_m = 0.0;

  static void visit(auto& h, auto& v) {
    v.time("t_s", h.t, "[s] of the tick");
    v.field("height_m", h.height_m, "[m] above the world's origin");
  }
};

class HeightMetric final : public Metric {
 public:
  explicit HeightMetric(const MetricSetup& setup) : Metric(setup), heights_(add_series<Height>()) {}
  void update(const TickView& tick, const MetricContext&) override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      heights_.push(static_cast<VehicleId>(i), {tick.t, tick.states[i].p_world_m.z()});
    }
  }
  void report(MetricTable&) const override {}

 private:
  SeriesOf<Height>& heights_;
};

TEST(Metrics, CustomMetricsHaveSeriesByTick) {
  MetricSetup setup;
  setup.vehicle_names = {"uav1", "uav2"};
  HeightMetric metric(setup);
  std::vector<VehicleState> states(2);
  states[1].p_world_m.z() = 7.0;
  TickView tick;
  tick.t = kTick;
  tick.states = states;
  metric.update(tick, {});
  ASSERT_EQ(metric.series().size(), 1U);
  const Series& series = *metric.series().front();
  EXPECT_EQ(series.name(), "height");
  ASSERT_EQ(series.columns().size(), 2U);
  EXPECT_EQ(series.columns()[1].name, "height_m");
  ASSERT_EQ(series.size(), 2U);
  EXPECT_EQ(series.about(1), 1);
  EXPECT_EQ(rows_of<Height>(std::vector<const Series*>{&series})[1].height_m, 7.0);
}

TEST(Metrics, HasSameRowsForEveryVehicle) {
  MetricsRun run(3);
  run.tick();
  std::vector<std::string> first, third;
  for (const MetricRow& row : run.metrics.rows()) {
    if (row.vehicle == "uav1") first.push_back(row.name);
    if (row.vehicle == "uav3") third.push_back(row.name);
  }
  EXPECT_GT(first.size(), 20U);
  EXPECT_EQ(first, third);
}

}  // namespace
}  // namespace swiftlet::sim
