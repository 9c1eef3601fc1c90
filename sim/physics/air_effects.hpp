// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

#include "swiftlet/core/base/airframe.hpp"
#include "swiftlet/core/base/frames.hpp"

/// Effect of rotors on the surrounding air and nearby surfaces: ground effect and downwash.
namespace swiftlet::sim {

/// Extra thrust of a rotor near a surface, as a fraction of its thrust in free air:
///   gain = coefficient * (R / (4 h))^2, at most 4/15.
/// The leading term of Cheeseman and Bennett (1955) has coefficient 1. gym-pybullet-drones fits 11.36859 to a whole
/// quadrotor. It clips the height where the gain of all rotors at full speed would exceed 4/15 (BaseAviary.py:715-760).
/// In dimensionless form that is the same limit for every vehicle.
/// @param height_m  height of the rotor's hub above the surface; negative values count as contact
double ground_effect_gain(double height_m, double propeller_radius_m, double coefficient);
/// [-] Coefficient of a whole quadrotor in the simulation. Larger values give more thrust near the ground.
inline constexpr double kGroundEffectCoefficient = 11.36859;
/// [-] Upper bound of the gain.
inline constexpr double kGroundEffectGainMax = 4.0 / 15.0;
/// Height in propeller radii above which the effect is neglected (gain 0.3 % at kGroundEffectCoefficient).
inline constexpr double kGroundEffectReachRadii = 15.0;

/// Air speed in the wake of a multirotor, with all rotors replaced by one disc of equal area A.
///
/// By momentum theory the speed is v_i = sqrt(T / (2 rho A)) at the disc. It grows to 2 v_i below as (1 + z / sqrt(z^2
/// + R^2)) (McCormick, vortex cylinder), while the stream tube contracts to half the area. From there it spreads like a
/// round turbulent jet, its half-width growing by 0.094 per meter (Pope, Turbulent Flows, sec. 5.1). Its Gaussian
/// profile carries the same momentum T at every distance.
/// The published fit of gym-pybullet-drones is not used: it gives newtons for a 27 g Crazyflie, and its footprint
/// shrinks to a point 0.69 m below the rotor.
struct Wake {
  Vector3 origin_world_m = Vector3::Zero();
  Vector3 axis_world = -Vector3::UnitZ();  ///< direction of the flow
  double induced_mps = 0.0;                ///< v_i
  double disc_radius_m = 0.0;              ///< radius of the equivalent disc

  /// Velocity of the air at a point [m/s]; zero outside the wake and farther than kReach_m below.
  Vector3 velocity_world_mps(const Vector3& p_world_m) const;
  /// Fast test for all pairs of vehicles: false where velocity_world_mps() is certainly zero.
  bool may_reach(const Vector3& p_world_m) const {
    const Vector3 offset = p_world_m - origin_world_m;
    const double z_m = offset.dot(axis_world);
    if (!(z_m > 0.0 && z_m <= kReach_m)) return false;
    const double footprint_m = footprint_m_at(z_m);
    return offset.squaredNorm() - z_m * z_m <= footprint_m * footprint_m;
  }
  /// Speed on the axis at a distance z >= 0 below the disc [m/s], and width of the Gaussian there [m].
  double axis_speed_mps(double z_m) const;
  double width_m(double z_m) const { return disc_radius_m / std::numbers::sqrt2 + kJetSpread * z_m; }
  /// Radius beyond which the wake is neglected.
  double footprint_m_at(double z_m) const { return kFootprintWidths * width_m(z_m); }

  // Half-width of a round jet grows by 0.094 z; exp(-r^2 / (2 b^2)) is one half at r = 1.1774 b.
  static constexpr double kJetSpread = 0.094 / 1.1774;
  /// [-] Radius of the wake / width of the Gaussian, which falls to 3e-4 there. Larger values cost time.
  static constexpr double kFootprintWidths = 4.0;
  /// [m] Length of the wake; the speed below a vehicle of 2 kg falls to 1 m/s there. Larger values cost time.
  static constexpr double kReach_m = 20.0;
};

Wake make_wake(const Airframe& airframe, const Vector3& p_world_m, const Matrix3& R_world_body, double thrust_N,
               double air_density_kgpm3);

}  // namespace swiftlet::sim
