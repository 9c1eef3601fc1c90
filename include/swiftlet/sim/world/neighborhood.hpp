// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// Exact clearances of one vehicle at the end of a tick: distances of its center, less radii.
struct Clearance {
  double surface_m = 0.0;  ///< to the nearest triangle, less the vehicle's circumscribed radius; at least -radius
  double vehicle_m = 0.0;  ///< to the center of the nearest other vehicle, less both radii; infinity when alone
  VehicleId nearest_vehicle = kNoVehicle;
};

/// Candidates for the nearest vehicle of each vehicle. The lists are rebuilt only when motion could have changed them
/// (L. Verlet, Phys. Rev. 159, 98, 1967), so that the exact distance to the nearest of 100 vehicles costs a few
/// distances per tick instead of 99.
class Neighborhood {
 public:
  /// @param radii_m  indexed by VehicleId, subtracted from the distances between centers; with zeros, the distances are
  /// those between centers
  explicit Neighborhood(std::vector<double> radii_m);

  /// Call after every tick.
  void update(std::span<const VehicleState> states);
  /// Candidates of a vehicle, in ascending order. They include its nearest vehicle at the last update(), and all others
  /// at equal distance.
  std::span<const VehicleId> candidates(VehicleId vehicle) const { return candidates_[vehicle]; }

 private:
  void search(std::span<const VehicleState> states);

  std::vector<double> radii_m_;
  std::vector<Vector3> from_world_m_;  // positions at the last rebuild
  std::vector<std::vector<VehicleId>> candidates_;
  std::vector<double> gaps_m_;  // distances of one vehicle, scratch
};

}  // namespace swiftlet::sim
