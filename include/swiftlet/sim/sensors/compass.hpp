// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {

/// Heading from a tilt-compensated magnetometer: white noise, a constant calibration error, and slow disturbances.
struct CompassConfig : SensorConfigOf<CompassConfig> {
  double rate_hz = 50.0;
  double sigma_deg = 1.0;
  double bias_sigma_deg = 2.0;
  double disturbance_sigma_deg = 1.0;

  void visit(ConfigVisitor& v) override;
};

/// The sigma of a sample covers the whole error.
std::unique_ptr<Sensor> make_compass_sensor(const ModuleConfig& config, SensorSetup setup);

}  // namespace swiftlet::sim
