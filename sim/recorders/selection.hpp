// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/core/frames.hpp"

namespace swiftlet::sim {

/// Which vehicles a recorder writes, as flags by VehicleId. No names: all of them.
/// Throws InputError on a name that no vehicle has.
std::vector<bool> select_vehicles(const std::vector<std::string>& wanted, const std::vector<std::string>& names);

/// Is `word` in the list? An empty list holds every word.
bool selects(const std::vector<std::string>& wanted, const std::string& word);

/// True in the first tick at or after every multiple of the period; a rate of 0 takes every tick.
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
