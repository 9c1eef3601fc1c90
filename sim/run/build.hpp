// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/sim/metrics/metric.hpp"
#include "swiftlet/sim/physics/physics_world.hpp"
#include "swiftlet/sim/run/simulation.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

/// Construction of the parts of a simulation from a scenario.
namespace swiftlet::sim {

std::vector<std::string> vehicle_names(const Scenario& scenario);

/// Constant data of a run. References the scenario and the world.
RunInfo make_run_info(const Scenario& scenario, const World& world);

/// True states at the start. Throws InputError when a vehicle starts inside another one, without ground although
/// `above_ground` is set, or when it collides with the static world at its start or a destination.
std::vector<PhysicsVehicle> make_physics_vehicles(const Scenario& scenario, const StaticScene& world);

/// Indexed by vehicle, in the order of the scenario, which must name all sensors (with_truth_sensors).
std::vector<std::vector<std::unique_ptr<Sensor>>> make_sensors(
    const Scenario& scenario, const World& world, const std::vector<std::shared_ptr<const VehicleShape>>& shapes);

/// Perception abilities of each vehicle, indexed by VehicleId.
std::vector<Perception> perception_of(const Scenario& scenario);

std::vector<std::unique_ptr<Agent>> make_agents(const Scenario& scenario, const std::vector<PhysicsVehicle>& vehicles,
                                                const Scene& world);

}  // namespace swiftlet::sim
