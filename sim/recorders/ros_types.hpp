// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "sim/recorders/ros_encoder.hpp"

namespace swiftlet::sim {

/// A message type that the recorders write.
struct RosType {
  std::string package;
  std::string name;
  std::span<const char* const> parts;  ///< "package/Name" of every type inside, in order of appearance
  std::string text = {};               ///< its fields in the words of ROS 1; empty: a standard type
};

extern const RosType kPointCloud2;
extern const RosType kImu;
extern const RosType kNavSatFix;
extern const RosType kOdometry;
extern const RosType kPoseStamped;
extern const RosType kTFMessage;
extern const RosType kClock;
extern const RosType kMarkerArray;

/// "sensor_msgs/Imu" or "sensor_msgs/msg/Imu".
std::string full_name(const RosType& type, RosDialect dialect);
/// The definition with those of all its parts, as bags carry it.
std::string full_definition(const RosType& type, RosDialect dialect);
/// The fingerprint by which ROS 1 tells types apart.
std::string ros1_fingerprint(const RosType& type);

}  // namespace swiftlet::sim
