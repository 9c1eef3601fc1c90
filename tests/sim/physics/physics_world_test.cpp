// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <atomic>
#include <limits>

#include "swiftlet/core/math/random.hpp"
#include "tests/sim/physics/flight.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SWIFTLET_COUNTS_ALLOCATIONS 0
#else
#define SWIFTLET_COUNTS_ALLOCATIONS 1
// Counts all allocations of this program: the C++ operators, Bullet's and Embree's allocators.
namespace {
std::atomic<long> num_allocations{0};
}
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void* malloc(std::size_t size) {
  num_allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  num_allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_memalign(alignment, size);
}
}
#endif

namespace swiftlet::sim {
namespace {

/// Pillars on a 4 m grid over a floor.
std::shared_ptr<const StaticScene> pillars() {
  TestScene builder;
  builder.add_wall({-40, -40, 0}, {40, -40, 0}, {40, 40, 0}, {-40, 40, 0}, SurfaceClass::kGround);
  std::uint16_t instance = 0;
  for (int i = -6; i <= 6; ++i) {
    for (int j = -6; j <= 6; ++j) {
      const float x = 4.0F * static_cast<float>(i) + 2.0F;
      const float y = 4.0F * static_cast<float>(j) + 2.0F;
      builder.add_box({x - 0.2F, y - 0.2F, 0}, {x + 0.2F, y + 0.2F, 6}, SurfaceClass::kPillar, ++instance);
    }
  }
  return std::make_shared<StaticScene>(builder.scene());
}

/// A swarm flown badly: some crash into pillars, the floor and each other.
std::vector<PhysicsVehicle> swarm(int count, const Random& random) {
  std::vector<PhysicsVehicle> vehicles;
  for (int i = 0; i < count; ++i) {
    const double x = 4.0 * (i % 5) - 8.0;
    const double y = 4.0 * (i / 5) - 8.0;
    PhysicsVehicle vehicle = vehicle_at({x, y, 1.5}, test_quad(), "uav" + std::to_string(i));
    const auto v = random.normal3(0, i);
    vehicle.start.v_world_mps = {2 * v[0], 2 * v[1], 0.3 * v[2]};
    vehicle.motors_on = true;
    vehicles.push_back(vehicle);
  }
  return vehicles;
}

std::vector<VehicleState> fly_swarm(std::vector<Crash>& crashes) {
  const Random random(11, "test.swarm");
  WindConfig wind;
  wind.gusts = true;
  wind.mean_mps = {2, 0, 0};
  Flight flight(PhysicsConfig{}, swarm(20, random), pillars(), wind);
  for (std::uint32_t n = 0; n < 40; ++n) {
    for (int i = 0; i < 20; ++i) {
      for (int k = 0; k < 4; ++k) flight.commands[i][k] = 0.45 + 0.02 * random.normal(n + 1, 8 * i + k);
    }
    flight.run(0.1);
  }
  crashes = flight.crashes;
  return {flight.world.states().begin(), flight.world.states().end()};
}

TEST(Determinism, TwoRunsGiveTheSameBits) {
  std::vector<Crash> crashes_a;
  std::vector<Crash> crashes_b;
  const std::vector<VehicleState> a = fly_swarm(crashes_a);
  const std::vector<VehicleState> b = fly_swarm(crashes_b);
  EXPECT_GT(crashes_a.size(), 5U);
  ASSERT_EQ(crashes_a.size(), crashes_b.size());
  for (std::size_t i = 0; i < crashes_a.size(); ++i) {
    EXPECT_EQ(crashes_a[i].t, crashes_b[i].t);
    EXPECT_EQ(crashes_a[i].vehicle, crashes_b[i].vehicle);
    EXPECT_EQ(crashes_a[i].p_world_m, crashes_b[i].p_world_m);
    if (i > 0) {
      EXPECT_LE(crashes_a[i - 1].t, crashes_a[i].t);
    }
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].p_world_m, b[i].p_world_m);
    EXPECT_EQ(a[i].q_world_body.coeffs(), b[i].q_world_body.coeffs());
    EXPECT_EQ(a[i].v_world_mps, b[i].v_world_mps);
    EXPECT_EQ(a[i].omega_body_radps, b[i].omega_body_radps);
    EXPECT_EQ(a[i].rotor_speed_radps, b[i].rotor_speed_radps);
    EXPECT_TRUE(a[i].p_world_m.allFinite());
    EXPECT_GT(a[i].p_world_m.z(), -0.05) << "fell through the floor";
  }
}

TEST(History, HasEveryPhysicsStep) {
  PhysicsConfig config = bare_physics();
  PhysicsVehicle vehicle = vehicle_at({0, 0, 100});
  Flight flight(config, {vehicle});
  flight.run(0.02, 0.02);
  for (int ms = 1; ms <= 20; ++ms) {
    const VehicleState state = flight.history.at(0, from_seconds(0.001 * ms));
    EXPECT_EQ(state.t, from_seconds(0.001 * ms));
    EXPECT_NEAR(state.p_world_m.z(), 100 - 0.5 * kGravity * 1e-6 * ms * ms, 1e-12);
  }
}

TEST(History, WholeStepsOnly) {
  Flight flight(bare_physics(), {vehicle_at({0, 0, 100})});
  flight.world.advance(2'500'000, flight.commands, flight.history);
  EXPECT_EQ(flight.state().t, 2'000'000);
  flight.world.advance(3'000'000, flight.commands, flight.history);
  EXPECT_EQ(flight.state().t, 3'000'000);
}

TEST(Clearance, IsExactWhereverTheVehicleGoes) {
  TestScene builder;
  builder.add_box({4, -1, 0}, {6, 1, 8}, SurfaceClass::kPillar, 3);
  PhysicsConfig config = bare_physics();
  config.contacts = true;
  config.gravity_world_mps2 = {0, 0, -0.4};
  PhysicsVehicle vehicle = vehicle_at({-20, 2.4, 5});
  vehicle.start.v_world_mps = {6, 0, 1};
  Flight flight(config, {vehicle}, std::make_shared<StaticScene>(builder.scene()));
  const double radius = vehicle.airframe.circumscribed_radius_m();
  double least = 1e9;
  for (int k = 0; k < 1500; ++k) {
    flight.run(0.004);
    const Vector3 p = flight.state().p_world_m;
    const Vector3 outside = (Vector3(4, -1, 0) - p).cwiseMax(p - Vector3(6, 1, 8)).cwiseMax(0.0);
    const Clearance clearance = flight.world.clearance(0, 10.0);
    EXPECT_NEAR(clearance.surface_m, std::min(outside.norm() - radius, 10.0), 1e-5) << k;
    EXPECT_EQ(clearance.vehicle_m, std::numeric_limits<double>::infinity());
    EXPECT_EQ(clearance.nearest_vehicle, kNoVehicle);
    least = std::min(least, clearance.surface_m);
  }
  EXPECT_NEAR(least, 1.4 - radius, 1e-5);  // the vehicle passed close by
}

TEST(Clearance, BetweenVehiclesLeavesOutBothRadii) {
  PhysicsVehicle a = vehicle_at({0, 0, 10}, test_quad(), "a");
  PhysicsVehicle b = vehicle_at({0, 3, 14}, test_quad(), "b");
  PhysicsVehicle c = vehicle_at({0, 0, 16}, test_quad(), "c");
  b.airframe.propeller_radius_m = 0.2;
  Flight flight(bare_physics(), {a, b, c});
  const double ra = a.airframe.circumscribed_radius_m();
  const double rb = b.airframe.circumscribed_radius_m();
  EXPECT_NEAR(flight.world.clearance(0, 20.0).vehicle_m, 5.0 - ra - rb, 1e-12);
  EXPECT_EQ(flight.world.clearance(0, 20.0).nearest_vehicle, 1);
  EXPECT_EQ(flight.world.clearance(2, 20.0).nearest_vehicle, 1);
  EXPECT_EQ(flight.world.clearance(0, 20.0).surface_m, 20.0);  // empty space
}

TEST(Memory, AdvanceAllocatesNothingOnceWarm) {
#if SWIFTLET_COUNTS_ALLOCATIONS
  // Flying clear, flying low, standing, and landing with a bounce, in gusts.
  PhysicsConfig config;
  config.crash_speed_mps = 5.0;
  const Airframe airframe = test_quad();
  std::vector<PhysicsVehicle> vehicles = {
      vehicle_at({0, 0, 30}, airframe, "high"), vehicle_at({0, 0, 0.45}, airframe, "low"),
      vehicle_at({-8, 0, airframe.leg_height_m}, airframe, "standing"), vehicle_at({8, 0, 1.2}, airframe, "landing")};
  vehicles[0].motors_on = vehicles[1].motors_on = true;
  WindConfig wind;
  wind.gusts = true;
  wind.wind_at_6m_mps = 1.0;
  Flight flight(config, vehicles, pillars(), wind);
  const double hover = command_for(airframe, airframe.hover_rotor_speed_radps());
  flight.command(0, hover);
  flight.command(1, hover);
  flight.run(0.05);

  long most = 0;
  bool touched = false;
  for (int k = 0; k < 250; ++k) {
    flight.now += from_seconds(0.004);
    const long before = num_allocations.load();
    flight.world.advance(flight.now, flight.commands, flight.history);
    for (int i = 0; i < 4; ++i) flight.world.clearance(i, 20.0);
    most = std::max(most, num_allocations.load() - before);
    touched |= flight.world.in_contact(3);
  }
  EXPECT_TRUE(touched);
  EXPECT_EQ(most, 0);
  // The counter counts.
  const long before = num_allocations.load();
  auto* probe = new std::vector<double>(100);
  EXPECT_GT(num_allocations.load(), before);
  delete probe;
#else
  GTEST_SKIP() << "sanitizers bring their own allocator";
#endif
}

TEST(Arguments, RefuseExcessRotorsAndMissingCommands) {
  Airframe airframe = test_quad();
  airframe.rotors.resize(9);
  EXPECT_THROW(Flight(bare_physics(), {vehicle_at({0, 0, 0}, airframe)}), std::invalid_argument);
  airframe.rotors.resize(8);
  EXPECT_NO_THROW(Flight(bare_physics(), {vehicle_at({0, 0, 0}, airframe)}));
  Flight flight(bare_physics(), {vehicle_at({0, 0, 0})});
  flight.commands.clear();
  EXPECT_THROW(flight.run(0.1), std::invalid_argument);
  PhysicsConfig endless = bare_physics();
  endless.step_s = 1e-10;
  EXPECT_THROW(Flight(endless, {vehicle_at({0, 0, 0})}), std::invalid_argument) << "a step of no duration";
}

TEST(Start, RunningMotorsHoldTheVehicle) {
  PhysicsVehicle on = vehicle_at({0, 0, 5}), off = vehicle_at({0, 0, 5});
  on.motors_on = true;
  on.start.q_world_body.coeffs() *= 2.0;
  Flight flying(PhysicsConfig{}, {on}), standing(PhysicsConfig{}, {off});
  for (std::size_t i = 0; i < kMaxRotors; ++i) {
    const double hover_radps = i < 4 ? test_quad().hover_rotor_speed_radps() : 0.0;
    EXPECT_DOUBLE_EQ(flying.state().rotor_speed_radps[i], hover_radps);
    EXPECT_EQ(standing.state().rotor_speed_radps[i], 0.0);
  }
  EXPECT_NEAR(flying.state().q_world_body.norm(), 1.0, 1e-12);
  Airframe heavy = test_quad();
  heavy.mass_kg = 100.0;
  PhysicsVehicle too_heavy = vehicle_at({0, 0, 5}, heavy);
  too_heavy.motors_on = true;
  EXPECT_DOUBLE_EQ(Flight(PhysicsConfig{}, {too_heavy}).state().rotor_speed_radps[0], heavy.rotor_speed_max_radps);
}

// Every pair, and every surface, at any distance.
TEST(Clearance, IsThatOfAllVehiclePairs) {
  const Random random(4, "clearance");
  std::vector<PhysicsVehicle> vehicles;
  for (std::uint32_t i = 0; i < 24; ++i) {
    Airframe airframe = test_quad();
    airframe.propeller_radius_m = 0.05 + 0.2 * random.uniform(i, 0);
    vehicles.push_back(
        vehicle_at({12.0 * random.uniform(i, 1), 12.0 * random.uniform(i, 2), 20.0 + 12.0 * random.uniform(i, 3)},
                   airframe, "uav" + std::to_string(i)));
    const auto n = random.normal3(i, 4);
    vehicles.back().start.v_world_mps = 3.0 * Vector3(n[0], n[1], 0.3 * n[2]);
  }
  PhysicsConfig config = bare_physics();
  config.gravity_world_mps2 = {0, 0, -1.0};
  Flight flight(config, vehicles, flat_ground());
  for (int k = 0; k < 60; ++k) {
    flight.run(0.05);
    for (VehicleId i = 0; i < 24; ++i) {
      const double radius_m = vehicles[static_cast<std::size_t>(i)].airframe.circumscribed_radius_m();
      double nearest_m = std::numeric_limits<double>::infinity();
      VehicleId nearest = kNoVehicle;
      for (VehicleId j = 0; j < 24; ++j) {
        const double gap_m = (flight.state(i).p_world_m - flight.state(j).p_world_m).norm() - radius_m -
                             vehicles[static_cast<std::size_t>(j)].airframe.circumscribed_radius_m();
        if (j != i && gap_m < nearest_m) nearest_m = gap_m, nearest = j;
      }
      const double most_m = 5.0 + k % 7 * 4.0;
      const Clearance clearance = flight.world.clearance(i, most_m);
      EXPECT_NEAR(clearance.vehicle_m, nearest_m, 1e-9);
      EXPECT_EQ(clearance.nearest_vehicle, nearest);
      EXPECT_NEAR(clearance.surface_m, std::min(flight.state(i).p_world_m.z() - radius_m, most_m), 1e-4) << k;
    }
  }
}

}  // namespace
}  // namespace swiftlet::sim
