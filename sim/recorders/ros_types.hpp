// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "sim/recorders/ros_encoder.hpp"

namespace swiftlet::sim {

/// A message type written by the recorders.
struct RosType {
  std::string package;
  std::string name;
  std::span<const char* const> parts;  ///< "package/Name" of every nested type, in order of appearance
  std::string text = {};               ///< fields in ROS 1 syntax; empty: a standard type
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
/// The definition with those of all its parts, as stored in bags.
std::string full_definition(const RosType& type, RosDialect dialect);
/// The fingerprint of the type in ROS 1.
std::string ros1_fingerprint(const RosType& type);

}  // namespace swiftlet::sim
