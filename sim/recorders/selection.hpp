// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/core/base/frames.hpp"

namespace swiftlet::sim {

/// Vehicles that a recorder writes, as flags by VehicleId. Empty `wanted`: all.
/// Throws InputError on a name that no vehicle has.
std::vector<bool> select_vehicles(const std::vector<std::string>& wanted, const std::vector<std::string>& names);

/// True if `word` is in the list. An empty list contains every word.
bool selects(const std::vector<std::string>& wanted, const std::string& word);

/// True in the first tick at or after every multiple of the period; a rate of 0 selects every tick.
class RateGate {
 public:
  explicit RateGate(double rate_hz = 0.0) : period_(rate_hz > 0.0 ? from_seconds(1.0 / rate_hz) : 0) {}
  bool due(TimeNs t) {
    if (period_ <= 0) return true;
    if (t < next_) return false;
    next_ = (t / period_ + 1) * period_;
    return true;
  }

 private:
  TimeNs period_;
  TimeNs next_ = 0;
};

}  // namespace swiftlet::sim
