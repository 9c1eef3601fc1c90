// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/physics/physics_config.hpp"

namespace swiftlet::sim {

/// Scales of the turbulence components: u along the mean wind's heading, v to its left, w up.
struct DrydenScales {
  Vector3 scale_length_m;
  Vector3 sigma_mps;
};

/// MIL-F-8785C below 1000 ft: L_w = h, L_u = L_v = h / (0.177 + 0.000823 h)^1.2 (h in ft), sigma_w = 0.1 W20,
/// sigma_u = sigma_v = sigma_w / (0.177 + 0.000823 h)^0.4. The height is clamped to 10..1000 ft (3..305 m).
DrydenScales dryden_scales(double height_m, double wind_at_6m_mps);

/// Turbulence at one vehicle. Each component is a first-order process in the distance flown through the air:
///   x' = a x + sqrt(1 - a^2) nu,  a = exp(-V dt / L_u) for u and exp(-2 V dt / L) for v and w.
/// This is the exact discretization (stable for any step) of the usual forward-difference form. The state has unit
/// variance and is scaled by sigma at output, so that a climb changes the intensity without a transient. The initial
/// state is stationary.
class Gusts {
 public:
  Gusts(const WindConfig& config, std::uint64_t seed, std::string_view vehicle);

  /// The gust of step number `step` (1, 2, ...; 0 is the start), world frame [m/s].
  /// @param height_m      height above z = 0 of the world
  /// @param airspeed_mps  airspeed of the vehicle. The frozen field is crossed at max(airspeed, mean wind, 1 m/s), so
  /// that a vehicle hovering in still air also encounters changing gusts.
  const Vector3& advance(std::uint32_t step, double dt_s, double height_m, double airspeed_mps);

 private:
  WindConfig config_;
  Random random_;
  double mean_speed_mps_ = 0.0;
  Vector3 along_ = Vector3::UnitX();  ///< heading of the mean wind; east without mean wind
  Vector3 left_ = Vector3::UnitY();
  Vector3 unit_gust_ = Vector3::Zero();  ///< (u, v, w) at unit variance
  Vector3 gust_world_mps_ = Vector3::Zero();
};

}  // namespace swiftlet::sim
