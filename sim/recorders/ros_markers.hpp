// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sim/recorders/ros_encoder.hpp"
#include "swiftlet/core/base/detection.hpp"
#include "swiftlet/core/base/track.hpp"
#include "swiftlet/sim/world/scene.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {

/// visualization_msgs/MarkerArray in the frame `world`. The first marker deletes those of the previous message, so that
/// only the newest message is visible.
/// A red box for each detection, `ns` "detections".
void encode_detection_markers(std::span<const Detection> detections, TimeNs t, std::uint32_t sequence, RosEncoder& out);
/// For each track, with its identity as `id`: position ("tracks"), three standard deviations ("covariance"),
/// displacement in the next second ("velocity"), number ("names").
void encode_track_markers(std::span<const Track> tracks, TimeNs t, std::uint32_t sequence, RosEncoder& out);
/// The world as triangles, one marker per material, `ns` "world".
void encode_world_markers(const Scene& scene, TimeNs t, std::uint32_t sequence, RosEncoder& out);
/// A vehicle as triangles that move with its frame, `ns` "model"; rotors are drawn as discs.
void encode_vehicle_markers(const VehicleShape& shape, const std::string& frame, TimeNs t, std::uint32_t sequence,
                            RosEncoder& out);

}  // namespace swiftlet::sim
