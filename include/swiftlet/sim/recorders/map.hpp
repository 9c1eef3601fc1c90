// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/sim/recorder_output.hpp"
#include "swiftlet/sim/view/recorder.hpp"

namespace swiftlet::sim {

struct MapConfig : ModuleConfigOf<MapConfig>, TellsOutput {
  std::vector<std::string> vehicles;
  std::vector<std::string> maps;
  std::vector<double> times_s;
  bool at_end = true;
  std::string voxels = "all";
  std::string format = "ply";
  std::string folder = "maps";

  void visit(ConfigVisitor& v) override;
  RecorderOutput output() const override { return {"folder", folder, false, format, vehicles, maps}; }
};

/// The maps that vehicles keep, voxel by voxel with state and value, at instants and at the end:
/// FOLDER/VEHICLE_MAP_SECONDS.ply and FOLDER/VEHICLE_MAP_end.ply, or .pcd. Positions are in the vehicle's local frame;
/// the header tells where that frame is.
std::unique_ptr<Recorder> make_map_recorder(const ModuleConfig& config);

}  // namespace swiftlet::sim
