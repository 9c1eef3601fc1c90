// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/agent/stack.hpp"
#include "swiftlet/core/control/reference_governor.hpp"
#include "swiftlet/core/localization/ins.hpp"
#include "swiftlet/core/stages/estimators.hpp"
#include "swiftlet/core/stages/guidances.hpp"
#include "tests/support/airframes.hpp"
#include "tests/support/fine_plant.hpp"

namespace swiftlet {
namespace {

constexpr TimeNs kTick = 4'000'000;

/// The whole agent of one vehicle with a pose in every tick. The poses come from a recorded flight, so that only the
/// agent is measured.
void stack(benchmark::State& state, const char* guidance) {
  AgentSetup setup;
  setup.airframe = testing::x500();
  setup.T_local_body_start.translation() = Vector3(0, 0, 6);
  Module module(agent_module_types(), "stack");
  module.as<StackConfig>().guidance = Module(guidance_module_types(), guidance);
  module.as<StackConfig>().control.limits.set = MotionLimitsConfig::Set::kAgile;

  std::vector<PoseSample> flight;
  {
    const auto agent = make_agent(module, setup);
    testing::FinePlant plant(setup.airframe);
    plant.p = {0.2, -0.1, 6};
    Observation observation;
    for (int i = 0; i < 5000; ++i) {
      observation.t = plant.t;
      observation.pose = {plant.pose_sample()};
      flight.push_back(plant.pose_sample());
      plant.advance(agent->step(observation).rotor_command, to_seconds(kTick));
    }
  }

  auto agent = make_agent(module, setup);
  Observation observation;
  observation.pose.resize(1);
  TimeNs t = 0;
  std::size_t i = 0;
  for (auto _ : state) {
    t += kTick;
    i = i + 1 == flight.size() ? 0 : i + 1;
    observation.t = t;
    observation.pose[0] = flight[i];
    observation.pose[0].t = t;
    benchmark::DoNotOptimize(agent->step(observation).rotor_command);
  }
}
BENCHMARK_CAPTURE(stack, hover, "hover");
BENCHMARK_CAPTURE(stack, agile, "agile");

void reference_governor(benchmark::State& state) {
  MotionLimitsConfig limits;
  ReferenceGovernor governor(limits.resolve());
  governor.reset({});
  Reference goal;
  int i = 0;
  for (auto _ : state) {
    if (++i % 2000 == 0) goal.position_m = Vector3(i % 3, i % 5, i % 7) * 3.0;
    benchmark::DoNotOptimize(governor.step(goal, 0.004));
  }
}
BENCHMARK(reference_governor);

void controller(benchmark::State& state) {
  MultirotorController controller(testing::x500(), {}, 0.004);
  StateEstimate estimate;
  estimate.valid = true;
  const Reference reference;
  double x = 0.0;
  for (auto _ : state) {
    estimate.T_local_body.translation().x() = x = 0.1 - x;
    benchmark::DoNotOptimize(controller.step(estimate, reference, Vector3::Zero(), 0.004));
  }
}
BENCHMARK(controller);

void ins_predict(benchmark::State& state) {
  InsFilter filter({}, Pose::Identity());
  ImuSample sample;
  sample.specific_force_body_mps2 = {0.0, 0.0, 9.81};
  for (auto _ : state) {
    sample.t += kTick;
    filter.predict(sample);
    benchmark::DoNotOptimize(filter.state());
  }
}
BENCHMARK(ins_predict);

void ins_update_gnss(benchmark::State& state) {
  InsFilter filter({}, Pose::Identity());
  GnssSample sample;
  for (auto _ : state) {
    filter.update(sample);
    benchmark::DoNotOptimize(filter.state());
  }
}
BENCHMARK(ins_update_gnss);

}  // namespace
}  // namespace swiftlet
