// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "sim/recorders/ros_encoder.hpp"
#include "swiftlet/core/base/scan.hpp"
#include "swiftlet/sim/recorders/ros_config.hpp"

namespace swiftlet::sim {

/// sensor_msgs/PointCloud2 of a scan, in the lidar's frame.
/// @param step_m  coordinates are rounded to multiples of this; 0: no rounding
void encode_points(const Scan& scan, PointsLayout layout, float step_m, std::uint32_t sequence,
                   const std::string& frame, RosEncoder& out);

/// Reflectivity in a byte, as from the sensors. Linear up to `diffuse_max` for diffuse targets (1 = white Lambertian),
/// logarithmic for brighter (retro-reflective) ones, from there to 255 at 1000 times that.
std::uint8_t reflectivity_byte(float reflectivity, int diffuse_max);

}  // namespace swiftlet::sim
