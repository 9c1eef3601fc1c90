// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/overlay.hpp"
#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// Overlay of the occupied cells near the vehicle.
inline Overlay near_cells(const OccupancyView& map, const Vector3& p_local_m) {
  // [m] Radius around the vehicle, and depth below it, of the cells in the overlay. Lower cells are mostly ground and
  // would hide the rest.
  constexpr double kShown_m = 15.0, kShownBelow_m = 1.0;
  Overlay cells;
  cells.name = "mapping.cells";
  cells.kind = Overlay::Kind::kCubes;
  cells.size_m = static_cast<float>(map.edge_m());
  cells.colors = {{0.95F, 0.60F, 0.25F, 1.0F}};
  cells.legend = {{"occupied cells of the map", cells.colors.front()}};
  std::vector<Vector3> centers_local_m;
  map.occupied_within(p_local_m, kShown_m, kEver, centers_local_m);
  cells.positions.reserve(centers_local_m.size());
  for (const Vector3& center_local_m : centers_local_m) {
    if (center_local_m.z() > p_local_m.z() - kShownBelow_m) cells.positions.push_back(center_local_m.cast<float>());
  }
  return cells;
}

}  // namespace swiftlet
