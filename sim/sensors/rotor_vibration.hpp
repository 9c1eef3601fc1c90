// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/sensors/vibration_config.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// Means of VibrationConfig over a sampling interval in closed form, so that sampling aliases and attenuates tones as
/// in a sensor that averages: by |sin(d / 2) / (d / 2)| at d radians an interval. Sensor axes.
class RotorVibration {
 public:
  RotorVibration(const VibrationConfig& config, Random random);

  struct Mean {
    Vector3 accel_sensor_mps2 = Vector3::Zero();
    Vector3 omega_sensor_radps = Vector3::Zero();
  };
  /// @param start, end  states at both ends of the interval, `dt_s` apart
  Mean mean(const VehicleState& start, const VehicleState& end, double dt_s) const;

 private:
  VibrationConfig config_;
  std::array<double, kMaxRotors> phase_rad_{};  // direction of each rotor's unbalance at angle 0
};

}  // namespace swiftlet::sim
