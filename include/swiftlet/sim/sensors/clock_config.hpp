// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// Clock of a sensor against the time of the simulation, on which the onboard software runs:
/// stamp = true time + offset_s + jitter_s * (standard normal). Stamps remain in order and are not negative.
/// A driver that stamps sweeps at their end has an offset of one sweep.
struct ClockConfig {
  double offset_s = 0.0;  ///< > 0: stamps are late
  double jitter_s = 0.0;  ///< standard deviation, white

  bool exact() const { return offset_s == 0.0 && jitter_s == 0.0; }
  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
