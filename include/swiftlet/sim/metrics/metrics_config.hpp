// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/config.hpp"

namespace swiftlet::sim {

/// What is measured, and when the run ends.
struct MetricsConfig {
  double clearance_max_m = 20.0;    ///< distances beyond are reported as this
  bool stop_on_crash = false;       ///< end the run at the first crash
  bool stop_when_done = true;       ///< end the run when every mission is done, failed or crashed
  double true_positive_m = 3.0;     ///< a detection or track nearer than this to a vehicle is that vehicle's
  double detection_range_m = 20.0;  ///< vehicles nearer than this count for recall
  double detection_bin_m = 5.0;     ///< of the results over distance

  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet::sim
