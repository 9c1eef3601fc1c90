// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "swiftlet/core/message.hpp"
#include "swiftlet/core/samples.hpp"
#include "swiftlet/core/scan.hpp"

namespace swiftlet {

/// Everything that one vehicle gets to know in one tick: what its sensors and its radio delivered since the last one.
/// Vectors are in order of their stamps and keep their capacity between ticks.
struct Observation {
  TimeNs t = 0;  ///< now
  VehicleId self = 0;
  std::vector<ImuSample> imu;
  std::vector<OdometrySample> odometry;
  std::vector<GnssSample> gnss;
  std::vector<AltimeterSample> altimeter;
  std::vector<CompassSample> compass;
  std::vector<PoseSample> pose;
  std::vector<NeighborSample> neighbors;
  std::vector<std::shared_ptr<const Scan>> scans;  ///< shared, because a slow module may hold on to a scan
  std::vector<Message> messages;
  bool wants_overlays = false;  ///< a picture is taken in this tick

  void clear() {
    imu.clear();
    odometry.clear();
    gnss.clear();
    altimeter.clear();
    compass.clear();
    pose.clear();
    neighbors.clear();
    scans.clear();
    messages.clear();
    wants_overlays = false;
  }
};

}  // namespace swiftlet
