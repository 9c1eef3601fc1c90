// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

/// Operations on paths of straight legs. Any frame, the same for all arguments.
namespace swiftlet {

/// Joins each corner with the farthest one that a free segment reaches, found by doubling.
/// @param is_free  (a, b): whether the segment from a to b is free
template <class IsFree>
std::vector<Vector3> cut_corners(const std::vector<Vector3>& path_m, IsFree&& is_free) {
  std::vector<Vector3> corners_m = {path_m.front()};
  for (std::size_t i = 0; i + 1 < path_m.size();) {
    std::size_t reach = i + 1;
    for (std::size_t step = 1; reach + step < path_m.size() && is_free(path_m[i], path_m[reach + step]); step *= 2) {
      reach += step;
    }
    while (reach + 1 < path_m.size() && is_free(path_m[i], path_m[reach + 1])) ++reach;
    corners_m.push_back(path_m[reach]);
    i = reach;
  }
  return corners_m;
}

/// Adds evenly spaced points to each leg, at most `spacing_m` apart.
inline std::vector<Vector3> with_points_between(const std::vector<Vector3>& corners_m, double spacing_m) {
  std::vector<Vector3> points_m = {corners_m.front()};
  for (std::size_t i = 1; i < corners_m.size(); ++i) {
    const Vector3 leg = corners_m[i] - corners_m[i - 1];
    const int parts = std::max(1, static_cast<int>(std::ceil(leg.norm() / spacing_m)));
    for (int k = 1; k < parts; ++k) points_m.push_back(corners_m[i - 1] + leg * (static_cast<double>(k) / parts));
    points_m.push_back(corners_m[i]);
  }
  return points_m;
}

}  // namespace swiftlet
