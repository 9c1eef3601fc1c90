// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "detection_log.hpp"

/// Sightings of a flight in temporal order, for each target separately.
namespace swiftlet::tools {

inline constexpr std::array<int, 4> kWindows_scans = {1, 3, 5, 10};  ///< at 10 Hz: up to a second

/// A target that could be seen in a scan.
struct Judged {
  double range_m = 0.0;
  /// Whether it has a return in the last 1, 3, 5 and 10 scans, this one included: the ceiling of any detector.
  std::array<bool, kWindows_scans.size()> returned{};
  bool found = false;
  double error_m = 0.0;
};
/// Sightings in view and nearer than `farthest_m`, in their order.
std::vector<Judged> judged_sightings(const std::vector<Sighting>& sightings, double farthest_m);

/// One time that a target comes into view.
struct Appearance {
  int target = 0;
  double range_m = 0.0;        ///< distance at that moment
  double until_found_s = 0.0;  ///< infinite when it leaves the view before
};
struct Histories {
  std::vector<Appearance> appearances;
  int switches = 0;  ///< how often the track identity of a target changes
};
/// @param tracks  DetectionLog::tracks()
Histories histories_of(const std::vector<Sighting>& tracks);

}  // namespace swiftlet::tools
