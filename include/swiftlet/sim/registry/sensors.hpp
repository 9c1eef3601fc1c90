// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/sim/recording/series.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {

/// Sensor type that a scenario can choose; the list is in sim/registry/sensors.cpp.
struct SensorType {
  ModuleType module;
  std::unique_ptr<Sensor> (*make)(const ModuleConfig& config, SensorSetup setup);
  TableType (*samples)() = nullptr;  ///< sample_table<Sample>, for samples in Observation::others
};

/// Name and columns of the table of one sample type.
template <class Sample>
TableType sample_table() {
  return {Sample::kName, columns_of<Sample>()};
}

Registry<SensorType>& sensor_registry();
inline std::span<const ModuleType> sensor_module_types() { return sensor_registry().modules(); }
/// Throws std::invalid_argument on an unknown type (already checked by the reader).
std::unique_ptr<Sensor> make_sensor(const Module& config, SensorSetup setup);

}  // namespace swiftlet::sim
