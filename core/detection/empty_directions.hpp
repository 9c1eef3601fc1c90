// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/base/scan.hpp"
#include "swiftlet/core/detection/field_of_view.hpp"

namespace swiftlet {

/// Directions without return in a scan whose driver reports points only. Such a driver reports no direction for a shot
/// without return, so the beams that clear free air are unknown. A LiDAR scans all of its field of view: a direction in
/// the field of view is empty when no direction around it returned in the last sweeps.
class EmptyDirections {
 public:
  explicit EmptyDirections(const FieldOfView& view);

  /// Unit vectors in the frame of the LiDAR, at most one for each bin; their positions within the bins change from
  /// sweep to sweep. None for a scan whose beams without return have directions. Valid until the next call.
  std::span<const Eigen::Vector3f> find(const Scan& scan);

  /// Sine of the elevation of the upper edge of the field of view; 2 if the last scan had known directions.
  double top_z() const { return is_needed_ ? top_z_ : 2.0; }

 private:
  static constexpr int kAzimuths = 320, kRows = 128;  // bins in azimuth, and in sine of elevation from nadir to zenith

  void take_returns(const Scan& scan);
  bool is_in_view(const Eigen::Vector3f& direction_lidar, int turn) const;
  bool is_quiet(int row, int turn) const;

  bool learns_, is_needed_ = false;
  // Field of view: sines of the lowest and of the highest elevation, and cosine of half its width.
  float bottom_z_ = 1.0F, top_z_ = -1.0F, least_x_ = -1.0F;
  std::vector<bool> turn_seen_;  // azimuth bins that have had a return; all of them if the field of view is configured
  std::uint32_t sweep_ = 0;
  std::vector<std::uint32_t> returned_in_;  // number of the last sweep with a return, by bin
  std::vector<Eigen::Vector3f> empty_;
};

}  // namespace swiftlet
