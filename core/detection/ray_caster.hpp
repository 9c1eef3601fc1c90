// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/detection/empty_directions.hpp"
#include "swiftlet/core/detection/vofod_config.hpp"
#include "swiftlet/core/localization/local_cloud.hpp"
#include "swiftlet/core/map/ray_lengths.hpp"

namespace swiftlet {

/// Casts the rays of a scan through the voxel map of VoFOD [Vrba 2025, sec. III-C]. Beams without return clear the
/// voxels up to ray_max_m. When the driver does not report their directions, EmptyDirections estimates them.
class RayCaster {
 public:
  explicit RayCaster(const VofodConfig& config);

  /// Sums the lengths of the scan's rays in each voxel, for the next apply().
  void cast(const LocalCloud& cloud, const VoxelGrid& map);
  /// Updates the voxels by their summed ray lengths [Vrba 2025, eq. 22].
  /// @param num_classifications  N_cls: number of classifications of the map since the rays were cast
  void apply(int num_classifications, VoxelMap& map);

  /// Sine of the elevation of the upper edge of the field of view, when the driver reports no directions of beams
  /// without return; 2 (no limit) otherwise.
  double top_z() const { return empty_.top_z(); }

 private:
  /// Starts the sums of a scan. False when its rays start outside of the map or have no finite pose.
  bool begin(const LocalCloud& cloud, const VoxelGrid& map);
  void add(const Pose& T_local_lidar, const Eigen::Vector3f& origin_lidar_m, const Eigen::Vector3f& direction_lidar,
           double length_m);

  bool is_scrolling_;
  double ray_max_m_, ray_weight_, voxel_m_;
  EmptyDirections empty_;
  RayLengths lengths_;
};

}  // namespace swiftlet
