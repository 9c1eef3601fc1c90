// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <set>

#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/stage_tables/detectors.hpp"
#include "swiftlet/core/stage_tables/estimators.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"
#include "swiftlet/core/stage_tables/mappers.hpp"
#include "swiftlet/core/stage_tables/relative_localizers.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::Contains;

/// All that the agents of a scenario draw in its first seconds.
std::set<std::string> drawn_in(const std::string& name, double duration_s) {
  Scenario scenario = load_scenario(name, {{"duration_s", std::to_string(duration_s)}, {"recorders", "[]"}});
  scenario.snapshots = std::vector<CameraConfig>(1);
  scenario.snapshots[0].name = "every";
  scenario.snapshots[0].every_s = 0.1;
  Simulation simulation(scenario, 1);
  std::set<std::string> names;
  while (!simulation.finished()) {
    simulation.tick();
    for (const Action* action : simulation.view().actions) {
      for (const Overlay& overlay : action->overlays) names.insert(overlay.name);
    }
  }
  return names;
}

std::vector<std::string> listed_overlays_of(const char* scenario) {
  return overlays_of(load_scenario(scenario).vehicles[0].agent).value();
}

TEST(OverlayNames, CoverEverythingThatIsDrawn) {
  for (const auto& [scenario, duration_s] : {std::pair("guided_gap", 6.0),
                                             {"navigate", 3.0},
                                             {"warehouse_explore", 2.0},
                                             {"interception", 2.0},
                                             {"field_detection", 1.0},
                                             {"square", 1.0},
                                             {"submap_navigation", 2.0},
                                             {"campus_slam", 1.0},
                                             {"reproduce/rbl_crossing", 1.0}}) {
    const std::vector<std::string> listed = listed_overlays_of(scenario);
    for (const std::string& name : drawn_in(scenario, duration_s)) EXPECT_THAT(listed, Contains(name)) << scenario;
  }
}

TEST(OverlayNames, AreListedByEveryStageType) {
  const auto expect_listed = [](const auto& rows) {
    for (const auto& row : rows) EXPECT_NE(row.overlays, nullptr) << row.module.name;
  };
  expect_listed(estimator_registry().rows());
  expect_listed(detector_registry().rows());
  expect_listed(relative_localizer_registry().rows());
  expect_listed(mapper_registry().rows());
  expect_listed(guidance_registry().rows());
}

}  // namespace
}  // namespace swiftlet::sim
