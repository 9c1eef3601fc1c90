// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// Vibration that the rotors excite in an inertial sensor. Each rotor contributes a vector that turns with it about the
/// z axis of the sensor, and along z a component at twice its speed, the passing of two blades. Amplitudes grow with
/// the square of the rotor's speed, as the forces of unbalance and lift do.
struct VibrationConfig {
  double accel_mps2 = 0.0;  ///< amplitude by rotor and axis at rotor_speed_radps
  double gyro_radps = 0.0;  ///< likewise
  double rotor_speed_radps = 500.0;

  bool none() const { return accel_mps2 == 0.0 && gyro_radps == 0.0; }
  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
