// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {

/// The sensor with the clock and the latency of its configuration; unchanged when both are exact. The vehicle's history
/// must reach back by the latency as well (look_back_s). Samples of a type without a list of its own in Observation
/// keep their stamps.
std::unique_ptr<Sensor> with_clock(std::unique_ptr<Sensor> sensor, const SensorConfig& config, SensorSetup setup);

}  // namespace swiftlet::sim
