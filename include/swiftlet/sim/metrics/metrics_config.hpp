// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// Settings of the metrics, and conditions that end the run.
struct MetricsConfig {
  /// [m] Clearances above this value are reported as this value. Larger values take longer to search.
  static constexpr double kClearanceMax_m = 20.0;

  bool stop_on_crash = false;  ///< end the run at the first crash
  bool stop_when_done = true;  ///< end the run when every mission is done, failed or crashed
  /// Largest distance between a detection or track and the vehicle that it is assigned to
  double true_positive_m = 3.0;
  double detection_range_m = 20.0;  ///< vehicles within this distance count for recall
  double detection_bin_m = 5.0;     ///< width of the distance intervals of the results

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
