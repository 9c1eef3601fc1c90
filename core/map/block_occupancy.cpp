// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/block_occupancy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/map/cell_walk.hpp"
#include "swiftlet/core/map/occupancy_map.hpp"
#include "swiftlet/core/map/submap_map.hpp"

namespace swiftlet {

template <class Map>
BlockOccupancy<Map>::BlockOccupancy(double edge_m, double distance_max_m)
    : edge_m_(edge_m),
      cells_per_m_(1.0 / edge_m),
      distance_max_m_(distance_max_m),
      distances_(static_cast<int>(std::ceil(distance_max_m / edge_m))) {}

template <class Map>
void BlockOccupancy<Map>::occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                                      std::vector<Vector3>& centers_local_m) const {
  centers_local_m.clear();
  const double half_m = 0.5 * edge_m_;
  for_occupied(min_local_m, max_local_m, [&](const Vector3& cell_local_m) {
    const bool above_min = (cell_local_m.array() + half_m >= min_local_m.array()).all();
    if (above_min && (cell_local_m.array() - half_m <= max_local_m.array()).all())
      centers_local_m.push_back(cell_local_m);
  });
}

template <class Map>
double BlockOccupancy<Map>::distance_m(const Vector3& p_local_m, double max_m) const {
  double nearest_sq = max_m * max_m;
  const double half_m = 0.5 * edge_m_;
  for_occupied(p_local_m.array() - max_m, p_local_m.array() + max_m, [&](const Vector3& cell_local_m) {
    const Vector3 gap = ((cell_local_m - p_local_m).array().abs() - half_m).cwiseMax(0.0);
    nearest_sq = std::min(nearest_sq, gap.squaredNorm());
  });
  return std::sqrt(nearest_sq);
}

template <class Map>
double BlockOccupancy<Map>::clearance_m(const Vector3& p_local_m, double max_m) const {
  const std::int16_t squared_cells = distances_.squared(cell_of(p_local_m), *this, revision_);
  if (squared_cells != DistanceTiles::kFar)
    return std::min(max_m, std::sqrt(static_cast<double>(squared_cells)) * edge_m_);
  // Distances beyond distance_max_m_ are not tabulated.
  return max_m <= distance_max_m_ ? max_m : Map::clearance_m(p_local_m, max_m);
}

template <class Map>
std::optional<SegmentHit> BlockOccupancy<Map>::first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const {
  Cell cell, block = Cell::Constant(std::numeric_limits<int>::max());
  const Bits* occupied = nullptr;
  const double hit_distance_m = distance_to_first_m(from_local_m, to_local_m, cells_per_m_, cell, [&](const Cell& at) {
    if (block_of(at) != block) {
      block = block_of(at);
      occupied = occupied_of(block);
    }
    return occupied != nullptr && has(*occupied, index_in_block(at));
  });
  if (hit_distance_m < 0.0) return std::nullopt;
  return SegmentHit{hit_distance_m, center_of(cell)};
}

template class BlockOccupancy<OccupancyMap>;
template class BlockOccupancy<SubmapMap>;

}  // namespace swiftlet
