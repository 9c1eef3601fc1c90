// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "swiftlet/core/map/voxel_grid.hpp"
#include "swiftlet/core/map_voxels.hpp"
#include "swiftlet/core/time.hpp"

namespace swiftlet {

enum class CellState : std::uint8_t { kUnknown, kFree, kOccupied };

/// Where a segment meets the first occupied cell.
struct SegmentHit {
  double distance_m = 0.0;  ///< from its beginning to the cell
  Vector3 center_local_m = Vector3::Zero();
};

inline constexpr TimeNs kEver = std::numeric_limits<TimeNs>::min();

/// What a vehicle's map of its surroundings can be asked, as of now, in the local frame. Cheap to hand on; never
/// copied.
class OccupancyView {
 public:
  virtual ~OccupancyView() = default;
  virtual double edge_m() const = 0;
  virtual CellState state(const Vector3& p_local_m) const = 0;
  /// Centers of the occupied cells whose nearest point lies in the ball; those not hit since `since` left out.
  virtual void occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                               std::vector<Vector3>& centers_local_m) const = 0;
  /// Centers of the occupied cells that reach into the box.
  virtual void occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                           std::vector<Vector3>& centers_local_m) const = 0;
  /// To the nearest point of an occupied cell; at most `max_m`.
  virtual double distance_m(const Vector3& p_local_m, double max_m) const = 0;
  /// From the center of the point's cell to the nearest center of an occupied cell, exact; at most `max_m`.
  virtual double clearance_m(const Vector3& p_local_m, double max_m) const;
  /// The first occupied cell on the segment, that of its beginning included.
  virtual std::optional<SegmentHit> first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const = 0;
  /// Grows whenever the map may have changed.
  virtual std::uint64_t revision() const = 0;
  /// Boxes of cells outside of which every state is what it was at that revision; false when that is not known.
  virtual bool changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const = 0;
  /// A copy for whoever looks at it, its name apart.
  virtual void append_voxels(MapVoxels& /*copy*/) const {}
};

}  // namespace swiftlet
