// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// Exact distances of one vehicle's center at the end of a tick.
struct Clearance {
  double surface_m = 0.0;  ///< to the nearest triangle, less the circumscribed radius (so down to -radius)
  double vehicle_m = 0.0;  ///< to the nearest other vehicle, less both circumscribed radii; infinity when alone
  VehicleId nearest_vehicle = kNoVehicle;
};

/// Who may be the nearest vehicle of whom. The lists are made anew only when motion could have changed the answer
/// (L. Verlet, Phys. Rev. 159, 98, 1967), so that the exact distance to the nearest of 100 vehicles costs a few
/// distances in a tick, not 99.
class Neighborhood {
 public:
  /// @param radii_m  by VehicleId, taken off the distances between centers; all zero: centers count
  explicit Neighborhood(std::vector<double> radii_m);

  /// After every tick.
  void update(std::span<const VehicleState> states);
  /// Ascending. Whoever is nearest to this vehicle (of equally near ones, all) in the last update() is among them.
  std::span<const VehicleId> candidates(VehicleId vehicle) const { return candidates_[vehicle]; }

 private:
  void search(std::span<const VehicleState> states);

  std::vector<double> radii_m_;
  std::vector<Vector3> from_world_m_;  // where the vehicles were at the last search
  std::vector<std::vector<VehicleId>> candidates_;
  std::vector<double> gaps_m_;  // of one vehicle, scratch
};

}  // namespace swiftlet::sim
