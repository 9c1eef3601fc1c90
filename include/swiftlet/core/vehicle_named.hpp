// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

#include "swiftlet/core/agent.hpp"

namespace swiftlet {

/// The other vehicle of that name; without a name the first other one, or kNoVehicle when there is none. `key` is that
/// of the setting. Throws std::invalid_argument.
inline VehicleId vehicle_named(const std::string& name, const AgentSetup& setup, const char* key) {
  if (name.empty()) return setup.num_vehicles < 2 ? kNoVehicle : VehicleId{setup.self == 0 ? 1 : 0};
  std::string others;
  for (std::size_t i = 0; i < setup.vehicle_names.size(); ++i) {
    if (static_cast<VehicleId>(i) == setup.self) continue;
    if (setup.vehicle_names[i] == name) return static_cast<VehicleId>(i);
    others += (others.empty() ? "" : ", ") + setup.vehicle_names[i];
  }
  throw std::invalid_argument(std::string(key) + ": expected the name of another vehicle (" +
                              (others.empty() ? "there is none" : others) + "), found \"" + name + "\"");
}

}  // namespace swiftlet
