// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "swiftlet/core/base/scan.hpp"

namespace swiftlet::sim {

/// Truth of each beam of a scan (rows x cols); never given to an agent.
struct ScanTruth {
  std::vector<float> range_m;        ///< without noise; 0: no surface in range
  std::vector<float> incidence_rad;  ///< angle between beam and surface normal
  std::vector<std::uint16_t> surface_class;
  std::vector<std::uint16_t> instance;  ///< VehicleId + 1 for vehicles
  std::vector<std::uint8_t> part;       ///< VehiclePart
  std::vector<Pose> T_world_lidar;      ///< true pose of the sensor for each column            (cols), or (1) if frozen
  Pose T_body_lidar = Pose::Identity();  ///< true mounting; Scan::T_body_lidar is the calibrated one
  TimeNs clock_error = 0;                ///< Scan::stamp minus the true start of the sweep
};

/// A scan with its truth. Made by the LiDAR from a pool, shared with agents (the scan only) and recorders (both).
struct LabeledScan {
  Scan scan;
  ScanTruth truth;
};

}  // namespace swiftlet::sim
