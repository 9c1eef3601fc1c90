// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/geodesy.hpp"

#include <cmath>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet::sim {
namespace {

// WGS 84 (NIMA TR8350.2): semi-major axis and flattening.
constexpr double kA = 6378137.0;
constexpr double kF = 1.0 / 298.257223563;
constexpr double kE2 = kF * (2.0 - kF);

/// Radius of curvature in the prime vertical.
double prime_vertical_radius(double latitude_rad) {
  const double s = std::sin(latitude_rad);
  return kA / std::sqrt(1.0 - kE2 * s * s);
}

}  // namespace

Vector3 ecef_of(const Geodetic& position) {
  const double latitude = position.latitude_deg * kRadPerDeg;
  const double longitude = position.longitude_deg * kRadPerDeg;
  const double n = prime_vertical_radius(latitude);
  return {(n + position.altitude_m) * std::cos(latitude) * std::cos(longitude),
          (n + position.altitude_m) * std::cos(latitude) * std::sin(longitude),
          (n * (1.0 - kE2) + position.altitude_m) * std::sin(latitude)};
}

Geodetic geodetic_of(const Vector3& p) {
  const double rho = std::hypot(p.x(), p.y());
  // Fixed point of tan(latitude) = (z + e^2 N sin(latitude)) / rho; contracts by e^2 (0.0067) a step near the ground.
  double latitude = std::atan2(p.z(), rho * (1.0 - kE2));
  for (int i = 0; i < 8; ++i) {
    latitude = std::atan2(p.z() + kE2 * prime_vertical_radius(latitude) * std::sin(latitude), rho);
  }
  // Well conditioned at the equator and at the poles.
  const double s = std::sin(latitude);
  const double altitude = rho * std::cos(latitude) + p.z() * s - kA * std::sqrt(1.0 - kE2 * s * s);
  return {latitude / kRadPerDeg, std::atan2(p.y(), p.x()) / kRadPerDeg, altitude};
}

Geodetic geodetic_of_world(const Vector3& p_world_m, const Geodetic& datum) {
  const double latitude = datum.latitude_deg * kRadPerDeg;
  const double longitude = datum.longitude_deg * kRadPerDeg;
  const double sin_lat = std::sin(latitude), cos_lat = std::cos(latitude);
  const double sin_lon = std::sin(longitude), cos_lon = std::cos(longitude);
  Matrix3 R_ecef_world;                                             // columns: east, north, up
  R_ecef_world << -sin_lon, -sin_lat * cos_lon, cos_lat * cos_lon,  //
      cos_lon, -sin_lat * sin_lon, cos_lat * sin_lon,               //
      0.0, cos_lat, sin_lat;
  return geodetic_of(ecef_of(datum) + R_ecef_world * p_world_m);
}

}  // namespace swiftlet::sim
