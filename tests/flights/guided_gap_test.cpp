// SPDX-License-Identifier: BSD-3-Clause
// Cooperative guidance in the full simulation [Pritzl 2024]: OS0-128, map, detector, tracker, relative localization,
// plans and radio take a UAV with nothing but visual-inertial odometry through a gap and back.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "swiftlet/sim/metrics/relative_score.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::sim {
namespace {

struct GuidedFlight {
  RunSummary summary;
  std::set<std::string> notes;  ///< notes of the guide
  int passes = 0;               ///< passages of the guided vehicle through the wall
  bool guide_passed = false;
  double error_in_gap_m = 0.0;  ///< mean, within 1 m of the gap's center
};

/// Coordinate along the path through the gap, from its center.
double along_gap_m(const Vector3& p_world_m) {
  constexpr double kYaw = 25.0 * 3.14159265358979323846 / 180.0;
  return p_world_m.x() * std::cos(kYaw) + p_world_m.y() * std::sin(kYaw);
}

GuidedFlight fly(std::vector<std::pair<std::string, std::string>> changes) {
  changes.emplace_back("recorders", "[]");
  changes.emplace_back("snapshots", "[]");
  Simulation simulation(load_scenario("guided_gap", changes));
  GuidedFlight flight;
  double sum_m = 0.0, before_m = -1.0;
  int num = 0;
  while (!simulation.finished()) {
    simulation.tick();
    const TickView& view = simulation.view();
    const double at_m = along_gap_m(view.states[1].p_world_m);
    flight.passes += (at_m > 0.0) != (before_m > 0.0);
    before_m = at_m;
    flight.guide_passed = flight.guide_passed || along_gap_m(view.states[0].p_world_m) > 0.0;
    for (const Event& event : view.events) {
      if (event.vehicle == 0) flight.notes.insert(event.note);
    }
    for (const RelativeScore& score : rows_of<RelativeScore>(simulation.info().series)) {
      if (view.states[1].p_world_m.head<2>().norm() > 1.0) continue;
      sum_m += score.error_world_m.norm();
      ++num;
    }
  }
  flight.error_in_gap_m = sum_m / num;
  flight.summary = simulation.summary();
  return flight;
}

TEST(GuidedGapInFull, SmallVehiclePassesTwice) {
  const GuidedFlight flight = fly({{"duration_s", "60"}});
  EXPECT_EQ(flight.summary.outcome, "done");
  EXPECT_EQ(flight.passes, 2);
  EXPECT_FALSE(flight.guide_passed);
  for (const char* note : {"planning", "primary moving", "secondary moving", "goal reached"}) {
    EXPECT_TRUE(flight.notes.count(note)) << note;
  }
  EXPECT_LT(flight.error_in_gap_m, 0.10) << "[Pritzl 2024, sec. III-A]";
}

constexpr const char* kLidarAndImu =
    "{type: lidar, name: os0, model: os0_128_sheet, mount: {position_m: [0, 0, 0.15]}}, "
    "{type: imu, name: imu, model: imu_adis16448}";

/// Outcome of a flight with another localization of the guide.
void expect_two_passes(const std::string& localization, const std::string& more_sensors) {
  const GuidedFlight flight = fly({{"duration_s", "60"},
                                   {"vehicles[primary].sensors", std::string("[") + kLidarAndImu + more_sensors + "]"},
                                   {"vehicles[primary].agent.localization", "{type: " + localization + "}"}});
  EXPECT_EQ(flight.summary.outcome, "done");
  EXPECT_EQ(flight.passes, 2);
  EXPECT_FALSE(flight.guide_passed);
}

TEST(GuidedGapInFull, GuideLocalizesBySlam) { expect_two_passes("slam", ""); }

TEST(GuidedGapInFull, GuideLocalizesByDriftingOdometry) {
  expect_two_passes("odometry", ", {type: odometry, name: vio, model: odometry_vio}");
}

TEST(GuidedGapInFull, GuideLocalizesByGnss) {
  expect_two_passes("ins",
                    ", {type: gnss, name: gnss, model: gnss_rtk}, {type: compass, name: compass}, "
                    "{type: altimeter, name: altimeter}");
}

TEST(GuidedGapInFull, EndsMissionSafelyWithoutRadioLink) {
  const GuidedFlight flight = fly({{"duration_s", "60"}, {"radio.loss_probability", "1"}});
  EXPECT_NE(flight.summary.outcome, "crashed");
  EXPECT_EQ(flight.passes, 0);
  EXPECT_TRUE(flight.notes.count("idle: the guided vehicle is not localized yet"));
}

}  // namespace
}  // namespace swiftlet::sim
