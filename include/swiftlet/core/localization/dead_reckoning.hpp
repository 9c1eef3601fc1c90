// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "swiftlet/core/base/observation.hpp"

namespace swiftlet {

/// Rotation by the vector `angle` (axis times angle) [rad]. Any frame, the same for all arguments.
Eigen::Quaterniond rotation_by(const Vector3& angle_rad);

/// State of the body; z is vertical. Any frame, the same for all arguments.
struct NavState {
  TimeNs t = 0;
  Vector3 p_m = Vector3::Zero();
  Vector3 v_mps = Vector3::Zero();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();  ///< rotation from the body to the frame of p_m
  Vector3 omega_body_radps = Vector3::Zero();

  bool all_finite() const {
    return p_m.allFinite() && v_mps.allFinite() && q.coeffs().allFinite() && omega_body_radps.allFinite();
  }
};

/// One strapdown step: specific force and body rate constant over dt; attitude exact, the force rotated at mid-step.
void strapdown(NavState& state, const Vector3& omega_body_radps, const Vector3& specific_force_body_mps2, double dt_s);

/// Propagates a delayed or low-rate pose to the present by IMU samples, or by constant velocity and body rate without
/// an IMU. Keeps the last 256 samples, which limits the delay of a pose.
class DeadReckoning {
 public:
  void push(const ImuSample& sample);
  /// Stores the sample for the next restart(), which must come before the next push() or at().
  void keep(const ImuSample& sample);
  /// Restarts from a known state and applies the samples after its time.
  void restart(const NavState& state);
  /// State at t; extrapolated beyond the last sample.
  NavState at(TimeNs t) const;
  /// Time of the newest sample, or of the last restart when there is none.
  TimeNs latest() const { return state_.t; }

 private:
  /// [-] Stored IMU samples. Smaller values drop the motion since an old pose.
  static constexpr int kCapacity = 256;
  const ImuSample& sample(int age) const { return ring_[(newest_ - age + kCapacity) % kCapacity]; }
  bool take(const ImuSample& sample);  // false: the sample is invalid or out of order
  void apply(const ImuSample& sample);

  NavState state_;
  std::array<ImuSample, kCapacity> ring_{};
  int newest_ = -1;
  int count_ = 0;
};

}  // namespace swiftlet
