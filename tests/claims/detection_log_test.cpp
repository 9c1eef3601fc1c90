// SPDX-License-Identifier: BSD-3-Clause
#include "detection_log.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <tuple>
#include <vector>

#include "parallel.hpp"
#include "swiftlet/core/action.hpp"
#include "swiftlet/sim/view/recorder.hpp"

namespace swiftlet::tools {
namespace {

// Perfect tracks, so that the results depend on the log alone, not on a tracker.
sim::Scenario hall_with_perfect_tracks(double duration_s) {
  return scenario_with("reproduce/detection_multi.yaml", 1,
                       {{"duration_s", std::to_string(duration_s)},
                        {"vehicles[0].agent.detector", "{type: none}"},
                        {"vehicles[0].agent.tracker", "{type: ground_truth}"}});
}

TEST(DetectionLog, JudgesATrackerOnceAScanInTheWorldThatItsObserverBelievesIn) {
  const sim::Scenario scenario = hall_with_perfect_tracks(3.0);
  DetectionLog log(scenario, -45.0, 45.0, 1.0);
  sim::Simulation simulation(scenario, 1);
  while (!simulation.finished()) {
    simulation.tick();
    log.add(simulation);
  }
  EXPECT_NEAR(static_cast<double>(log.tracks().size()), 3 * 20.0, 3.0);  // tracks are reported in every tick
  double drift_m = 0.0;
  for (const Sighting& sighting : log.tracks()) {
    EXPECT_TRUE(sighting.found);
    EXPECT_LT(sighting.error_m, 0.02);
    EXPECT_LT((sighting.estimate_m - sighting.p_m).norm(), 0.1);
    EXPECT_TRUE(sighting.visible || sighting.points == 0);
    drift_m = std::max(drift_m, sighting.drifted_error_m);
  }
  EXPECT_GT(drift_m, 0.02);  // the observer's odometry is noisy and drifts
  EXPECT_EQ(log.num_cross_associations(), 0);
  EXPECT_EQ(log.num_false_tracks(), 0);
  EXPECT_EQ(log.num_told_tracks(), static_cast<int>(log.tracks().size())) << "one for each of three targets";
  EXPECT_EQ(log.num_false_told_tracks(), 0);

  // Restored numbers give the same results.
  DetectionLog restored(scenario, -45.0, 45.0, 1.0);
  restored.restore(log.numbers());
  EXPECT_EQ(restored.num_cross_associations(), log.num_cross_associations());
  EXPECT_EQ(restored.num_false_tracks(), log.num_false_tracks());
  EXPECT_EQ(restored.num_false_detections(), log.num_false_detections());
  EXPECT_EQ(restored.num_told_tracks(), log.num_told_tracks());
  EXPECT_EQ(restored.observed_s(), log.observed_s());
  EXPECT_EQ(restored.detections().size(), log.detections().size());
  ASSERT_EQ(restored.tracks().size(), log.tracks().size());
  for (std::size_t i = 0; i < log.tracks().size(); ++i) {
    const Sighting &a = restored.tracks()[i], &b = log.tracks()[i];
    EXPECT_EQ(
        std::tuple(a.t, a.told, a.target, a.range_m, a.visible, a.points, a.found, a.error_m, a.track, a.in_view_s),
        std::tuple(b.t, b.told, b.target, b.range_m, b.visible, b.points, b.found, b.error_m, b.track, b.in_view_s));
    EXPECT_EQ(a.p_m, b.p_m);
    EXPECT_EQ(a.estimate_m, b.estimate_m);
    EXPECT_EQ(a.drifted_error_m, b.drifted_error_m);
  }
}

TEST(DetectionLog, ATargetIsThereOnceHoweverOftenItIsTold) {
  std::vector<Detection> told(4);
  for (std::size_t i = 0; i < told.size(); ++i) told[i].confidence = std::array{0.4, 0.9, 0.6, 0.95}[i];
  EXPECT_EQ(surest_of(told, std::vector{0.1, 0.5, 0.2, 3.5}), 1U);  // the last one is too far off
  EXPECT_EQ(surest_of(told, std::vector{0.1, 4.0, 5.0, 3.5}), 0U);
  EXPECT_FALSE(surest_of(told, std::vector{3.0, 4.0, 5.0, 3.5}).has_value());
  EXPECT_FALSE(surest_of({}, {}).has_value());
}

// An odometry at 10 Hz does not capture the tilt between samples: without an inertial unit the map's walls are meters
// off, and targets in front of them become background.
TEST(DetectionScenarios, TheObserverInTheHallKnowsItsAttitude) {
  sim::Simulation simulation(hall_with_perfect_tracks(6.0), 1);
  double worst_rad = 0.0;
  while (!simulation.finished()) {
    simulation.tick();
    const sim::TickView& view = simulation.view();
    const Matrix3 believed = view.actions[0]->estimate.T_local_body.linear();
    const Matrix3 error = believed.transpose() * view.states[0].q_world_body.toRotationMatrix();
    worst_rad = std::max(worst_rad, Eigen::AngleAxisd(error).angle());
  }
  EXPECT_LT(worst_rad, 0.015);
}

}  // namespace
}  // namespace swiftlet::tools
