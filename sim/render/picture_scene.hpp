// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "swiftlet/core/base/overlay.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

struct LabeledScan;

/// Points of one scan in the world frame. `intensity` and `surface_class` are empty when unknown.
struct PictureCloud {
  VehicleId vehicle = 0;
  std::vector<Eigen::Vector3f> points_world_m;
  std::vector<float> intensity;  ///< reflectivity, 1 = white Lambertian
  std::vector<std::uint16_t> surface_class;
};

/// The variable part of a picture of a run, filled by the recorder or from a finished run.
struct PictureScene {
  TimeNs t = 0;
  std::vector<VehicleState> states;                    ///< indexed by VehicleId
  std::vector<std::vector<Eigen::Vector3f>> trails_m;  ///< indexed by VehicleId: positions in the world, oldest first
  std::vector<PictureCloud> clouds;
  std::vector<Overlay> overlays;
};

/// The name of an overlay is "uav1/reference"; without a vehicle it selects all overlays of that name, "*" all.
bool is_chosen(const Overlay& overlay, const std::vector<std::string>& names);

/// The returns of a scan in the world, at the true pose of the sensor.
PictureCloud cloud_of(const LabeledScan& scan, VehicleId vehicle);

/// Appends a position when the vehicle has moved; thins out old ones to bound memory.
void extend_trail(std::vector<Eigen::Vector3f>& trail_world_m, const Eigen::Vector3f& p_world_m);

}  // namespace swiftlet::sim
