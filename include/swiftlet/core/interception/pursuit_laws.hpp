// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/config.hpp"
#include "swiftlet/core/control/motion_limits.hpp"
#include "swiftlet/core/frames.hpp"

namespace swiftlet {

/// Gains of the laws with which planners of interceptors are compared.
struct PursuitGains {
  double pure_pursuit = 1.0;
  double proportional_navigation = 3.0;
  double frpn = 19.7;
  double frpn_weight = 0.051;
  double time_to_go_min_s = 0.05;
  double time_to_go_max_s = 30.0;

  void visit(ConfigVisitor& v);
};

/// Target minus interceptor. Any frame, the same for all arguments.
struct RelativeMotion {
  Vector3 p_m = Vector3::Zero();
  Vector3 v_mps = Vector3::Zero();
};

/// |p| / |v|, within its bounds: it is 0 or infinite when both fly alike.
double time_to_go_s(const PursuitGains& gains, const RelativeMotion& relative);

// Accelerations that the laws want, however large. Any frame, the same for all arguments.

/// Toward the target: G p.
Vector3 pure_pursuit_mps2(const PursuitGains& gains, const RelativeMotion& relative);
/// Proportional navigation in its linear form: N (p + v t) / t^2 with the time to go t.
Vector3 proportional_navigation_mps2(const PursuitGains& gains, const RelativeMotion& relative);
/// Fast response proportional navigation (Pliska et al., IEEE RA-L 9(10), 2024): G ((1 - W) (p + v t) / t^2 + W p).
/// The second term pulls on when both fly alike.
Vector3 frpn_mps2(const PursuitGains& gains, const RelativeMotion& relative);

/// Shortened to the limits of acceleration, direction kept. Any frame, the same for all arguments.
Vector3 within_acceleration(const Vector3& a_mps2, const MotionLimits& limits);

}  // namespace swiftlet
