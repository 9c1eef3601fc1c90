// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet::sim {

/// Position on the WGS 84 ellipsoid.
struct Geodetic {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double altitude_m = 0.0;  ///< above the ellipsoid
};

/// Earth-centered, earth-fixed coordinates [m].
Vector3 ecef_of(const Geodetic& position);
Geodetic geodetic_of(const Vector3& p_ecef_m);
/// Geodetic position of a point of the world (east, north, up from `datum`).
Geodetic geodetic_of_world(const Vector3& p_world_m, const Geodetic& datum);

}  // namespace swiftlet::sim
