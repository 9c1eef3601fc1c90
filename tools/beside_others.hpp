// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "swiftlet/sim/scenario/scenario.hpp"

/// Speed beside other work, as ratios within one run: whatever else the machine does hits both sides alike.
namespace swiftlet::tools {

struct BesideOthers {
  int threads = 1;  ///< or worker processes
  int others = 0;   ///< busy processes beside them, as many
  /// Speed with all threads over the speed with one.
  double times_one_thread = 0.0;
  /// What was done, counted in processor time of one thread that does it alone, over the threads' part of the processor
  /// time that they and the others got together.
  double share_kept = 0.0;
};

using TellProgress = std::function<void(double done)>;

/// Two copies of the scenario, one with a single thread, take turns of `turn_s` of simulated time.
BesideOthers fly_beside_others(const sim::Scenario& scenario, double turn_s, int threads, const TellProgress& tell);

/// `swiftlet batch` with one worker and with several takes turns.
BesideOthers fly_batch_beside_others(int workers, const TellProgress& tell);

}  // namespace swiftlet::tools
