// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/slam/cell_keys.hpp"
#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Set of points with a test for near neighbors: true within one voxel edge along each axis, possibly up to three
/// edges, as the cells are two edges wide. Any frame, the same for all arguments.
class NearPoints {
 public:
  NearPoints(double voxel_m, std::span<const Eigen::Vector3f> points_m) : cells_per_m_(0.5 / voxel_m) {
    keys_.reserve(points_m.size());
    for (const Eigen::Vector3f& p_m : points_m) keys_.push_back(key_of((cells_per_m_ * p_m.cast<double>()).eval()));
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  }
  bool contain(const Vector3& p_m) const {
    const Vector3 low = (cells_per_m_ * p_m).array() - 0.5;  // lower of the two nearest cells per axis
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3 at = low + Vector3(corner & 1, corner >> 1 & 1, corner >> 2);
      if (std::binary_search(keys_.begin(), keys_.end(), key_of(at))) return true;
    }
    return false;
  }

 private:
  static std::uint64_t key_of(const Vector3& cells) {
    const auto index = [](double x) { return static_cast<std::int64_t>(std::floor(x)); };
    return cell_key(index(cells.x()), index(cells.y()), index(cells.z()));
  }

  double cells_per_m_;
  std::vector<std::uint64_t> keys_;
};

}  // namespace swiftlet
