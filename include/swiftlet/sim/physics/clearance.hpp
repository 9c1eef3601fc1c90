// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/frames.hpp"

namespace swiftlet::sim {

/// Exact distances of one vehicle's center at the end of a tick.
struct Clearance {
  double surface_m =
      0.0;  ///< center of mass to the nearest triangle, less the circumscribed radius (so down to -radius)
  double vehicle_m = 0.0;  ///< to the nearest other vehicle, less both circumscribed radii; infinity when alone
  VehicleId nearest_vehicle = kNoVehicle;
};

}  // namespace swiftlet::sim
