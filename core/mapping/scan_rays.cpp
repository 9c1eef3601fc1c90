// SPDX-License-Identifier: BSD-3-Clause
#include "core/mapping/scan_rays.hpp"

#include <algorithm>

namespace swiftlet {

std::vector<OccupancyMap::Ray>& ScanRays::take(const LocalCloud& cloud, const MapperInput& input) {
  const Scan& scan = *cloud.scan;
  rays_.clear();
  returned_.assign(static_cast<std::size_t>(scan.size()), false);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const int beam = static_cast<int>(cloud.beam[i]);
    returned_[beam] = true;
    if (!chosen(beam, scan.cols()) || is_vehicle(cloud, i, input)) continue;
    const Eigen::Vector3f origin_local_m = cloud.T_local_lidar_of_beam(beam).translation().cast<float>();
    const float range_m = (cloud.points_local_m[i] - origin_local_m).norm();
    if (range_m < rules_.range_min_m) continue;
    ++num_returns_;
    if (range_m > rules_.range_max_m) ++num_far_;  // the map is cleared on the way, but not hit
    rays_.push_back({origin_local_m, cloud.points_local_m[i], true});
  }
  if (rules_.clear_range_m > 0.0) take_without_return(cloud);
  return rays_;
}

/// Beams without return tell that nothing is near; the own body's beams have a return or a mask.
void ScanRays::take_without_return(const LocalCloud& cloud) {
  const Scan& scan = *cloud.scan;
  const auto far_m = static_cast<float>(rules_.clear_range_m);
  for (int beam = 0; beam < scan.size(); ++beam) {
    if (!chosen(beam, scan.cols()) || returned_[beam] || scan.hit(beam)) continue;
    if (!scan.beams->masked.empty() && scan.beams->masked[beam] != 0) continue;
    const Pose& T = cloud.T_local_lidar_of_beam(beam);
    const Vector3 direction = T.linear() * scan.beams->directions_lidar[beam].cast<double>();
    const Eigen::Vector3f origin_local_m = T.translation().cast<float>();
    rays_.push_back({origin_local_m, origin_local_m + far_m * direction.cast<float>(), false});
  }
}

/// Does the point lie near where a tracked vehicle, or a member of the team, was when it was measured?
bool ScanRays::is_vehicle(const LocalCloud& cloud, std::size_t point, const MapperInput& input) const {
  if (input.tracks.empty() && input.relatives.empty()) return false;
  const TimeNs t = cloud.time_of(point);
  const Vector3 p_local_m = cloud.points_local_m[point].cast<double>();
  const auto is_near = [&](const auto& vehicle) {
    const Vector3 then_local_m = vehicle.position_m + to_seconds(t - vehicle.t) * vehicle.velocity_mps;
    return (p_local_m - then_local_m).squaredNorm() < rules_.tracked_radius_m * rules_.tracked_radius_m;
  };
  return std::ranges::any_of(input.tracks, is_near) || std::ranges::any_of(input.relatives, is_near);
}

}  // namespace swiftlet
