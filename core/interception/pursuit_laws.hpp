// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/control/motion_limits.hpp"
#include "swiftlet/core/interception/intercept_config.hpp"

namespace swiftlet {

/// Target state minus interceptor state. Any frame, the same for all arguments.
struct RelativeMotion {
  Vector3 p_m = Vector3::Zero();
  Vector3 v_mps = Vector3::Zero();
};

/// |p| / |v|, clamped to its bounds: the ratio is 0 or infinite when the relative motion vanishes.
double time_to_go_s(const PursuitGains& gains, const RelativeMotion& relative);

// Commanded accelerations, without limits. Any frame, the same for all arguments.

/// Toward the target: G p.
Vector3 pure_pursuit_mps2(const PursuitGains& gains, const RelativeMotion& relative);
/// Proportional navigation in its linear form: N (p + v t) / t^2 with the time to go t.
Vector3 proportional_navigation_mps2(const PursuitGains& gains, const RelativeMotion& relative);
/// Fast response proportional navigation (Pliska et al., IEEE RA-L 9(10), 2024): G ((1 - W) (p + v t) / t^2 + W p). The
/// second term keeps accelerating when the velocities are equal.
Vector3 frpn_mps2(const PursuitGains& gains, const RelativeMotion& relative);

/// Scales the acceleration to its limits and keeps the direction. Any frame, the same for all arguments.
Vector3 within_acceleration(const Vector3& a_mps2, const MotionLimits& limits);

}  // namespace swiftlet
