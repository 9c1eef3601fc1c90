// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/sim/recorders/ros_config.hpp"
#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

struct RosbagConfig : ModuleConfigOf<RosbagConfig>, RosConfig, OutputProvider {
  std::string file = "record.bag";
  enum class Compression { kLz4, kNone };
  Compression compression = Compression::kLz4;

  void visit(ConfigVisitor& v) override;
  RecorderOutput output() const override { return {"file", file, true, "rosbag", {}, {}}; }
};

/// One ROS 1 bag, version 2.0.
std::unique_ptr<Recorder> make_rosbag_recorder(const ModuleConfig& config);

}  // namespace swiftlet::sim
