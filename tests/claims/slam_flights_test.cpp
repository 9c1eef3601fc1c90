// SPDX-License-Identifier: BSD-3-Clause
// Evaluation of flights on SLAM.
#include "slam_flights.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "parallel.hpp"
#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::tools {
namespace {

/// Straight line of `steps` steps of 1 m as estimated with a scale error and a turn in each step.
std::vector<Pose> straight_line(int steps, double scale, double turn_a_step_rad) {
  std::vector<Pose> poses{Pose::Identity()};
  const Pose step = make_pose({scale, 0, 0}, rotation_by({0, 0, turn_a_step_rad}));
  for (int i = 0; i < steps; ++i) poses.push_back(poses.back() * step);
  return poses;
}

TEST(SlamFlights, AScaleThatIsOffByAPercentDriftsByAPercentOverAnyLength) {
  const std::vector<Pose> truth = straight_line(100, 1.0, 0.0), estimate = straight_line(100, 1.01, 0.0);
  for (const double length_m : {10.0, 50.0}) {
    const std::vector<double> drifts = drifts_percent(truth, estimate, length_m);
    ASSERT_FALSE(drifts.empty());
    for (const double drift : drifts) EXPECT_NEAR(drift, 1.0, 1e-9);
  }
  EXPECT_EQ(drifts_percent(truth, estimate, 50.0).size(), 11U) << "begun every 5 m of the first 50 m";
  EXPECT_TRUE(drifts_percent(truth, estimate, 101.0).empty()) << "the way is too short";
}

TEST(SlamFlights, WhereTheFramesLieDoesNotMatterForDrift) {
  const std::vector<Pose> truth = straight_line(60, 1.0, 0.01);
  std::vector<Pose> estimate = truth;
  for (Pose& T : estimate) T = make_pose({5, -7, 3}, rotation_by({0.1, 0.2, 2.0})) * T;
  for (const double drift : drifts_percent(truth, estimate, 20.0)) EXPECT_NEAR(drift, 0.0, 1e-9);
}

// A turn of w rad a meter over L m gives a position error of L - sin(wL)/w ahead and (1 - cos(wL))/w aside.
TEST(SlamFlights, ATurnThatNobodyFliesBendsTheWayIntoACircle) {
  const double w = 0.002, L = 50.0;
  const std::vector<double> drifts = drifts_percent(straight_line(100, 1.0, 0.0), straight_line(100, 1.0, w), L);
  const double off_m = std::hypot(L - std::sin(w * L) / w, (1.0 - std::cos(w * L)) / w);
  ASSERT_FALSE(drifts.empty());
  for (const double drift : drifts) EXPECT_NEAR(drift, 100.0 * off_m / L, 0.15);  // steps of 1 m are chords
}

TEST(SlamFlights, TheMedianLeavesOutWhatWasNotMeasured) {
  EXPECT_EQ(median_of({3.0, std::nan(""), 1.0, 2.0}), 2.0);
  EXPECT_EQ(median_of({4.0, 1.0}), 2.5);
  EXPECT_TRUE(std::isnan(median_of({std::nan("")})));
}

// To and fro beside the building: submaps of the return path overlap those of the outward path.
sim::Scenario to_and_fro(const std::string& form) {
  return scenario_with("campus_slam", 1,
                       {{"vehicles[0].agent.mapping", "none"},
                        {"vehicles[0].agent.localization.global.blend.form", form},
                        {"vehicles[0].agent.guidance.waypoints_m", "[[7.5, -10, 3], [-12.5, -10, 3]]"},
                        {"duration_s", "42"}});
}

TEST(SlamFlights, ClosuresAreHeldAgainstTruthAndAFlightThatIsReadAgainSaysTheSame) {
  const TemporaryDirectory folder;
  std::vector<SlamFlight> flights;
  for (const bool resume : {false, true}) {
    const Experiment experiment({.directory = folder.path(), .resume = resume});
    flights.push_back(fly_on_slam(experiment, {to_and_fro("limited")}).front());
  }
  const SlamFlight &flown = flights[0], &read = flights[1];
  EXPECT_FALSE(flown.crashed);
  EXPECT_EQ(flown.lost_s, 0.0);
  EXPECT_NEAR(flown.time_s, 42.0, 0.01);
  EXPECT_GT(flown.way_m, 60.0);
  EXPECT_GE(flown.closures.revisits, 2);
  EXPECT_GE(flown.closures.closed, 1);
  EXPECT_EQ(flown.closures.false_ones, 0);
  EXPECT_LT(flown.closures.worst_m, 0.1);
  EXPECT_GT(flown.corrected_s, 20.0);
  EXPECT_GT(flown.correction.largest_m, 0.0);
  EXPECT_LT(flown.correction.step_m, 1e-5) << "the limited form has none";
  EXPECT_GT(flown.drift_10m_percent, 0.0);
  EXPECT_LT(flown.graph.rms_m, 0.1);

  EXPECT_EQ(read.way_m, flown.way_m);
  EXPECT_EQ(read.nees, flown.nees);
  EXPECT_EQ(read.correction.count, flown.correction.count);
  EXPECT_EQ(read.closures.worst_m, flown.closures.worst_m);
  EXPECT_EQ(read.closures.revisits_closed, flown.closures.revisits_closed);
  EXPECT_EQ(read.graph.climb_m, flown.graph.climb_m);
  ASSERT_EQ(read.moments.size(), flown.moments.size());
  EXPECT_EQ(read.moments.back().p_shown_m, flown.moments.back().p_shown_m);
}

TEST(SlamFlights, WithoutAnyBlendTheStepIsTheWholeCorrection) {
  const SlamFlight f = fly_on_slam(Experiment({}), {to_and_fro("none")}).front();
  ASSERT_GE(f.correction.count, 1);
  EXPECT_GT(f.correction.step_m, 1e-4);
  EXPECT_EQ(f.correction.speed_mps, 0.0) << "nothing moves between the steps";
  EXPECT_LE(f.correction.step_m, f.correction.largest_m + 1e-9);
}

}  // namespace
}  // namespace swiftlet::tools
