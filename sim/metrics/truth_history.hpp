// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

#include "swiftlet/sim/recording/tick_view.hpp"

namespace swiftlet::sim {

/// Values of the last 2048 ticks, by time: 8 s at ticks of 4 ms.
template <class Value>
class RecentValues {
 public:
  RecentValues() : ring_(kCapacity) {}
  void push(TimeNs t, const Value& value) {
    if (count_ < kCapacity)
      ++count_;
    else
      first_ = (first_ + 1) % kCapacity;
    at(count_ - 1) = {t, value};
  }
  bool empty() const { return count_ == 0; }
  /// Index of the last value at or before t; the oldest when there is none.
  std::size_t before(TimeNs t) const {
    std::size_t low = 0, high = count_;  // the first one after t lies in [low, high]
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      if (time(middle) <= t)
        low = middle + 1;
      else
        high = middle;
    }
    return low == 0 ? 0 : low - 1;
  }
  std::size_t size() const { return count_; }
  TimeNs time(std::size_t i) const { return ring_[(first_ + i) % kCapacity].first; }
  const Value& value(std::size_t i) const { return ring_[(first_ + i) % kCapacity].second; }

 private:
  /// [samples] Length of the ring.
  static constexpr std::size_t kCapacity = 2048;
  std::pair<TimeNs, Value>& at(std::size_t i) { return ring_[(first_ + i) % kCapacity]; }

  std::vector<std::pair<TimeNs, Value>> ring_;
  std::size_t first_ = 0, count_ = 0;
};

/// Position and velocity. Any frame, the same for all arguments.
struct PointMotion {
  Vector3 p_m = Vector3::Zero(), v_mps = Vector3::Zero();
};

/// Position and velocity at t, linear between ticks, constant outside of the stored interval.
inline PointMotion interpolate(const RecentValues<PointMotion>& values, TimeNs t) {
  const std::size_t i = values.before(t), j = std::min(i + 1, values.size() - 1);
  const PointMotion &a = values.value(i), &b = values.value(j);
  if (j == i || t <= values.time(i)) return a;
  const double f = static_cast<double>(t - values.time(i)) / static_cast<double>(values.time(j) - values.time(i));
  return {a.p_m + f * (b.p_m - a.p_m), a.v_mps + f * (b.v_mps - a.v_mps)};
}

}  // namespace swiftlet::sim
