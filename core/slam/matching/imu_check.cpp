// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/matching/imu_check.hpp"

#include <algorithm>

namespace swiftlet {
namespace {

// Samples at the start whose mean specific force is tested.
constexpr int kStartSamples = 50;
// Plausible specific force at the start, for a vehicle at rest or in flight. An IMU in g measures 1.
constexpr double kLeastForce_mps2 = 4.0, kMostForce_mps2 = 25.0;
// Least share of the force along the body's z axis: half of it at a tilt of 60 degrees.
constexpr double kLeastUpward = 0.3;
// Largest body rate: the range of gyroscopes for vehicles is 2000 deg/s. In deg/s it is exceeded in every maneuver.
constexpr double kMostRate_radps = 35.0;
// Samples above it, less those below it, that count as a wrong unit. Smaller values react to single errors.
constexpr int kTooFast = 20;

}  // namespace

void ImuCheck::add(const ImuSample& sample) {
  if (fault_[0] != '\0' || !sample.omega_body_radps.allFinite() || !sample.specific_force_body_mps2.allFinite()) return;
  const bool too_fast = sample.omega_body_radps.norm() > kMostRate_radps;
  num_too_fast_ = std::max(0, num_too_fast_ + (too_fast ? 1 : -1));
  if (num_too_fast_ >= kTooFast) fault_ = "IMU: body rates above 35 rad/s; expected rad/s, not deg/s";
  if (num_samples_ >= kStartSamples) return;
  force_sum_body_mps2_ += sample.specific_force_body_mps2;
  if (++num_samples_ < kStartSamples) return;
  const Vector3 mean_mps2 = force_sum_body_mps2_ / kStartSamples;
  const double force_mps2 = mean_mps2.norm();
  if (force_mps2 < kLeastForce_mps2 || force_mps2 > kMostForce_mps2)
    fault_ = "IMU: specific force far from 9.81 m/s^2; expected m/s^2, not g";
  else if (mean_mps2.z() < kLeastUpward * force_mps2)
    fault_ = "IMU: specific force does not point up; expected (0, 0, 9.81) at rest in x forward, y left, z up";
}

}  // namespace swiftlet
