// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "swiftlet/core/base/map_voxels.hpp"
#include "swiftlet/core/base/time.hpp"
#include "swiftlet/core/map/voxel_grid.hpp"

namespace swiftlet {

enum class CellState : std::uint8_t { kUnknown, kFree, kOccupied };

/// First intersection of a segment with an occupied cell.
struct SegmentHit {
  double distance_m = 0.0;  ///< from the start of the segment to the cell
  Vector3 center_local_m = Vector3::Zero();
};

/// Earlier than any hit: selects all occupied cells.
inline constexpr TimeNs kEver = std::numeric_limits<TimeNs>::min();

/// Query interface of a vehicle's occupancy map, as of now, in the local frame. A light view; never copied.
class OccupancyView {
 public:
  virtual ~OccupancyView() = default;
  virtual double edge_m() const = 0;
  virtual CellState state(const Vector3& p_local_m) const = 0;
  /// Centers of the occupied cells whose nearest point lies in the ball, except those without a hit since `since`.
  virtual void occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                               std::vector<Vector3>& centers_local_m) const = 0;
  /// Centers of the occupied cells that overlap the box.
  virtual void occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                           std::vector<Vector3>& centers_local_m) const = 0;
  /// Distance to the nearest point of an occupied cell; at most `max_m`.
  virtual double distance_m(const Vector3& p_local_m, double max_m) const = 0;
  /// Distance from the center of the point's cell to the nearest center of an occupied cell, exact; at most `max_m`.
  virtual double clearance_m(const Vector3& p_local_m, double max_m) const;
  /// First occupied cell on the segment, including that of its start.
  virtual std::optional<SegmentHit> first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const = 0;
  /// Revision of the map; increases with every possible change.
  virtual std::uint64_t revision() const = 0;
  /// Appends boxes of cells that contain all state changes since that revision; false when they are not known.
  virtual bool changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const = 0;
  /// Appends a copy of the map for recorders and renderers, without its name.
  virtual void append_voxels(MapVoxels& /*copy*/) const {}
};

}  // namespace swiftlet
