// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/air_effects.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet::sim {

double ground_effect_gain(double height_m, double propeller_radius_m, double coefficient) {
  if (height_m <= 0.0) return coefficient > 0.0 ? kGroundEffectGainMax : 0.0;
  const double ratio = propeller_radius_m / (4.0 * height_m);
  return std::min(coefficient * ratio * ratio, kGroundEffectGainMax);
}

double Wake::axis_speed_mps(double z_m) const {
  const double developed = 1.0 + z_m / std::sqrt(z_m * z_m + disc_radius_m * disc_radius_m);
  return induced_mps * developed * width_m(0.0) / width_m(z_m);
}

Vector3 Wake::velocity_world_mps(const Vector3& p_world_m) const {
  const Vector3 offset = p_world_m - origin_world_m;
  const double z_m = offset.dot(axis_world);
  if (z_m <= 0.0 || z_m > kReach_m || induced_mps <= 0.0) return Vector3::Zero();
  const double width = width_m(z_m);
  const double footprint_m = footprint_m_at(z_m);
  const double r_sq = offset.squaredNorm() - z_m * z_m;
  if (r_sq > footprint_m * footprint_m) return Vector3::Zero();
  return axis_speed_mps(z_m) * elementary::exp(-0.5 * r_sq / (width * width)) * axis_world;
}

Wake make_wake(const Airframe& airframe, const Vector3& p_world_m, const Matrix3& R_world_body, double thrust_N,
               double air_density_kgpm3) {
  const double area_m2 =
      airframe.num_rotors() * std::numbers::pi * airframe.propeller_radius_m * airframe.propeller_radius_m;
  Wake wake;
  wake.origin_world_m = p_world_m;
  wake.axis_world = -R_world_body.col(2);
  wake.induced_mps = area_m2 > 0.0 ? std::sqrt(std::max(thrust_N, 0.0) / (2.0 * air_density_kgpm3 * area_m2)) : 0.0;
  wake.disc_radius_m = std::sqrt(area_m2 / std::numbers::pi);
  return wake;
}

}  // namespace swiftlet::sim
