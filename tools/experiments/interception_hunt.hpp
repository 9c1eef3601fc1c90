// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "parallel.hpp"

/// Flights of an interceptor with only a LiDAR (scenarios/reproduce/interception_lidar.yaml).
namespace swiftlet::tools {

using Overrides = std::vector<std::pair<std::string, std::string>>;

inline constexpr double kDocumentSpeed_mps = 5.0;  // target speed in the document

/// A LiDAR with a suitable detector.
struct HuntEye {
  const char* name;
  Overrides overrides;
};
HuntEye os1_eye();
/// Mounted upside down because the net hangs below. Few beams hit a target, so the detector fuses scans.
HuntEye mid360_eye();

/// Flight `number`, which draws the field, the starts and the intruder's trajectory.
/// @param start  1: another start of the interceptor in the same flight
sim::Scenario hunt(int number, const char* method, double speed_mps, const Overrides& changes, int start = 0);
/// A vehicle reports mission_done or mission_failed, or crashes.
bool hunt_is_over(const sim::Simulation& simulation);

}  // namespace swiftlet::tools
