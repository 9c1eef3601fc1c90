// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "experiment.hpp"
#include "parallel.hpp"

/// The flights of Pliska et al. (IEEE RA-L 9(10), 2024): truth as input, targets on random trajectories.
namespace swiftlet::tools {

/// Largest speed and acceleration of the targets; the paper gives two different pairs.
struct TargetLimits {
  const char* name;
  double speed_mps, acceleration_mps2;
};
inline constexpr TargetLimits kTargetLimits[] = {{"8 m/s", 8.0, 4.0}, {"10 m/s", 10.0, 8.0}};

/// One trajectory from one start. The target's speed and acceleration are drawn for each trajectory.
sim::Scenario protocol_flight(const char* method, const TargetLimits& limits, int trajectory, int start);

}  // namespace swiftlet::tools
