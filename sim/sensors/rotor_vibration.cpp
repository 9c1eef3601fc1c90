// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/rotor_vibration.hpp"

#include <cmath>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"

namespace swiftlet::sim {
namespace {

/// Mean of cos over the angles from a to b.
double mean_cosine(double a, double b) {
  const double half = 0.5 * (b - a);
  const double attenuation = std::abs(half) < 1e-9 ? 1.0 : elementary::sin(half) / half;
  return attenuation * elementary::cos(0.5 * (a + b));
}

}  // namespace

void VibrationConfig::visit(ConfigVisitor& v) {
  v.field("accel_mps2", accel_mps2, "[m/s^2] amplitude of the acceleration by rotor and axis at rotor_speed_radps",
          Range::non_negative());
  v.field("gyro_radps", gyro_radps, "[rad/s] amplitude of the rates by rotor and axis at rotor_speed_radps",
          Range::non_negative());
  v.field("rotor_speed_radps", rotor_speed_radps, "[rad/s] rotor speed to which the amplitudes refer",
          Range::positive());
}

RotorVibration::RotorVibration(const VibrationConfig& config, Random random) : config_(config) {
  for (int r = 0; r < kMaxRotors; ++r) phase_rad_[r] = random.uniform(0.0, 2.0 * kPi, 0, r);
}

RotorVibration::Mean RotorVibration::mean(const VehicleState& start, const VehicleState& end, double dt_s) const {
  Mean sum;
  for (int r = 0; r < kMaxRotors; ++r) {
    const double a = start.rotor_angle_rad[r] + phase_rad_[r], b = end.rotor_angle_rad[r] + phase_rad_[r];
    const double relative_speed = (b - a) / (dt_s * config_.rotor_speed_radps);
    const double growth = relative_speed * relative_speed;
    if (growth == 0.0) continue;
    const double cosine = mean_cosine(a, b), sine = mean_cosine(a - 0.5 * kPi, b - 0.5 * kPi);
    const double blades = mean_cosine(2.0 * a, 2.0 * b);
    sum.accel_sensor_mps2 += config_.accel_mps2 * growth * Vector3(cosine, sine, blades);
    sum.omega_sensor_radps += config_.gyro_radps * growth * Vector3(sine, cosine, blades);
  }
  return sum;
}

}  // namespace swiftlet::sim
