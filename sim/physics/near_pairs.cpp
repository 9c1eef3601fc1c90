// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/near_pairs.hpp"

#include <algorithm>
#include <limits>

namespace swiftlet::sim {

NearPairs::NearPairs(std::size_t num_vehicles) : from_(num_vehicles, Vector3::Zero()) {
  pairs_.reserve(16 * num_vehicles);
}

void NearPairs::find(std::span<const Vector3> positions_world_m, std::span<const WorldVehicle> vehicles) {
  pairs_.clear();
  double displacement_m = 0.0;
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    displacement_m = std::max(displacement_m, (positions_world_m[i] - from_[i]).norm() + vehicles[i].travel_m);
  }
  if (2.0 * displacement_m < least_gap_m_) return;

  least_gap_m_ = std::numeric_limits<double>::infinity();
  from_.assign(positions_world_m.begin(), positions_world_m.end());
  const VehicleId count = static_cast<VehicleId>(vehicles.size());
  for (VehicleId a = 0; a < count; ++a) {
    for (VehicleId b = a + 1; b < count; ++b) {
      const double gap_m = (positions_world_m[a] - positions_world_m[b]).norm() - vehicles[a].contact_reach_m -
                           vehicles[b].contact_reach_m;
      least_gap_m_ = std::min(least_gap_m_, gap_m);
      if (gap_m <= vehicles[a].travel_m + vehicles[b].travel_m) pairs_.push_back({a, b});
    }
  }
}

bool NearPairs::contain(VehicleId id) const {
  return std::any_of(pairs_.begin(), pairs_.end(),
                     [id](const Contacts::Pair& pair) { return pair.a == id || pair.b == id; });
}

}  // namespace swiftlet::sim
