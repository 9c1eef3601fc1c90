// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/config.hpp"

namespace swiftlet {

/// Source of neighbor positions.
struct NeighborSourceConfig {
  enum class Source { kSensor, kRadio, kTracks, kNone };
  Source source = Source::kSensor;
  double timeout_s = 10.0;
  double acceleration_sigma_mps2 = 2.0;
  double first_speed_sigma_mps = 2.0;
  bool remember_hidden = true;

  /// Neighbors are dropped one second after their last measurement, as flocking models assume.
  static NeighborSourceConfig without_memory();
  void visit(ConfigVisitor& v);
};

}  // namespace swiftlet
