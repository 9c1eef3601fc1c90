// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "swiftlet/core/action.hpp"
#include "swiftlet/sim/scenario/scenario.hpp"

/// Vehicles that fly what Python writes into an array, without a call into Python: for learning environments.
namespace swiftlet::python {

/// A row a vehicle: what it means is told by the module that reads it.
using Commands = std::vector<std::array<double, kMaxRotors>>;

/// The guidance `commanded` and the agent `rotors`, which only this module has.
void add_commanded_modules();

/// Numbers that a row of these vehicles needs: four for a goal, or one for each rotor, whichever vehicle needs most.
int num_commands(const sim::Scenario& scenario);

/// Connects those modules of the scenario with the rows, which are zero, or NaN where nothing else means nothing yet.
void connect_commands(sim::Scenario& scenario, const std::shared_ptr<Commands>& commands);

}  // namespace swiftlet::python
