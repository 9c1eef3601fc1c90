// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet {

/// Predicted path: positions at equal intervals, joined by straight lines. The last velocity continues beyond the end.
struct PathAhead {
  /// [-] Most positions of a path; limits the size of reports.
  static constexpr int kMaxPlaces = 13;
  std::array<Vector3, kMaxPlaces> places_local_m;
  int num_places = 0;
  double interval_s = 0.25;

  Vector3 at(double t_s) const {
    const int i = leg(t_s);
    return places_local_m[static_cast<std::size_t>(i)] + (t_s - i * interval_s) * velocity_mps(t_s);
  }
  Vector3 velocity_mps(double t_s) const {
    if (num_places < 2) return Vector3::Zero();
    const auto i = static_cast<std::size_t>(leg(t_s));
    return (places_local_m[i + 1] - places_local_m[i]) / interval_s;
  }

 private:
  int leg(double t_s) const {
    return static_cast<int>(std::clamp(t_s / interval_s, 0.0, static_cast<double>(std::max(0, num_places - 2))));
  }
};

}  // namespace swiftlet
