// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "swiftlet/core/base/agent.hpp"

namespace swiftlet {

/// Id of the other vehicle with this name; an empty name selects the first other vehicle, or kNoVehicle when there is
/// none. `key` is the key of the setting. Throws std::invalid_argument.
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

/// Ids of the vehicles in `others`, or, when it is empty, of `other`. `key` is the key of the object that contains
/// both. Throws std::invalid_argument.
inline std::vector<VehicleId> vehicles_named(const std::string& other, const std::vector<std::string>& others,
                                             const AgentSetup& setup, const std::string& key) {
  if (others.empty()) return {vehicle_named(other, setup, (key + ".other").c_str())};
  std::vector<VehicleId> ids;
  ids.reserve(others.size());
  for (const std::string& name : others) {
    ids.push_back(vehicle_named(name, setup, (key + ".others").c_str()));
    if (std::count(ids.begin(), ids.end(), ids.back()) > 1) {
      throw std::invalid_argument(key + ".others: expected each name once, found \"" + name + "\" twice");
    }
  }
  return ids;
}

}  // namespace swiftlet
