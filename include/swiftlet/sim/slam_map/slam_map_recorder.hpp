// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

struct SlamMapConfig : ModuleConfigOf<SlamMapConfig>, OutputProvider {
  std::vector<std::string> vehicles;
  std::string folder = "maps";

  void visit(ConfigVisitor& v) override;
  RecorderOutput output() const override { return {"folder", folder, false, "slam", vehicles, {}}; }
};

/// Writes the SLAM maps of the vehicles, with their pose graphs, at the end: FOLDER/VEHICLE.slam.
std::unique_ptr<Recorder> make_slam_map_recorder(const ModuleConfig& config);

}  // namespace swiftlet::sim
