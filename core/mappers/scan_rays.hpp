// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/mappers/vehicles_around.hpp"
#include "swiftlet/core/map/occupancy_map.hpp"

namespace swiftlet {

/// Selection of the beams of a scan that update a map.
struct ScanRaysRules {
  int every_column = 1;
  double range_min_m = 0.0;    ///< nearer returns are from the own body
  double range_max_m = 0.0;    ///< farther returns only clear
  double clear_range_m = 0.0;  ///< beams without return clear up to here; 0: they are ignored
};

/// Rays of scans, without returns from other vehicles.
class ScanRays {
 public:
  explicit ScanRays(const ScanRaysRules& rules) : rules_(rules) {}

  /// Rays of a scan, valid until the next call.
  std::vector<OccupancyMap::Ray>& take(const LocalCloud& cloud, const VehiclesAround& vehicles);
  void append_counters(std::vector<Counter>& counters) const {
    counters.push_back({"returns beyond the range of the map", num_far_, num_returns_, "range_max_m"});
  }

 private:
  bool chosen(int beam, int cols) const { return beam % cols % rules_.every_column == 0; }
  void take_without_return(const LocalCloud& cloud);

  ScanRaysRules rules_;
  std::vector<OccupancyMap::Ray> rays_;
  std::vector<bool> returned_;  // per beam
  std::uint64_t num_returns_ = 0, num_far_ = 0;
};

}  // namespace swiftlet
