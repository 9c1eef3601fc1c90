// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "sim/physics/contacts.hpp"
#include "sim/physics/world_vehicle.hpp"

namespace swiftlet::sim {

/// Pairs of vehicles that may touch before a prediction ends. The least gap between any two vehicles bounds the time
/// without contacts, so that all pairs of a well separated fleet are rarely tested.
class NearPairs {
 public:
  explicit NearPairs(std::size_t num_vehicles);

  /// @param vehicles  with the travel of the prediction
  void find(std::span<const Vector3> positions_world_m, std::span<const WorldVehicle> vehicles);
  std::span<const Contacts::Pair> pairs() const { return pairs_; }
  bool contain(VehicleId id) const;

 private:
  std::vector<Contacts::Pair> pairs_;
  std::vector<Vector3> from_;  // positions at the last search of all pairs
  double least_gap_m_ = 0.0;   // least gap between two vehicles at that search
};

}  // namespace swiftlet::sim
