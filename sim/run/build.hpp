// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/agent.hpp"
#include "swiftlet/sim/metrics/metric.hpp"
#include "swiftlet/sim/physics/physics_world.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

/// From a scenario to the parts of a simulation.
namespace swiftlet::sim {

std::vector<std::string> vehicle_names(const Scenario& scenario);

/// What stays the same during a run. It points into the scenario and the world.
RunInfo make_run_info(const Scenario& scenario, const World& world);

/// True states at the start. Throws InputError when a vehicle starts inside another one or above nothing although
/// `above_ground` is set. The same when the static world leaves no room for it at its start or at a destination.
std::vector<PhysicsVehicle> make_physics_vehicles(const Scenario& scenario, const StaticScene& world);

/// By vehicle, in the order of the scenario, which names all of them (with_truth_sensors).
std::vector<std::vector<std::unique_ptr<Sensor>>> make_sensors(
    const Scenario& scenario, const World& world, const std::vector<std::shared_ptr<const VehicleShape>>& shapes);

/// Which vehicles detect and track others, by VehicleId.
std::vector<Perception> perception_of(const Scenario& scenario);

std::vector<std::unique_ptr<Agent>> make_agents(const Scenario& scenario, const std::vector<PhysicsVehicle>& vehicles,
                                                const Scene& world);

}  // namespace swiftlet::sim
