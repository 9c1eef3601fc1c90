// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/physics/physics_world.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "sim/physics/air_effects.hpp"
#include "sim/physics/contacts.hpp"
#include "sim/physics/multirotor_model.hpp"
#include "sim/physics/near_pairs.hpp"
#include "sim/physics/wind.hpp"
#include "sim/physics/world_vehicle.hpp"
#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/base/finite.hpp"
#include "swiftlet/sim/parallel/crew.hpp"
#include "swiftlet/sim/parallel/first_exception.hpp"

namespace swiftlet::sim {
namespace {

using RotorCommands = std::span<const std::array<double, kMaxRotors>>;

/// [ns] Longest interval between predictions of possible contacts. With larger values, more vehicles are checked for
/// contacts in every step.
constexpr TimeNs kPlanSpan = 8'000'000;
/// [ns] Interval between updates of downwash and ground effect. Larger values save time and delay both effects.
constexpr TimeNs kAirSpan = 8'000'000;
/// [m] Margin around the collision shape of a vehicle within which contacts are computed. Must exceed the distance at
/// which Bullet makes contact points (0.02 m by default). Larger values only cost time.
constexpr double kContactMargin_m = 0.03;
/// [rad/s] Rotor speed above which a contact of the propeller is a crash.
constexpr double kTurningRotor_radps = 10.0;
/// [m/s], [rad/s] Speeds below which a vehicle in contact counts as at rest. After kRestTime_s at rest, the vehicle is
/// frozen until the forces on it change. Larger values freeze vehicles that still slide or tip over.
constexpr double kRestSpeed_mps = 0.01;
constexpr double kRestRate_radps = 0.03;
/// [s] Time at rest until a vehicle is frozen. Smaller values freeze a vehicle that is about to tip over.
constexpr double kRestTime_s = 0.25;
/// [m/s^2], [rad/s^2] A frozen vehicle is released when its acceleration without contact forces has changed by more
/// than this since freezing. Larger values need a larger change of thrust or wind for a takeoff.
constexpr double kReleaseLinear_mps2 = 0.1;
constexpr double kReleaseAngular_radps2 = 0.5;
/// [-] Bound of the acceleration of a vehicle, in multiples of full thrust plus gravity; the excess covers drag in any
/// wind in which the vehicle can fly. Smaller values might miss a contact, larger ones predict contacts too early.
constexpr double kAccelerationMargin = 2.0;
/// [rad] Angle below which a rotation is linearized, because its axis is undefined.
constexpr double kSmallAngle_rad = 1e-12;
/// Command that stops a rotor; any negative value does.
constexpr double kStopRotor = -1.0;

/// [vehicles] Number from which vehicles are distributed over threads, and number per work item of a thread. With
/// smaller values, synchronization takes more time than the threads save.
constexpr int kManyVehicles = 16;
constexpr int kVehiclesAtATime = 4;
/// [-] Near pairs and contacts per vehicle, and contacts in addition, for which memory is reserved. Further ones
/// allocate during the flight.
constexpr std::size_t kPairsPerVehicle = 16, kTouchesPerVehicle = 8, kExtraTouches = 64;

/// Velocity of the air at a point [m/s] due to the downwash of all other vehicles.
Vector3 downwash_at(VehicleId id, const Vector3& p_world, std::span<const Wake> wakes) {
  Vector3 sum = Vector3::Zero();
  for (VehicleId source = 0; source < static_cast<VehicleId>(wakes.size()); ++source) {
    if (source != id && wakes[source].may_reach(p_world)) sum += wakes[source].velocity_world_mps(p_world);
  }
  return sum;
}

/// Advances the gusts at a vehicle by one step and sets the wind that results.
void update_wind(WorldVehicle& vehicle, const VehicleState& state, const WindConfig& wind, std::uint32_t step_number,
                 double step_s) {
  const Vector3 airspeed_world_mps = state.v_world_mps - vehicle.air.wind_world_mps;
  vehicle.air.wind_world_mps =
      wind.mean_mps + vehicle.gusts->advance(step_number, step_s, state.p_world_m.z(), airspeed_world_mps.norm());
}

/// Checks pose and velocities. Rotor speeds need no check: commands are clamped, and NaN stops a rotor.
bool is_finite(const VehicleState& state) {
  return swiftlet::is_finite(state.p_world_m) && swiftlet::is_finite(state.q_world_body) &&
         swiftlet::is_finite(state.v_world_mps) && swiftlet::is_finite(state.omega_body_radps);
}

Eigen::Quaterniond rotation_by(const Vector3& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (angle < kSmallAngle_rad)
    return Eigen::Quaterniond(1.0, 0.5 * rotation_vector.x(), 0.5 * rotation_vector.y(), 0.5 * rotation_vector.z());
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, rotation_vector / angle));
}

bool rotors_turn(const VehicleState& state) {
  return *std::max_element(state.rotor_speed_radps.begin(), state.rotor_speed_radps.end()) > kTurningRotor_radps;
}

Crash crash_by(const Touch& touch, TimeNs t, const StaticScene* scene) {
  Crash crash{.t = t,
              .vehicle = touch.vehicle,
              .other_vehicle = touch.other,
              .p_world_m = touch.p_world_m,
              .speed_mps = touch.approach_mps};
  if (touch.other != kNoVehicle) {
    crash.surface_class = SurfaceClass::kVehicle;
    crash.instance = static_cast<std::uint16_t>(touch.other + 1);
  } else if (const auto surface = scene->nearest(touch.p_world_m, kSurfaceSlack_m)) {
    crash.surface_class = surface->surface_class;
    crash.instance = surface->instance;
  }
  return crash;
}

/// Sets the state of a vehicle after its contact impulses: the step is repeated from the pose at its beginning with the
/// velocities after the impulses.
void repeat_step(const ContactBody& body, double step_s, VehicleState& state) {
  state.v_world_mps = body.v_world_mps;
  state.p_world_m = body.p_world_m + step_s * body.v_world_mps;
  state.q_world_body = (rotation_by(step_s * body.omega_world_radps) * body.q_world_body).normalized();
  state.omega_body_radps = state.q_world_body.conjugate() * body.omega_world_radps;
}

bool is_still(const VehicleState& state) {
  return state.v_world_mps.norm() < kRestSpeed_mps && state.omega_body_radps.norm() < kRestRate_radps;
}

std::vector<double> circumscribed_radii_m(std::span<const PhysicsVehicle> vehicles) {
  std::vector<double> radii_m;
  for (const PhysicsVehicle& vehicle : vehicles) radii_m.push_back(vehicle.airframe.circumscribed_radius_m());
  return radii_m;
}

}  // namespace

struct PhysicsWorld::Impl {
  PhysicsConfig config;
  WindConfig wind;
  std::shared_ptr<const StaticScene> scene;
  TimeNs step = 0;
  TimeNs now = 0;
  TimeNs next_air = 0;
  std::vector<WorldVehicle> vehicles;
  std::vector<VehicleState> states;
  Contacts contacts;
  std::vector<Crash> crashes;

  // Working memory, kept to avoid allocations.
  std::vector<Vector3> positions;
  Neighborhood neighborhood;
  std::vector<Wake> wakes;
  std::vector<VehicleId> near_vehicles;
  NearPairs near_pairs;
  std::vector<VehicleState> before;  // states of the near vehicles before this step
  std::vector<ContactBody> bodies;
  std::vector<Contacts::Pair> pairs;
  std::vector<Touch> touches;
  std::array<double, kMaxRotors> stopped{};  // command that stops all rotors

  Impl(const PhysicsConfig& physics, const WindConfig& wind_config, std::span<const PhysicsVehicle> fleet,
       std::shared_ptr<const StaticScene> static_scene, std::uint64_t seed)
      : config(physics),
        wind(wind_config),
        scene(std::move(static_scene)),
        step(from_seconds(physics.step_s)),
        contacts(fleet, physics),
        neighborhood(circumscribed_radii_m(fleet)),
        near_pairs(fleet.size()) {
    stopped.fill(kStopRotor);
    for (const PhysicsVehicle& vehicle : fleet) add(vehicle, seed);
    const std::size_t count = vehicles.size();
    crashes.reserve(count);
    positions.resize(count);
    wakes.resize(count);
    near_vehicles.reserve(count);
    before.resize(count);
    bodies.reserve(count);
    pairs.reserve(kPairsPerVehicle * count);
    touches.reserve(kExtraTouches + kTouchesPerVehicle * count);
    note_positions();
    neighborhood.update(states);
  }

  void add(const PhysicsVehicle& vehicle, std::uint64_t seed) {
    const Airframe& airframe = vehicle.airframe;
    const VehicleId id = static_cast<VehicleId>(vehicles.size());
    VehicleState state = vehicle.start;
    state.t = 0;
    state.q_world_body.normalize();
    if (vehicle.motors_on) {
      const double hover = std::clamp(airframe.hover_rotor_speed_radps(config.gravity_world_mps2.norm()),
                                      airframe.rotor_speed_min_radps, airframe.rotor_speed_max_radps);
      std::fill_n(state.rotor_speed_radps.begin(), airframe.num_rotors(), hover);
    }
    WorldVehicle entry(vehicle.name, MultirotorModel(airframe, config));
    entry.air.wind_world_mps = wind.mean_mps;
    if (wind.gusts) {
      entry.gusts.emplace(wind, seed, vehicle.name);
      update_wind(entry, state, wind, 0, config.step_s);
    }
    entry.circumscribed_m = airframe.circumscribed_radius_m();
    entry.contact_reach_m = contacts.reach_m(id) + kContactMargin_m;
    entry.acceleration_bound_mps2 =
        kAccelerationMargin * (airframe.max_thrust_N() / airframe.mass_kg + config.gravity_world_mps2.norm());
    vehicles.push_back(std::move(entry));
    states.push_back(state);
  }

  /// Calls act(vehicle) for all vehicles, in parallel from kManyVehicles on. `act` may modify only this vehicle.
  template <class Act>
  void for_each_vehicle(const Act& act) const {
    const int count = static_cast<int>(vehicles.size());
    parallel_for(count, count >= kManyVehicles ? kVehiclesAtATime : count, act);
  }

  void note_positions() {
    for (std::size_t i = 0; i < states.size(); ++i) positions[i] = states[i].p_world_m;
  }

  // ---- prediction of contacts, for several steps at once ----

  /// Finds the vehicles that may touch something within span_s, and updates downwash and ground effect when due.
  void plan(double span_s) {
    note_positions();
    const bool look_up_air = now >= next_air;
    if (look_up_air) next_air = now + kAirSpan;
    if (look_up_air && config.downwash) make_wakes();
    for_each_vehicle([&](VehicleId i) { look_ahead(i, span_s, look_up_air); });
    if (config.contacts) find_near_pairs();
    near_vehicles.clear();
    for (std::size_t i = 0; i < vehicles.size(); ++i) {
      if (vehicles[i].near) near_vehicles.push_back(static_cast<VehicleId>(i));
    }
  }

  /// Part of plan() for one vehicle: bounds its displacement and compares it with the distance to the nearest surface.
  void look_ahead(VehicleId id, double span_s, bool look_up_air) {
    WorldVehicle& vehicle = vehicles[id];
    const VehicleState& state = states[id];
    if (look_up_air && config.downwash) vehicle.air.downwash_world_mps = downwash_at(id, positions[id], wakes);
    vehicle.travel_m = state.v_world_mps.norm() * span_s + 0.5 * vehicle.acceleration_bound_mps2 * span_s * span_s;
    vehicle.near_world = config.contacts && scene && may_meet_surface(vehicle, state.p_world_m, config, *scene);
    vehicle.near = vehicle.near_world;
    if (vehicle.near_world && !vehicle.asleep) gather_triangles(id);
    if (look_up_air && config.ground_effect && scene) apply_ground_effect(vehicle, state, config, *scene);
  }

  void gather_triangles(VehicleId id) {
    const Vector3 half = Vector3::Constant(vehicles[id].contact_reach_m + vehicles[id].travel_m);
    contacts.gather_triangles(id, *scene, {positions[id] - half, positions[id] + half});
  }

  void make_wakes() {
    for (std::size_t i = 0; i < vehicles.size(); ++i) {
      const MultirotorModel& model = vehicles[i].model;
      wakes[i] = make_wake(model.airframe(), positions[i], states[i].q_world_body.toRotationMatrix(),
                           model.thrust_N(states[i]), PhysicsConfig::kAirDensity_kgpm3);
    }
  }

  void find_near_pairs() {
    near_pairs.find(positions, vehicles);
    for (const Contacts::Pair& pair : near_pairs.pairs()) {
      for (const VehicleId id : {pair.a, pair.b}) {
        vehicles[id].near = true;
        if (vehicles[id].asleep) release(id);
      }
    }
  }

  /// Ends the rest of a frozen vehicle.
  void release(VehicleId id) {
    WorldVehicle& vehicle = vehicles[id];
    vehicle.asleep = false;
    vehicle.still_s = 0.0;
    if (vehicle.near_world) gather_triangles(id);
  }

  // ---- one step ----

  const std::array<double, kMaxRotors>& command_of(VehicleId id, RotorCommands commands) const {
    return states[id].crashed && config.stop_motors_on_crash ? stopped : commands[id];
  }

  /// Integrates one step without contacts. A frozen vehicle stays in place; only its motors and gusts advance, and it
  /// is released when its acceleration without contact forces changes.
  void fly(VehicleId id, TimeNs t, RotorCommands commands) {
    WorldVehicle& vehicle = vehicles[id];
    VehicleState& state = states[id];
    if (vehicle.gusts) update_wind(vehicle, state, wind, static_cast<std::uint32_t>(t / step), config.step_s);
    if (vehicle.asleep) {
      vehicle.model.step_motors(state, command_of(id, commands));
      const auto free = vehicle.model.acceleration(state, vehicle.air);
      const auto& at_freezing = vehicle.free_acceleration;
      if ((free.linear_world_mps2 - at_freezing.linear_world_mps2).norm() > kReleaseLinear_mps2 ||
          (free.angular_body_radps2 - at_freezing.angular_body_radps2).norm() > kReleaseAngular_radps2) {
        release(id);
      }
    } else {
      vehicle.model.step(state, command_of(id, commands), vehicle.air);
    }
    state.t = t;
    ENSURE(is_finite(state), vehicle.name, to_seconds(t), state.p_world_m, state.v_world_mps, state.omega_body_radps);
  }

  /// Integrates all steps of the prediction for a vehicle that cannot touch anything, independently of all others.
  void fly_clear(VehicleId id, int num_steps, RotorCommands commands, StateHistory& history) {
    vehicles[id].touching = false;
    vehicles[id].still_s = 0.0;
    for (int k = 1; k <= num_steps; ++k) {
      fly(id, now + k * step, commands);
      history.push(id, states[id]);
    }
  }

  /// Integrates one step of all vehicles that may touch something: flight without contacts, then contact impulses.
  void fly_near(TimeNs t, RotorCommands commands, StateHistory& history) {
    for (const VehicleId id : near_vehicles) {
      before[id] = states[id];
      fly(id, t, commands);
    }
    touches.clear();
    collect_bodies();
    if (!bodies.empty()) {
      contacts.resolve(bodies, pairs, touches);
      for (const ContactBody& body : bodies) take_over(body);
      for (const Touch& touch : touches) check_crash(touch, t);
    }
    for (const VehicleId id : near_vehicles) {
      fall_asleep(id);
      history.push(id, states[id]);
    }
  }

  /// Selects the vehicles, and pairs of vehicles, that are close enough for a contact in this step.
  void collect_bodies() {
    bodies.clear();
    pairs.clear();
    for (const Contacts::Pair& pair : near_pairs.pairs()) {
      const double reach_m = vehicles[pair.a].contact_reach_m + vehicles[pair.b].contact_reach_m;
      const double displacement_m =
          (states[pair.a].v_world_mps.norm() + states[pair.b].v_world_mps.norm()) * config.step_s;
      if ((before[pair.a].p_world_m - before[pair.b].p_world_m).norm() < reach_m + displacement_m)
        pairs.push_back(pair);
    }
    for (const VehicleId id : near_vehicles) {
      WorldVehicle& vehicle = vehicles[id];
      if (vehicle.asleep) continue;
      vehicle.touching = false;
      const bool at_surface =
          vehicle.near_world && vehicle.surface.at_least_m(before[id].p_world_m) < vehicle.contact_reach_m;
      const bool at_vehicle = std::any_of(pairs.begin(), pairs.end(),
                                          [id](const Contacts::Pair& pair) { return pair.a == id || pair.b == id; });
      if (!at_surface && !at_vehicle) continue;
      const VehicleState& state = states[id];
      bodies.push_back({id, at_surface, before[id].p_world_m, before[id].q_world_body, state.v_world_mps,
                        state.q_world_body * state.omega_body_radps, false});
    }
  }

  void take_over(const ContactBody& body) {
    if (!body.touched) return;
    VehicleState& state = states[body.vehicle];
    vehicles[body.vehicle].touching = true;
    repeat_step(body, config.step_s, state);
    ENSURE(is_finite(state), vehicles[body.vehicle].name, to_seconds(state.t), state.p_world_m, state.v_world_mps,
           state.omega_body_radps);
  }

  /// Records a crash of the vehicle, its first one only, if the contact is faster than crash_speed_mps or a turning
  /// propeller is hit.
  void check_crash(const Touch& touch, TimeNs t) {
    VehicleState& state = states[touch.vehicle];
    if (state.crashed) return;
    const bool propeller_hit =
        config.propeller_contact_is_crash &&
        ((touch.propeller && rotors_turn(state)) || (touch.other_propeller && rotors_turn(states[touch.other])));
    if (touch.approach_mps <= config.crash_speed_mps && !propeller_hit) return;
    state.crashed = true;
    crashes.push_back(crash_by(touch, t, scene.get()));
  }

  /// Freezes a vehicle that has been at rest in contact with a surface for kRestTime_s.
  void fall_asleep(VehicleId id) {
    WorldVehicle& vehicle = vehicles[id];
    VehicleState& state = states[id];
    if (vehicle.asleep) return;
    vehicle.still_s = vehicle.touching && is_still(state) ? vehicle.still_s + config.step_s : 0.0;
    if (vehicle.still_s < kRestTime_s || near_pairs.contain(id)) return;
    vehicle.asleep = true;
    state.v_world_mps.setZero();
    state.omega_body_radps.setZero();
    vehicle.free_acceleration = vehicle.model.acceleration(state, vehicle.air);
  }

  void advance(TimeNs t_end, RotorCommands commands, StateHistory& history) {
    if (commands.size() < vehicles.size())
      throw std::invalid_argument("PhysicsWorld::advance: one command per vehicle expected");
    crashes.clear();
    while (now + step <= t_end) {
      const int num_steps = static_cast<int>(std::min((t_end - now) / step, std::max<TimeNs>(kPlanSpan / step, 1)));
      plan(num_steps * config.step_s);
      for_each_vehicle([&](VehicleId i) {
        if (!vehicles[i].near) fly_clear(i, num_steps, commands, history);
      });
      for (int k = 1; k <= num_steps && !near_vehicles.empty(); ++k) fly_near(now + k * step, commands, history);
      now += num_steps * step;
    }
    note_positions();
    neighborhood.update(states);
    std::sort(crashes.begin(), crashes.end(),
              [](const Crash& a, const Crash& b) { return a.t != b.t ? a.t < b.t : a.vehicle < b.vehicle; });
  }

  Clearance clearance(VehicleId id, double max_distance_m) {
    Clearance clearance;
    WorldVehicle& vehicle = vehicles[id];
    const Vector3& p = positions[id];

    clearance.surface_m = scene ? surface_clearance_m(vehicle, p, max_distance_m, *scene) : max_distance_m;

    // Squared distances are compared first, because most vehicles are farther than the nearest one found so far.
    clearance.vehicle_m = std::numeric_limits<double>::infinity();
    for (const VehicleId other : neighborhood.candidates(id)) {
      const double radii_m = vehicle.circumscribed_m + vehicles[other].circumscribed_m;
      const double distance_sq = (positions[other] - p).squaredNorm();
      const double limit_m = std::max(clearance.vehicle_m + radii_m, 0.0);
      if (distance_sq >= limit_m * limit_m) continue;
      clearance.vehicle_m = std::sqrt(distance_sq) - radii_m;
      clearance.nearest_vehicle = other;
    }
    return clearance;
  }
};

PhysicsWorld::PhysicsWorld(const PhysicsConfig& config, const WindConfig& wind, std::vector<PhysicsVehicle> vehicles,
                           std::shared_ptr<const StaticScene> scene, std::uint64_t seed) {
  if (from_seconds(config.step_s) <= 0) throw std::invalid_argument("physics.step_s: expected at least one nanosecond");
  for (const PhysicsVehicle& vehicle : vehicles) {
    if (vehicle.airframe.num_rotors() > kMaxRotors) {
      throw std::invalid_argument("vehicle '" + vehicle.name + "': expected at most " + std::to_string(kMaxRotors) +
                                  " rotors");
    }
  }
  impl_ = std::make_unique<Impl>(config, wind, vehicles, std::move(scene), seed);
}
PhysicsWorld::~PhysicsWorld() = default;

void PhysicsWorld::advance(TimeNs t_end, RotorCommands rotor_commands, StateHistory& history) {
  impl_->advance(t_end, rotor_commands, history);
}
const VehicleState& PhysicsWorld::state(VehicleId vehicle) const { return impl_->states[vehicle]; }
std::span<const VehicleState> PhysicsWorld::states() const { return impl_->states; }
std::span<const Crash> PhysicsWorld::crashes() const { return impl_->crashes; }
bool PhysicsWorld::in_contact(VehicleId vehicle) const { return impl_->vehicles[vehicle].touching; }
Clearance PhysicsWorld::clearance(VehicleId vehicle, double max_distance_m) const {
  return impl_->clearance(vehicle, max_distance_m);
}
Vector3 PhysicsWorld::wind_world_mps(VehicleId vehicle) const { return impl_->vehicles[vehicle].air.wind_world_mps; }

}  // namespace swiftlet::sim
