// SPDX-License-Identifier: BSD-3-Clause
// Physics of vehicles without control: one step of one vehicle in each situation, and a fleet of a hundred.
// "items" are vehicle-steps; "real_time" is simulated over wall time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/physics/physics_world.hpp"
#include "swiftlet/sim/registry/worlds.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kTick_s = 0.004;

Airframe quad() {
  Airframe airframe;
  const double side = airframe.arm_length_m / std::numbers::sqrt2;
  airframe.rotors = {{{side, -side, 0.05}, Rotor::Spin::kCcw},
                     {{-side, side, 0.05}, Rotor::Spin::kCcw},
                     {{side, side, 0.05}, Rotor::Spin::kCw},
                     {{-side, -side, 0.05}, Rotor::Spin::kCw}};
  return airframe;
}

/// The forest of the quickstart, built once.
const std::shared_ptr<const StaticScene>& forest() {
  static const auto scene = std::make_shared<const StaticScene>(make_world(Module(world_module_types(), "forest"), 1));
  return scene;
}

double ground_m(double x, double y) {
  // Crowns hide the ground from above; the lowest hit of a ray from below is the ground itself.
  return forest()->trace({x, y, -50.0}, Vector3::UnitZ(), 200.0).range_m - 50.0;
}

/// Positions at a height above the ground with the given clearance, by rejection sampling.
std::vector<Vector3> places(int count, double height_m, double room_m) {
  const Random random(5, "bench.places");
  std::vector<Vector3> found;
  for (std::uint32_t n = 0; static_cast<int>(found.size()) < count && n < 100000; ++n) {
    const double x = random.uniform(-25, 25, n, 0);
    const double y = random.uniform(-25, 25, n, 1);
    const Vector3 place(x, y, ground_m(x, y) + height_m);
    const bool apart =
        std::all_of(found.begin(), found.end(), [&](const Vector3& p) { return (p - place).norm() > 2.0; });
    if (apart && !forest()->nearest(place, room_m)) found.push_back(place);
  }
  if (static_cast<int>(found.size()) < count) throw std::runtime_error("bench: not enough room in the forest");
  return found;
}

struct Fleet {
  Fleet(const std::vector<Vector3>& places, bool flying, const PhysicsConfig& config, const WindConfig& wind = {}) {
    std::vector<PhysicsVehicle> vehicles;
    const Airframe airframe = quad();
    for (const Vector3& place : places) {
      PhysicsVehicle vehicle{"uav" + std::to_string(vehicles.size()), airframe, {}, flying};
      vehicle.start.p_world_m = place;
      vehicles.push_back(vehicle);
    }
    commands.resize(vehicles.size());
    const double hover = (airframe.hover_rotor_speed_radps() - airframe.rotor_speed_min_radps) /
                         (airframe.rotor_speed_max_radps - airframe.rotor_speed_min_radps);
    for (auto& command : commands) command.fill(flying ? hover : -1.0);
    history = StateHistory(static_cast<int>(vehicles.size()), 256);
    world = std::make_unique<PhysicsWorld>(config, wind, std::move(vehicles), forest(), 1);
  }

  void run(benchmark::State& state, double step_s, bool with_clearance) {
    const TimeNs tick = from_seconds(kTick_s);
    for (auto _ : state) {
      now += tick;
      world->advance(now, commands, history);
      for (std::size_t i = 0; with_clearance && i < commands.size(); ++i) {
        benchmark::DoNotOptimize(world->clearance(static_cast<VehicleId>(i), 20.0));
      }
    }
    const double ticks = static_cast<double>(state.iterations());
    state.SetItemsProcessed(static_cast<std::int64_t>(ticks * kTick_s / step_s * static_cast<double>(commands.size())));
    state.counters["real_time"] = benchmark::Counter(ticks * kTick_s, benchmark::Counter::kIsRate);
  }

  TimeNs now = 0;
  std::vector<std::array<double, kMaxRotors>> commands;
  StateHistory history;
  std::unique_ptr<PhysicsWorld> world;
};

PhysicsConfig without_lift() {
  PhysicsConfig config;
  // ground effect at full cost but without lift, so that vehicles stay in place
  config.ground_effect_coefficient = 1e-9;
  return config;
}

void above_the_forest(benchmark::State& state) { Fleet({{0, 0, 80}}, true, {}).run(state, 0.001, false); }
void among_the_trunks(benchmark::State& state) {
  Fleet(places(1, 3.0, 1.2), true, without_lift()).run(state, 0.001, false);
}
void among_the_trunks_with_clearance(benchmark::State& state) {
  Fleet(places(1, 3.0, 1.2), true, without_lift()).run(state, 0.001, true);
}
void in_gusts(benchmark::State& state) {
  WindConfig wind;
  wind.gusts = true;
  wind.wind_at_6m_mps = 0.1;
  Fleet({{0, 0, 80}}, true, {}, wind).run(state, 0.001, false);
}
/// Closer to the ground than the circumscribed sphere allows: narrow phase in every step.
void skimming(benchmark::State& state) { Fleet(places(1, 0.3, 0.29), true, without_lift()).run(state, 0.001, false); }
void at_rest(benchmark::State& state) { Fleet(places(1, 0.3, 0.29), false, {}).run(state, 0.001, false); }
/// Arguments: physics step [us], clearance measured every tick or not.
void hundred_in_the_forest(benchmark::State& state) {
  PhysicsConfig config = without_lift();
  config.step_s = 1e-6 * static_cast<double>(state.range(0));
  Fleet(places(100, 3.0, 0.8), true, config).run(state, config.step_s, state.range(1) != 0);
}

BENCHMARK(above_the_forest);
BENCHMARK(among_the_trunks);
BENCHMARK(among_the_trunks_with_clearance);
BENCHMARK(in_gusts);
BENCHMARK(skimming);
BENCHMARK(at_rest);
BENCHMARK(hundred_in_the_forest)->ArgNames({"step_us", "clearance"})->ArgsProduct({{1000, 4000}, {0, 1}});

}  // namespace
}  // namespace swiftlet::sim
