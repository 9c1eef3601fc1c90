// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "swiftlet/core/observation.hpp"

namespace swiftlet {

inline constexpr double kStandardGravity_mps2 = 9.81;

/// Rotation by the vector `angle` (axis times angle) [rad]. Any frame, the same for all arguments.
Eigen::Quaterniond rotation_by(const Vector3& angle_rad);

/// Motion of the body; z is vertical. Any frame, the same for all arguments.
struct NavState {
  TimeNs t = 0;
  Vector3 p_m = Vector3::Zero();
  Vector3 v_mps = Vector3::Zero();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();  ///< body to that frame
  Vector3 omega_body_radps = Vector3::Zero();

  bool all_finite() const {
    return p_m.allFinite() && v_mps.allFinite() && q.coeffs().allFinite() && omega_body_radps.allFinite();
  }
};

/// One strapdown step: specific force and body rate constant over dt; attitude exact, the force turned at mid-step.
void strapdown(NavState& state, const Vector3& omega_body_radps, const Vector3& specific_force_body_mps2, double dt_s);

/// Carries a pose of the past, or one that comes rarely, to the present. It uses the IMU's samples, or constant
/// velocity and body rate when there is no IMU. It keeps the last 256 samples, so a pose may come late by that much.
class DeadReckoning {
 public:
  void push(const ImuSample& sample);
  /// Keeps the sample for the next restart(), which must come before the next push() or at().
  void keep(const ImuSample& sample);
  /// Starts over from a known state; samples after its time are applied at once.
  void restart(const NavState& state);
  /// The state at t; what lies beyond the last sample is extrapolated.
  NavState at(TimeNs t) const;
  /// Time of the newest sample; of the last restart when there is none.
  TimeNs latest() const { return state_.t; }

 private:
  static constexpr int kCapacity = 256;
  const ImuSample& sample(int age) const { return ring_[(newest_ - age + kCapacity) % kCapacity]; }
  bool take(const ImuSample& sample);  // false: not a sample that comes next
  void apply(const ImuSample& sample);

  NavState state_;
  std::array<ImuSample, kCapacity> ring_{};
  int newest_ = -1;
  int count_ = 0;
};

}  // namespace swiftlet
