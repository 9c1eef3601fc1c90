// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/slam/matching/hybrid_grid.hpp"
#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/slam/grid_matching_config.hpp"

namespace swiftlet {

/// Several successive scans in two resolutions. The grids have the axes of the local frame, and their own origin in it:
/// the vehicle's position at their beginning.
struct GridSubmap {
  explicit GridSubmap(const GridSubmapConfig& config) : high(config.high_resolution_m), low(config.low_resolution_m) {}

  Vector3 origin_local_m = Vector3::Zero();
  HybridGrid high, low;
  int num_scans = 0;
};

/// Two submaps at a time receive every scan. When the newer one has its number of scans, the older one has twice as
/// many and is discarded, and another begins.
class GridSubmaps {
 public:
  explicit GridSubmaps(const GridSubmapConfig& config);

  bool empty() const { return num_active_ == 0; }
  int num_active() const { return num_active_; }
  /// Submap for scan matching. Requires a non-empty set.
  const GridSubmap& older() const { return submaps_[older_]; }
  /// Equal to older() while there is only one.
  const GridSubmap& newer() const { return submaps_[num_active_ == 2 ? 1 - older_ : older_]; }

  void insert(std::span<const Vector3> points_local_m, const Vector3& origin_local_m);
  void clear();
  std::size_t bytes() const;

 private:
  void begin(GridSubmap& submap, const Vector3& origin_local_m);
  void insert(GridSubmap& submap, std::span<const Vector3> points_local_m, const Vector3& origin_local_m);

  GridSubmapConfig config_;
  OddsTable hit_, miss_;
  std::vector<GridSubmap> submaps_;  // two that alternate
  int older_ = 0, num_active_ = 0;
  std::vector<Vector3> all_m_, near_m_;  // points of one scan, in a submap's frame
};

}  // namespace swiftlet
