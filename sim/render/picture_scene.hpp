// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "swiftlet/core/overlay.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

struct LabeledScan;

/// Points of one scan in the world frame. `intensity` and `surface_class` may be empty when unknown.
struct PictureCloud {
  VehicleId vehicle = 0;
  std::vector<Eigen::Vector3f> points_world_m;
  std::vector<float> intensity;  ///< reflectivity, 1 = white Lambertian
  std::vector<std::uint16_t> surface_class;
};

/// Everything that changes between two pictures of a run: filled live by the recorder, or from a finished run.
struct PictureScene {
  TimeNs t = 0;
  std::vector<VehicleState> states;                    ///< by VehicleId
  std::vector<std::vector<Eigen::Vector3f>> trails_m;  ///< by VehicleId: positions in the world, oldest first
  std::vector<PictureCloud> clouds;
  std::vector<Overlay> overlays;
};

/// An overlay of a vehicle is named "uav1/reference"; without the vehicle all of that name are meant, by "*" all.
bool is_chosen(const Overlay& overlay, const std::vector<std::string>& names);

/// The returns of a scan in the world, at the true pose of the sensor.
PictureCloud cloud_of(const LabeledScan& scan, VehicleId vehicle);

/// Grows by one position where the vehicle has moved; keeps its memory bounded by thinning out.
void extend_trail(std::vector<Eigen::Vector3f>& trail_world_m, const Eigen::Vector3f& p_world_m);

}  // namespace swiftlet::sim
