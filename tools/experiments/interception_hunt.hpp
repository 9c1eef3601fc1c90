// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "parallel.hpp"

/// Flights of an interceptor on nothing but its LiDAR (scenarios/reproduce/interception_lidar.yaml).
namespace swiftlet::tools {

using Overrides = std::vector<std::pair<std::string, std::string>>;

inline constexpr double kDocumentSpeed_mps = 5.0;  // of the target in the document

/// A LiDAR with the detector that suits it.
struct HuntEye {
  const char* name;
  Overrides overrides;
};
HuntEye os1_eye();
/// Upside down, because the net hangs below; few of its beams meet a target, so that scans are fused before deciding.
HuntEye mid360_eye();

/// Flight `number`: another field, other starts, another flight of the intruder.
/// @param start  0, or 1 for another place of the interceptor in the same flight
sim::Scenario hunt(int number, const char* method, double speed_mps, const Overrides& changes, int start = 0);
/// Somebody believes that it is done, or gave up, or has crashed.
bool hunt_is_over(const sim::Simulation& simulation);

}  // namespace swiftlet::tools
