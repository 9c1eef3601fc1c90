// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// Model of the radio between all vehicles.
struct RadioConfig {
  double rate_kbps = 6000.0;      ///< transmission rate of each sender; a message occupies the sender for size / rate
  double delay_s = 0.005;         ///< fixed part of the delay
  double jitter_s = 0.002;        ///< standard deviation of the random part (its absolute value is added)
  double loss_probability = 0.0;  ///< probability that a receiver loses a message
  double range_m = 100.0;         ///< no reception beyond
  bool line_of_sight = false;     ///< blocked by surfaces of the static world
  double queue_limit_kB = 64.0;   ///< transmission queue of a sender; beyond it the oldest messages are dropped

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
