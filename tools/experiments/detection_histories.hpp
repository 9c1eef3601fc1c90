// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "detection_log.hpp"

/// What the sightings of a flight tell in the order of time, of each target by itself.
namespace swiftlet::tools {

inline constexpr std::array<int, 4> kWindows_scans = {1, 3, 5, 10};  ///< at 10 Hz: up to a second

/// A target that could be seen in a scan.
struct Judged {
  double range_m = 0.0;
  /// Whether it returned anything in the last 1, 3, 5 and 10 scans, this one included: no detector can know more.
  std::array<bool, kWindows_scans.size()> returned{};
  bool found = false;
  double error_m = 0.0;
};
/// Those sightings that were in view and nearer than this, in their order.
std::vector<Judged> judged_sightings(const std::vector<Sighting>& sightings, double farthest_m);

/// A target comes into view.
struct Appearance {
  int target = 0;
  double range_m = 0.0;        ///< where it did
  double until_found_s = 0.0;  ///< infinite when it left again before that
};
struct Histories {
  std::vector<Appearance> appearances;
  int switches = 0;  ///< how often another identity went on with a target
};
/// @param tracks  DetectionLog::tracks()
Histories histories_of(const std::vector<Sighting>& tracks);

}  // namespace swiftlet::tools
