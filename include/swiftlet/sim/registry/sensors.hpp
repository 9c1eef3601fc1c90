// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/registry.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {

/// One row of sim/registry/sensors.cpp.
struct SensorType {
  ModuleType module;
  std::unique_ptr<Sensor> (*make)(const ModuleConfig& config, SensorSetup setup);
};

Registry<SensorType>& sensor_registry();
inline std::span<const ModuleType> sensor_module_types() { return sensor_registry().modules(); }
/// Throws std::invalid_argument on an unknown type (the reader has already checked).
std::unique_ptr<Sensor> make_sensor(const Module& config, SensorSetup setup);

}  // namespace swiftlet::sim
