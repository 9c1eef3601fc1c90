// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::sim {

/// Laser rangefinder that points down; it measures only the static world, not other vehicles.
struct AltimeterConfig : SensorConfigOf<AltimeterConfig> {
  double rate_hz = 50.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  enum class Beam { kVertical, kBody };
  Beam beam = Beam::kVertical;  ///< "vertical": gimballed or compensated; "body": fixed to the body
  double range_min_m = 0.05;
  double range_max_m = 40.0;
  double sigma_m = 0.03;
  double sigma_relative = 0.0;

  void visit(ConfigVisitor& v) override;
};

/// Height of the body's origin above the surface: range times the cosine of the beam's tilt, plus the height of the
/// origin over the sensor. Out of range: no sample.
std::unique_ptr<Sensor> make_altimeter_sensor(const ModuleConfig& config, SensorSetup setup);

}  // namespace swiftlet::sim
