// SPDX-License-Identifier: BSD-3-Clause
// Physics of vehicles without control: one step of one vehicle in each situation, and a fleet of a hundred.
// "items" are vehicle-steps; "real_time" is simulated over wall time.
#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "sim/physics/physics_world.hpp"
#include "tests/support/test_scene.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kTick_s = 0.004;

Airframe quad() {
  Airframe airframe;
  const double side = airframe.arm_length_m / std::numbers::sqrt2;
  airframe.rotors = {{{side, -side, 0.05}, "ccw"},
                     {{-side, side, 0.05}, "ccw"},
                     {{side, side, 0.05}, "cw"},
                     {{-side, -side, 0.05}, "cw"}};
  return airframe;
}

/// Ground and trunks on a 4 m grid, each a prism of 2 x 32 triangles: about 25 000 triangles.
std::shared_ptr<const StaticScene> trunks() {
  TestScene builder;
  builder.add_wall({-60, -60, 0}, {60, -60, 0}, {60, 60, 0}, {-60, 60, 0}, SurfaceClass::kGround);
  for (int i = -10; i < 10; ++i) {
    for (int j = -10; j < 10; ++j) {
      for (int k = 0; k < 32; ++k) {
        const auto corner = [&](int n, float z) {
          const double angle = 2 * std::numbers::pi * n / 32;
          return Eigen::Vector3f(static_cast<float>(4 * i + 2 + 0.15 * std::cos(angle)),
                                 static_cast<float>(4 * j + 2 + 0.15 * std::sin(angle)), z);
        };
        builder.add_wall(corner(k, 0), corner(k + 1, 0), corner(k + 1, 10), corner(k, 10), SurfaceClass::kTrunk);
      }
    }
  }
  return std::make_shared<StaticScene>(builder.scene());
}

struct Fleet {
  Fleet(std::vector<Vector3> places, bool flying, const PhysicsConfig& config, const WindConfig& wind = {}) {
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
    world = std::make_unique<PhysicsWorld>(config, wind, std::move(vehicles), trunks(), 1);
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

std::vector<Vector3> grid(int count, double spacing_m, double height_m) {
  std::vector<Vector3> places;
  const int side = static_cast<int>(std::ceil(std::sqrt(count)));
  for (int i = 0; i < count; ++i) {
    places.emplace_back(spacing_m * (i % side) - 20.0, spacing_m * (i / side) - 20.0, height_m);
  }
  return places;
}

void clear(benchmark::State& state) { Fleet({{0, 0, 20}}, true, {}).run(state, 0.001, false); }
void clear_with_clearance(benchmark::State& state) { Fleet({{0, 0, 5}}, true, {}).run(state, 0.001, true); }
void clear_in_gusts(benchmark::State& state) {
  WindConfig wind;
  wind.gusts = true;
  wind.wind_at_6m_mps = 0.1;
  Fleet({{0, 0, 20}}, true, {}, wind).run(state, 0.001, false);
}
/// Hovering half a metre over the ground: ground effect by a ray for each rotor.
void low(benchmark::State& state) {
  PhysicsConfig config;
  config.ground_effect_coefficient = 1e-9;  // the work without the lift, to stay there
  Fleet({{0, 0, 0.75}}, true, config).run(state, 0.001, true);
}
/// Almost touching: narrow phase in every step.
void skimming(benchmark::State& state) {
  PhysicsConfig config;
  config.ground_effect_coefficient = 1e-9;
  Fleet({{0, 0, 0.23}}, true, config).run(state, 0.001, true);
}
void at_rest(benchmark::State& state) { Fleet({{0, 0, 0.2}}, false, {}).run(state, 0.001, true); }
void hundred_at_1khz(benchmark::State& state) { Fleet(grid(100, 4.0, 6.0), true, {}).run(state, 0.001, true); }
void hundred_at_250hz(benchmark::State& state) {
  PhysicsConfig config;
  config.step_s = 0.004;
  Fleet(grid(100, 4.0, 6.0), true, config).run(state, 0.004, true);
}

BENCHMARK(clear);
BENCHMARK(clear_with_clearance);
BENCHMARK(clear_in_gusts);
BENCHMARK(low);
BENCHMARK(skimming);
BENCHMARK(at_rest);
BENCHMARK(hundred_at_1khz);
BENCHMARK(hundred_at_250hz);

}  // namespace
}  // namespace swiftlet::sim
