// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/sim/recorders/ros_config.hpp"
#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

struct McapConfig : ModuleConfigOf<McapConfig>, RosConfig, OutputProvider {
  std::string file = "record.mcap";
  enum class Compression { kZstd, kNone };
  Compression compression = Compression::kZstd;

  void visit(ConfigVisitor& v) override;
  RecorderOutput output() const override { return {"file", file, true, "mcap", {}, {}}; }
};

/// One MCAP file with ROS 2 messages (profile ros2, CDR, ros2msg schemas), readable by `ros2 bag` and viewers.
std::unique_ptr<Recorder> make_mcap_recorder(const ModuleConfig& config);

}  // namespace swiftlet::sim
