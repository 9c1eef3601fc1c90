// SPDX-License-Identifier: BSD-3-Clause
#include "core/detection/ray_caster.hpp"

#include <algorithm>
#include <cmath>

#include "core/detection/direction_bins.hpp"
#include "swiftlet/core/base/rounding.hpp"

namespace swiftlet {

RayCaster::RayCaster(const VofodConfig& config)
    : is_scrolling_(config.map.extent == VoxelMapConfig::Extent::kScrolling),
      ray_max_m_(config.ray_max_m),
      ray_weight_(config.ray_weight),
      voxel_m_(config.map.voxel_m),
      empty_(config.field_of_view) {}

void RayCaster::cast(const LocalCloud& cloud, const VoxelGrid& map) {
  if (!begin(cloud, map)) return;
  const Scan& scan = *cloud.scan;
  const BeamTable& beams = *scan.beams;
  const bool has_mask = !beams.masked.empty();
  for (int row = 0; row < scan.rows(); ++row) {
    for (int column = 0; column < scan.cols(); ++column) {
      const int i = row * scan.cols() + column;
      if (has_mask && beams.masked[i]) continue;
      double length_m = ray_max_m_;
      if (scan.hit(i))
        length_m = std::min(length_m, static_cast<double>(scan.range_m[i]));
      else if (!(scan.range_m[i] == 0.0F))  // invalid range
        continue;
      add(cloud.T_local_lidar[column], beams.origins_lidar[i], beams.directions_lidar[i], length_m);
    }
  }
  const Pose& T_middle = cloud.T_local_lidar[scan.cols() / 2];
  for (const Eigen::Vector3f& direction_lidar : empty_.find(scan)) {
    add(T_middle, Eigen::Vector3f::Zero(), direction_lidar, ray_max_m_);
  }
}

bool RayCaster::begin(const LocalCloud& cloud, const VoxelGrid& map) {
  double beam_offset_m = 0.0;  // largest distance of a beam's origin from the sensor's
  for (const Eigen::Vector3f& origin : cloud.scan->beams->origins_lidar) {
    if (origin.allFinite()) beam_offset_m = std::max(beam_offset_m, static_cast<double>(origin.norm()));
  }
  Eigen::AlignedBox3d origins;
  for (const Pose& pose : cloud.T_local_lidar) {
    if (pose.matrix().allFinite()) origins.extend(Vector3(pose.translation()));
  }
  if (origins.isEmpty() || !map.contains(Vector3(origins.center()))) {
    lengths_.begin({}, ray_max_m_, voxel_m_);
    return false;
  }
  // The margin keeps rounding from leaving an origin outside.
  origins.min().array() -= beam_offset_m + kRounding;
  origins.max().array() += beam_offset_m + kRounding;
  // The map may scroll by up to kRayScroll_voxels before apply().
  VoxelGrid within = map;
  if (is_scrolling_) {
    within.min_cell.array() -= kRayScroll_voxels;
    within.size.array() += 2 * kRayScroll_voxels;
  }
  lengths_.begin(origins, ray_max_m_, voxel_m_, &within);
  return true;
}

void RayCaster::add(const Pose& T_local_lidar, const Eigen::Vector3f& origin_lidar_m,
                    const Eigen::Vector3f& direction_lidar, double length_m) {
  lengths_.add(T_local_lidar * origin_lidar_m.cast<double>(), T_local_lidar.linear() * direction_lidar.cast<double>(),
               length_m);
}

void RayCaster::apply(int num_classifications, VoxelMap& map) {
  // A ray along the diagonal of a voxel, the longest possible, counts N_cls * ray_weight updates.
  lengths_.apply(num_classifications * ray_weight_ / std::sqrt(3.0), map);
}

}  // namespace swiftlet
