// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "sim/recorders/ros_encoder.hpp"

namespace swiftlet::sim {

/// A message type that the recorders write.
struct RosType {
  const char* package;
  const char* name;
  const char* ros1_md5;                ///< fingerprint of the ROS 1 definition
  std::span<const char* const> parts;  ///< "package/Name" of every type inside, in order of appearance
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

}  // namespace swiftlet::sim
