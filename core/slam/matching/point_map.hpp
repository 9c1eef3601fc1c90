// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/slam/cell_keys.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Points of the map, a limited number in each voxel [Vizzo 2023, sec. III-C]. A scan whose predicted pose is poor
/// finds the nearest map points up to a voxel away; the planes of SurfaceMap attract only points within their own
/// cells.
class PointMap {
 public:
  /// [m] Edge of a voxel. Larger ones find more distant points and cost time.
  static constexpr double kVoxel_m = 1.0;

  bool empty() const { return voxels_.empty(); }
  void clear();
  void insert(std::span<const Vector3> points_local_m);
  /// Removes voxels farther than radius_m from a position.
  void keep_around(const Vector3& center_local_m, double radius_m);
  /// Nearest point in the voxel of a position and in its 26 neighbors; nullptr if none is nearer than within_m.
  const Eigen::Vector3f* nearest(const Vector3& p_local_m, double within_m) const;
  std::size_t bytes() const { return voxels_.capacity() * sizeof(Voxel) + table_.bytes(); }

 private:
  /// [-] Largest number of points of a voxel. More of them cost time.
  static constexpr int kCapacity = 20;
  struct Voxel {
    int count = 0;
    std::array<Eigen::Vector3f, kCapacity> points_local_m;
  };
  KeyTable table_;
  std::vector<Voxel> voxels_;  // indexed by the number of the key
};

/// Pose at which a scan lies nearest to the points of the map: iterative closest points with the kernel of Geman and
/// McClure [Vizzo 2023, sec. III-D]; empty if too few points have a neighbor in the map.
/// @param width_m  scale of the kernel: a pair at this distance has a weight of 1/4. Pairs beyond 3 width_m, or beyond
///                 the reach of PointMap::nearest(), are ignored.
std::optional<Pose> align_points(const PointMap& map, std::span<const Eigen::Vector3f> points_body_m,
                                 const Pose& T_local_body_guess, double width_m);

}  // namespace swiftlet
