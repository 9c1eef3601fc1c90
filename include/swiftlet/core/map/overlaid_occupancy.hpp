// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/map/occupancy_view.hpp"

namespace swiftlet {

/// Keep-out volume that is not in the map, such as another vehicle with its downwash, or a geofence.
struct KeepOut {
  enum class Shape { kBox, kColumn };
  Shape shape = Shape::kBox;
  Vector3 center_local_m = Vector3::Zero();
  Vector3 size_m = Vector3::Zero();  ///< edges of the box; diameter (x) and height (z) of an upright column

  static KeepOut box(const Vector3& center_local_m, const Vector3& size_m) {
    return {Shape::kBox, center_local_m, size_m};
  }
  static KeepOut column(const Vector3& center_local_m, double diameter_m, double height_m) {
    return {Shape::kColumn, center_local_m, {diameter_m, diameter_m, height_m}};
  }

  /// Distance [m] from a position to the surface of the volume; 0 inside.
  double distance_m(const Vector3& p_local_m) const;
  bool contains(const Vector3& p_local_m) const { return distance_m(p_local_m) <= 0.0; }
  /// Distance [m] along a segment from its start to its entry into the volume; 0 for a start inside, empty without
  /// entry.
  std::optional<double> entered_after_m(const Vector3& from_local_m, const Vector3& to_local_m) const;
};

/// View of a map with keep-out volumes, without a copy. A cell is also occupied when its center lies in a keep-out
/// volume. Distances to a keep-out volume are exact, not to the centers of cells. The underlying map must outlive the
/// view.
class OverlaidOccupancy : public OccupancyView {
 public:
  OverlaidOccupancy(const OccupancyView& map, std::vector<KeepOut> keep_outs)
      : map_(map), keep_outs_(std::move(keep_outs)) {}

  double edge_m() const override { return map_.edge_m(); }
  CellState state(const Vector3& p_local_m) const override;
  void occupied_within(const Vector3& center_local_m, double radius_m, TimeNs since,
                       std::vector<Vector3>& centers_local_m) const override;
  void occupied_in(const Vector3& min_local_m, const Vector3& max_local_m,
                   std::vector<Vector3>& centers_local_m) const override;
  double distance_m(const Vector3& p_local_m, double max_m) const override;
  double clearance_m(const Vector3& p_local_m, double max_m) const override;
  std::optional<SegmentHit> first_hit(const Vector3& from_local_m, const Vector3& to_local_m) const override;
  std::uint64_t revision() const override { return map_.revision(); }
  bool changed_since(std::uint64_t revision, std::vector<VoxelGrid>& boxes) const override {
    return map_.changed_since(revision, boxes);
  }
  void append_voxels(MapVoxels& copy) const override { map_.append_voxels(copy); }

 private:
  Vector3 center_of_cell(const Vector3& p_local_m) const {
    return ((p_local_m.array() / edge_m()).floor() + 0.5) * edge_m();
  }
  /// Centers of cells of keep-out volumes that overlap the box and are not occupied in the underlying map.
  template <class Accept>
  void append_cells(const Vector3& min_local_m, const Vector3& max_local_m, std::vector<Vector3>& centers_local_m,
                    Accept&& accept) const;

  const OccupancyView& map_;
  std::vector<KeepOut> keep_outs_;
};

}  // namespace swiftlet
