// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>

#include "sim/run/finite_values.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"
#include "swiftlet/core/stage_tables/detectors.hpp"
#include "swiftlet/core/stage_tables/mappers.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/radio/radio.hpp"
#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/run/memory.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/sensors/compass.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {
namespace {

using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Vehicles in a row, far from each other.
Scenario row_of(int count) {
  Scenario scenario;
  scenario.duration_s = 0.5;
  scenario.vehicles.clear();
  for (int i = 0; i < count; ++i) {
    VehicleConfig vehicle;
    vehicle.start.position_m = {10.0 * i, 0.0, 5.0};
    scenario.vehicles.push_back(vehicle);
  }
  return validated(scenario);
}

std::string violation_of(const Scenario& scenario, int threads) {
  try {
    Simulation simulation(scenario, threads);
    while (!simulation.finished()) simulation.tick();
  } catch (const ContractViolation& violation) {
    return violation.what();
  }
  return "none";
}

// More vehicles than it takes to fly them in a parallel region, out of which no exception may fall.
TEST(Contracts, EndRunAtNonFiniteState) {
  Scenario scenario = row_of(20);
  ASSERT_EQ(violation_of(scenario, 2), "none");
  scenario.wind.mean_mps = {1e200, 0.0, 0.0};
  const std::string violation = violation_of(scenario, 1);
  EXPECT_THAT(violation, HasSubstr("ENSURE(is_finite(state)): vehicle.name = \"uav1\", to_seconds(t) = 0.00"));
  EXPECT_EQ(violation_of(scenario, 2), violation);
  EXPECT_EQ(violation_of(scenario, 4), violation);
}

TEST(Contracts, ReportNonFiniteSamplesWithContext) {
  for (const int vehicles : {1, 20}) {
    Scenario scenario = row_of(vehicles);
    Module compass(sensor_module_types(), "compass");
    compass.as<CompassConfig>().sigma_deg = kNan;
    scenario.vehicles.back().sensors.push_back(compass);
    const std::string violation = violation_of(scenario, 2);
    EXPECT_THAT(violation, StartsWith("uav" + std::to_string(vehicles) + " at 0.0"));
    EXPECT_THAT(violation, HasSubstr("sensor = \"compass\""));
  }
}

TEST(Contracts, CheckEveryPartOfAnAction) {
  const auto broken = [](const auto& spoil) {
    Action action;
    action.estimate.valid = action.has_tracks = true;
    action.detections.resize(1);
    action.tracks.resize(1);
    EXPECT_NO_THROW(ensure_finite(action));
    spoil(action);
    EXPECT_THROW(ensure_finite(action), ContractViolation);
  };
  broken([](Action& a) { a.rotor_command[7] = kNan; });
  broken([](Action& a) { a.estimate.T_local_body.translation().z() = kNan; });
  broken([](Action& a) { a.estimate.covariance(5, 5) = HUGE_VAL; });
  broken([](Action& a) { a.reference.acceleration_mps2.x() = -HUGE_VAL; });
  broken([](Action& a) { a.reference.yaw_rad = kNan; });
  broken([](Action& a) { a.detections[0].position_m.y() = kNan; });
  broken([](Action& a) { a.tracks[0].covariance(8, 8) = kNan; });
}

TEST(Contracts, IgnoreInvalidEstimates) {
  Action action;
  action.estimate.v_local_mps.x() = kNan;
  EXPECT_NO_THROW(ensure_finite(action));
}

TEST(Contracts, CheckEveryRangeOfAScan) {
  Observation observation;
  auto scan = std::make_shared<Scan>();
  scan->range_m.assign(1001, 5.0F);
  observation.scans.push_back(scan);
  EXPECT_NO_THROW(ensure_finite(observation));
  for (const std::size_t i : {0U, 500U, 1000U}) {
    for (const float bad :
         {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(), -INFINITY}) {
      scan->range_m[i] = bad;
      EXPECT_THROW(ensure_finite(observation), ContractViolation) << i;
      scan->range_m[i] = 5.0F;
    }
  }
}

TEST(Contracts, RefuseForgottenInstantsOfAHistory) {
  StateHistory history(1, 4);
  VehicleState state;
  for (state.t = 0; state.t < 3; ++state.t) history.push(0, state);
  EXPECT_NO_THROW(history.at(0, -5)) << "before the start the first state holds";
  for (; state.t < 10; ++state.t) history.push(0, state);
  EXPECT_NO_THROW(history.at(0, 6));
  EXPECT_THROW(history.at(0, 5), ContractViolation);
  EXPECT_THROW(history.at(1, 6), ContractViolation);
}

TEST(Counters, SummarizeOverflowsWithTheirSetting) {
  RunSummary summary;
  summary.counters = {{"messages dropped from full queues", 3, 10, "radio.queue_limit_kB"},
                      {"returns outside the detector's map", 0, 10, "vehicles[0].agent.detector.map.size_m"}};
  const auto counters = nlohmann::json::parse(to_json(summary))["counters"];
  ASSERT_EQ(counters.size(), 1U) << "only what happened";
  EXPECT_EQ(counters[0]["setting"], "radio.queue_limit_kB");
  EXPECT_EQ(counters[0]["count"], 3);
  EXPECT_EQ(counters[0]["of"], 10);
  EXPECT_THAT(to_text(summary), HasSubstr("radio.queue_limit_kB: 3 of 10 messages dropped from full queues"));
}

TEST(Counters, MergeVehiclesIntoOneLine) {
  const auto far = [](int vehicle, std::uint64_t count) {
    return Counter{"returns too far", count, 10, "vehicles[" + std::to_string(vehicle) + "].agent.mapping.range_max_m"};
  };
  RunSummary summary;
  summary.counters = {far(0, 0), far(1, 3)};
  EXPECT_THAT(to_text(summary), HasSubstr("vehicles[1].agent.mapping.range_max_m: 3 of 10 returns too far\n"));
  summary.counters.push_back(far(12, 4));
  EXPECT_THAT(to_text(summary), HasSubstr("vehicles[*].agent.mapping.range_max_m: 7 of 30 returns too far\n"));
  EXPECT_THAT(to_text(summary), Not(HasSubstr("vehicles[1]")));
}

TEST(Counters, NameAgentSettingByScenarioPath) {
  Scenario scenario = row_of(2);
  scenario.vehicles[1].agent.as<StackConfig>().detector = Module(detector_module_types(), "vofod");
  scenario.vehicles[1].sensors.emplace_back(sensor_module_types(), "lidar");
  std::vector<std::string> settings;
  for (const Counter& counter : Simulation(scenario, 1).summary().counters) settings.push_back(counter.setting);
  EXPECT_THAT(settings, Each(AnyOf("radio.queue_limit_kB", "vehicles[1].agent.detector.timing.classification_latency_s",
                                   "vehicles[1].agent.detector.map.size_m")));
  EXPECT_THAT(settings, Contains("vehicles[1].agent.detector.map.size_m"));
}

/// A recorder that allocates more memory than available.
class HungryRecorder : public Recorder {
 public:
  void begin(const RunInfo&) override {}
  void write(const TickView&) override { throw std::bad_alloc(); }
  std::vector<std::filesystem::path> finish() override { return {}; }
};

TEST(Contracts, NameStageRunningOutOfMemory) {
  Simulation simulation(row_of(1), 1);
  simulation.attach(std::make_unique<HungryRecorder>(), "");
  try {
    simulation.tick();
    FAIL() << "no exception";
  } catch (const OutOfMemory& problem) {
    EXPECT_STREQ(problem.what(), "out of memory in the stage recorders at 0.000000 s");
  }
}

Scenario with_detector(const std::function<void(VofodConfig&)>& change) {
  Scenario scenario = row_of(1);
  Module detector(detector_module_types(), "vofod");
  change(detector.as<VofodConfig>());
  scenario.vehicles[0].agent.as<StackConfig>().detector = detector;
  return scenario;
}

std::string refusal_of(const Scenario& scenario) {
  try {
    require_memory(scenario);
  } catch (const InputError& problem) {
    return problem.what();
  }
  return "none";
}

TEST(Memory, RefusesExcessBeforeFlightByKey) {
  EXPECT_EQ(refusal_of(with_detector([](VofodConfig&) {})), "none");
  const Scenario large = with_detector([](VofodConfig& vofod) { vofod.map.size_m = {1e5, 1e5, 1e4}; });
  EXPECT_THAT(refusal_of(large), HasSubstr("vehicles[0].agent.detector.map.size_m: expected a setting that fits into"));
  EXPECT_THROW(Simulation(large, 1), InputError);
  const Scenario far = with_detector([](VofodConfig& vofod) { vofod.ray_max_m = 1000.0; });
  EXPECT_EQ(refusal_of(far), "none") << "rays end where the map does";
  // Many small needs are one large one.
  Scenario team = row_of(50);
  Module detector(detector_module_types(), "vofod");
  detector.as<VofodConfig>().map.size_m = {500.0, 500.0, 50.0};
  for (VehicleConfig& vehicle : team.vehicles) vehicle.agent.as<StackConfig>().detector = detector;
  EXPECT_THAT(refusal_of(team), HasSubstr(" MiB in all"));
}

}  // namespace
}  // namespace swiftlet::sim
