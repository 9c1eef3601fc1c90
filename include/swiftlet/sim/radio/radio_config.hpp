// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/config.hpp"

namespace swiftlet::sim {

/// One shared channel between all vehicles.
struct RadioConfig {
  double rate_kbps = 6000.0;      ///< of each sender; a message occupies it for size / rate
  double delay_s = 0.005;         ///< fixed part of the delay
  double jitter_s = 0.002;        ///< standard deviation of the random part (its absolute value is added)
  double loss_probability = 0.0;  ///< of any message to any receiver
  double range_m = 100.0;         ///< no reception beyond
  bool line_of_sight = false;     ///< does the world block it?
  double queue_limit_kB = 64.0;   ///< a sender's waiting messages beyond this are dropped, oldest first

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
