// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

struct MapConfig : ModuleConfigOf<MapConfig>, OutputProvider {
  std::vector<std::string> vehicles;
  std::vector<std::string> maps;
  std::vector<double> times_s;
  bool at_end = true;
  enum class Voxels { kAll, kOccupied };
  Voxels voxels = Voxels::kAll;
  enum class Format { kPly, kPcd, kOt, kBt };
  static constexpr const char* kFormats[] = {"ply", "pcd", "ot", "bt"};
  Format format = Format::kPly;
  const char* format_name() const { return kFormats[static_cast<std::size_t>(format)]; }
  std::string folder = "maps";

  void visit(ConfigVisitor& v) override;
  RecorderOutput output() const override { return {"folder", folder, false, format_name(), vehicles, maps}; }
};

/// Records the vehicles' maps, voxel by voxel with state and value, at given times and at the end:
/// FOLDER/VEHICLE_MAP_SECONDS.ply and FOLDER/VEHICLE_MAP_end.ply, or .pcd, .ot, .bt. Positions are in the vehicle's
/// local frame; the header holds the pose of that frame.
std::unique_ptr<Recorder> make_map_recorder(const ModuleConfig& config);

}  // namespace swiftlet::sim
