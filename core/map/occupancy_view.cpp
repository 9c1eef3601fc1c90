// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/map/occupancy_view.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {

double OccupancyView::clearance_m(const Vector3& p_local_m, double max_m) const {
  const Vector3 center_local_m = ((p_local_m.array() / edge_m()).floor() + 0.5) * edge_m();
  std::vector<Vector3> occupied_local_m;
  occupied_in(center_local_m.array() - max_m, center_local_m.array() + max_m, occupied_local_m);
  double least_sq = max_m * max_m;
  for (const Vector3& cell_local_m : occupied_local_m) {
    least_sq = std::min(least_sq, (cell_local_m - center_local_m).squaredNorm());
  }
  return std::sqrt(least_sq);
}

}  // namespace swiftlet
