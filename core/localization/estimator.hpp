// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/observation.hpp"

namespace swiftlet {

/// Where am I? One of the ways of answering that a scenario chooses by name.
class StateEstimator {
 public:
  virtual ~StateEstimator() = default;
  /// Takes in one observation; the state at its time `t`. Samples that are not finite are passed over. The result
  /// belongs to the estimator. Not valid when the sensors that it needs have been silent for too long.
  virtual const StateEstimate& update(const Observation& observation) = 0;
  /// Why the estimate is not valid, in a few words; empty while it is.
  virtual const char* fault() const = 0;
};

}  // namespace swiftlet
