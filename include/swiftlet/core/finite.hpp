// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/observation.hpp"

/// Is every number of a value finite? Asked wherever a value passes from one stage to the next.
namespace swiftlet {

inline bool is_finite(double value) { return value * 0.0 == 0.0; }

/// A product with zero is zero unless the coefficient is infinite or NaN; the sum keeps what is not.
template <class Derived>
bool is_finite(const Eigen::MatrixBase<Derived>& matrix) {
  return (matrix * 0.0).sum() == 0.0;
}

inline bool is_finite(const Eigen::Quaterniond& q) { return is_finite(q.coeffs()); }
inline bool is_finite(const Pose& pose) { return is_finite(pose.affine()); }

/// Exponents that are all ones are those of infinity and NaN. Counted, so that compilers take several numbers at a
/// time.
inline bool is_finite(std::span<const float> values) {
  constexpr std::uint32_t kExponent = 0x7f800000U;
  std::uint32_t count = 0;
  for (const float value : values) count += (std::bit_cast<std::uint32_t>(value) & kExponent) == kExponent;
  return count == 0;
}

inline bool is_finite(const StateEstimate& e) {
  return is_finite(e.T_local_body) && is_finite(e.v_local_mps) && is_finite(e.omega_body_radps) &&
         is_finite(e.T_world_local) && is_finite(e.covariance);
}

inline bool is_finite(const Reference& r) {
  return is_finite(r.position_m) && is_finite(r.velocity_mps) && is_finite(r.acceleration_mps2) &&
         is_finite(r.yaw_rad) && is_finite(r.yaw_rate_radps);
}

inline bool is_finite(const Detection& d) {
  return is_finite(d.position_m) && is_finite(d.covariance) && is_finite(d.extent_m) && is_finite(d.confidence);
}

inline bool is_finite(const Track& t) {
  return is_finite(t.position_m) && is_finite(t.velocity_mps) && is_finite(t.acceleration_mps2) &&
         is_finite(t.covariance);
}

inline bool is_finite(const RelativeEstimate& r) {
  return is_finite(r.position_m) && is_finite(r.velocity_mps) && is_finite(r.yaw_rad) && is_finite(r.covariance) &&
         is_finite(r.heard_position_m) && is_finite(r.heard_yaw_rad);
}

inline bool is_finite(const ImuSample& s) {
  return is_finite(s.omega_body_radps) && is_finite(s.specific_force_body_mps2);
}
inline bool is_finite(const OdometrySample& s) { return is_finite(s.T_local_body) && is_finite(s.v_local_body_mps); }
inline bool is_finite(const GnssSample& s) {
  return is_finite(s.p_world_m) && is_finite(s.v_world_mps) && is_finite(s.sigma_p_m) && is_finite(s.sigma_v_mps);
}
inline bool is_finite(const AltimeterSample& s) { return is_finite(s.height_m) && is_finite(s.sigma_m); }
inline bool is_finite(const CompassSample& s) { return is_finite(s.yaw_rad) && is_finite(s.sigma_rad); }
inline bool is_finite(const PoseSample& s) {
  return is_finite(s.T_world_body) && is_finite(s.v_world_mps) && is_finite(s.omega_body_radps);
}
inline bool is_finite(const NeighborSample& s) { return is_finite(s.p_body_m) && is_finite(s.covariance_body); }
inline bool is_finite(const Scan& s) {
  return is_finite(s.T_body_lidar) && is_finite(std::span<const float>(s.range_m)) &&
         is_finite(std::span<const float>(s.intensity)) && is_finite(std::span<const float>(s.reflectivity)) &&
         std::all_of(s.external_poses.begin(), s.external_poses.end(),
                     [](const StampedPose& pose) { return is_finite(pose.T_world_body); });
}

}  // namespace swiftlet
