// SPDX-License-Identifier: BSD-3-Clause
#include "detection_histories.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <optional>

namespace swiftlet::tools {

std::vector<Judged> judged_sightings(const std::vector<Sighting>& sightings, double farthest_m) {
  std::vector<Judged> all;
  std::map<int, int> since_return;  // scans since the last return of each target
  for (const Sighting& s : sightings) {
    int& since = since_return.try_emplace(s.target, kWindows_scans.back()).first->second;
    since = s.points > 0 ? 0 : since + 1;
    if (!s.visible || s.range_m >= farthest_m) continue;
    Judged& j = all.emplace_back();
    j.range_m = s.range_m;
    for (std::size_t w = 0; w < kWindows_scans.size(); ++w) j.returned[w] = since < kWindows_scans[w];
    j.found = s.found;
    j.error_m = s.error_m;
  }
  return all;
}

Histories histories_of(const std::vector<Sighting>& tracks) {
  struct OfTarget {
    std::uint32_t last = 0;              // track identity
    std::optional<std::size_t> waiting;  // index of the appearance until the target is found
  };
  Histories histories;
  std::map<int, OfTarget> targets;
  for (const Sighting& s : tracks) {
    OfTarget& of = targets[s.target];
    if (!s.visible) of.waiting.reset();
    if (s.visible && s.in_view_s == 0.0) {
      of.waiting = histories.appearances.size();
      histories.appearances.push_back({s.target, s.range_m, std::numeric_limits<double>::infinity()});
    }
    if (!s.found) continue;
    if (of.waiting) histories.appearances[*of.waiting].until_found_s = s.in_view_s;
    of.waiting.reset();
    if (s.track == 0) continue;
    if (of.last != 0 && of.last != s.track) ++histories.switches;
    of.last = s.track;
  }
  return histories;
}

}  // namespace swiftlet::tools
