// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Predicted path of a vehicle: positions at equal intervals, joined by straight segments with constant velocity. The
/// last velocity continues beyond the end.
struct PathAhead {
  /// [-] Largest number of positions of a path. Larger values predict farther ahead, but make reports longer.
  static constexpr int kMaxPlaces = 13;
  std::array<Vector3, kMaxPlaces> places_local_m;
  int num_places = 0;        ///< used positions
  double interval_s = 0.25;  ///< between positions

  /// Position, t_s after the first one.
  Vector3 at(double t_s) const {
    const int i = segment(t_s);
    return places_local_m[static_cast<std::size_t>(i)] + (t_s - i * interval_s) * velocity_mps(t_s);
  }
  Vector3 velocity_mps(double t_s) const {
    if (num_places < 2) return Vector3::Zero();
    const auto i = static_cast<std::size_t>(segment(t_s));
    return (places_local_m[i + 1] - places_local_m[i]) / interval_s;
  }

 private:
  int segment(double t_s) const {
    return static_cast<int>(std::clamp(t_s / interval_s, 0.0, static_cast<double>(std::max(0, num_places - 2))));
  }
};

}  // namespace swiftlet
