// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "sim/recorders/ros_encoder.hpp"
#include "swiftlet/core/scan.hpp"
#include "swiftlet/sim/recorders/ros_config.hpp"

namespace swiftlet::sim {

/// sensor_msgs/PointCloud2 of a scan, in the lidar's frame.
/// @param step_m  coordinates are rounded to multiples of this; 0: not
void encode_points(const Scan& scan, PointsLayout layout, float step_m, std::uint32_t sequence,
                   const std::string& frame, RosEncoder& out);

/// Reflectivity as the sensors give it in a byte. Diffuse targets are linear up to `diffuse_max` (1 = white
/// Lambertian). Brighter (retro-reflective) ones are logarithmic from there to 255 at 1000 times that.
std::uint8_t reflectivity_byte(float reflectivity, int diffuse_max);

}  // namespace swiftlet::sim
