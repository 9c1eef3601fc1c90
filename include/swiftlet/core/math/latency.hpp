// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/time.hpp"

namespace swiftlet {

/// Processing time on board: a configured number, so that results do not depend on the speed of the machine.
class Latency {
 public:
  explicit Latency(double latency_s) : length_(from_seconds(latency_s)) {}
  /// True when work that began at `start` is finished.
  bool is_over(TimeNs start, TimeNs now) const { return now >= start + length_; }

 private:
  TimeNs length_;
};

/// A part of a stage with one job at a time: idle, or busy until its latency is over.
class Worker {
 public:
  explicit Worker(double latency_s) : latency_(latency_s) {}
  bool idle() const { return !busy_; }
  bool due(TimeNs now) const { return busy_ && latency_.is_over(start_, now); }
  void start(TimeNs now) {
    busy_ = true;
    start_ = now;
  }
  void stop() { busy_ = false; }

 private:
  Latency latency_;
  TimeNs start_ = 0;
  bool busy_ = false;
};

}  // namespace swiftlet
