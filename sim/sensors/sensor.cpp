// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/sensor.hpp"

#include <algorithm>
#include <stdexcept>

namespace swiftlet::sim {

std::vector<std::string> sensor_names(std::span<const Module> sensors) {
  std::vector<std::string> names(sensors.size());
  const auto taken = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  // Configured names first, so that no generated name equals one of them.
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const auto* config = dynamic_cast<const SensorConfig*>(sensors[i].config.get());
    if (config == nullptr || config->name.empty()) continue;
    if (taken(config->name)) throw std::invalid_argument("two sensors are named '" + config->name + "'");
    names[i] = config->name;
  }
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (!names[i].empty()) continue;
    std::string name = sensors[i].type;
    for (int number = 2; taken(name); ++number) name = sensors[i].type + std::to_string(number);
    names[i] = name;
  }
  return names;
}

}  // namespace swiftlet::sim
