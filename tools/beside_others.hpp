// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "swiftlet/sim/scenario/scenario.hpp"

/// Speed beside other processes, as ratios within one run, so that other load on the machine affects both sides alike.
namespace swiftlet::tools {

struct BesideOthers {
  int threads = 1;  ///< threads or worker processes
  int others = 0;   ///< number of competing busy processes
  /// Speed with all threads over the speed with one.
  double times_one_thread = 0.0;
  /// Performed work, measured by the processor time that one thread alone needs for it, divided by the threads' fair
  /// share of the processor time used by them and the busy processes together.
  double share_kept = 0.0;
};

using ProgressCallback = std::function<void(double done)>;

/// Alternates two copies of the scenario in turns of `turn_s` of simulated time, one with a single thread, one with
/// all.
BesideOthers fly_beside_others(const sim::Scenario& scenario, double turn_s, int threads,
                               const ProgressCallback& report_progress);

/// Alternates turns of `swiftlet batch` with one worker and with several.
BesideOthers fly_batch_beside_others(int workers, const ProgressCallback& report_progress);

}  // namespace swiftlet::tools
