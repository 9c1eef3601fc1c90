// SPDX-License-Identifier: BSD-3-Clause
#include "core/mappers/scan_rays.hpp"

namespace swiftlet {

std::vector<OccupancyMap::Ray>& ScanRays::take(const LocalCloud& cloud, const VehiclesAround& vehicles) {
  const Scan& scan = *cloud.scan;
  rays_.clear();
  returned_.assign(static_cast<std::size_t>(scan.size()), false);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const int beam = static_cast<int>(cloud.beam[i]);
    returned_[beam] = true;
    if (!chosen(beam, scan.cols()) || vehicles.contains(cloud.points_local_m[i], cloud.time_of(i))) continue;
    const Eigen::Vector3f origin_local_m = cloud.T_local_lidar_of_beam(beam).translation().cast<float>();
    const float range_m = (cloud.points_local_m[i] - origin_local_m).norm();
    if (range_m < rules_.range_min_m) continue;
    ++num_returns_;
    if (range_m > rules_.range_max_m) ++num_far_;  // clears the cells before range_max_m, without a hit
    rays_.push_back({origin_local_m, cloud.points_local_m[i], true});
  }
  if (rules_.clear_range_m > 0.0) take_without_return(cloud);
  return rays_;
}

/// Adds clearing rays for beams without return: nothing is near along such beams. Beams that hit the own body have a
/// return or a mask.
void ScanRays::take_without_return(const LocalCloud& cloud) {
  const Scan& scan = *cloud.scan;
  const auto far_m = static_cast<float>(rules_.clear_range_m);
  for (int beam = 0; beam < scan.size(); ++beam) {
    if (!chosen(beam, scan.cols()) || returned_[beam] || scan.hit(beam)) continue;
    if (!scan.beams->masked.empty() && scan.beams->masked[beam] != 0) continue;
    if (scan.beams->directions_lidar[beam].isZero(0.0F)) continue;
    const Pose& T = cloud.T_local_lidar_of_beam(beam);
    const Vector3 direction = T.linear() * scan.beams->directions_lidar[beam].cast<double>();
    const Eigen::Vector3f origin_local_m = T.translation().cast<float>();
    rays_.push_back({origin_local_m, origin_local_m + far_m * direction.cast<float>(), false});
  }
}

}  // namespace swiftlet
