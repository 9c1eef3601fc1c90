// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "swiftlet/core/base/scan.hpp"
#include "swiftlet/core/detection/field_of_view.hpp"

namespace swiftlet {

/// Directions in which a scan of points alone met nothing. Its driver reports no direction for a shot without return,
/// so the beams that clear free air are unknown. A LiDAR scans all of its field of view: a direction inside it is empty
/// when nothing around it returned in the last sweeps.
class EmptyDirections {
 public:
  explicit EmptyDirections(const FieldOfView& view);

  /// Unit vectors in the frame of the LiDAR, at most one for each bin, each sweep at another place within its bin. None
  /// for a scan in which a beam without return has a direction. Valid until the next call.
  std::span<const Eigen::Vector3f> find(const Scan& scan);

  /// Sine of the elevation of the upper edge of the field of view; 2 if the last scan had known directions.
  double top_z() const { return is_needed_ ? top_z_ : 2.0; }

 private:
  static constexpr int kTurns = 320, kRows = 128;  // bins in azimuth, and in height from nadir to zenith

  void take_returns(const Scan& scan);
  bool is_in_view(const Eigen::Vector3f& direction_lidar, int turn) const;
  bool is_quiet(int row, int turn) const;

  bool learns_, is_needed_ = false;
  float bottom_z_ = 1.0F, top_z_ = -1.0F, least_x_ = -1.0F;  // field of view: heights, and cosine of half its width
  std::vector<bool> turn_seen_;                              // azimuth bins that returned once; all if not learned
  std::uint32_t sweep_ = 0;
  std::vector<std::uint32_t> returned_in_;  // number of the last sweep with a return, by bin
  std::vector<Eigen::Vector3f> empty_;
};

}  // namespace swiftlet
