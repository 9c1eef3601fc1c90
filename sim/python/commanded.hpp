// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

/// Vehicles that follow commands in an array written by Python, without calls into Python: for learning environments.
namespace swiftlet::python {

/// One row per vehicle; its meaning depends on the module that reads it.
using Commands = std::vector<std::array<double, kMaxRotors>>;

/// Registers the guidance `commanded` and the agent `rotors`, which only this module provides.
void add_commanded_modules();

/// Length of a row for this team: four for a goal, or one per rotor, the maximum over all vehicles.
int num_commands(const sim::Scenario& scenario);

/// Connects those modules of the scenario with the rows. Initial values are zero, or NaN for position commands, which
/// mean "no command".
void connect_commands(sim::Scenario& scenario, const std::shared_ptr<Commands>& commands);

}  // namespace swiftlet::python
