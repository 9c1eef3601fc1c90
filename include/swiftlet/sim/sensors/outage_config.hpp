// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/time.hpp"

namespace swiftlet::sim {

/// A time without data of a sensor: [start_s, end_s).
struct OutageConfig {
  double start_s = 0.0;
  double end_s = 0.0;

  bool contains(TimeNs t) const { return t >= from_seconds(start_s) && t < from_seconds(end_s); }
  void visit(ConfigVisitor& v) {
    v.field("start_s", start_s, "[s] first instant without data", Range::non_negative());
    v.field("end_s", end_s, "[s] first instant with data again", Range::non_negative());
    v.check(end_s >= start_s, "end_s", "not before start_s");
  }
};

}  // namespace swiftlet::sim
