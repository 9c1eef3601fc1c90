// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {

/// Compass: heading from a tilt-compensated magnetometer. Its error is the sum of white noise, a constant calibration
/// error drawn for each run, and slow magnetic disturbances.
struct CompassConfig : SensorConfigOf<CompassConfig> {
  double rate_hz = 50.0;
  double sigma_deg = 1.0;
  double bias_sigma_deg = 2.0;
  double disturbance_sigma_deg = 1.0;

  void visit(ConfigVisitor& v) override;
};

/// Each sample states the standard deviation of the total error, with all three parts.
std::unique_ptr<Sensor> make_compass_sensor(const ModuleConfig& config, SensorSetup setup);

}  // namespace swiftlet::sim
