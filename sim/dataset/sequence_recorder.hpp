// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "swiftlet/sim/dataset/dataset_config.hpp"
#include "swiftlet/sim/dataset/sequence_info.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

/// Writes the scans of one LiDAR as a sequence (docs/datasets.md); a separate thread writes the frames.
/// @param world  world of the run, for visibility
/// @param statistics  complete when the recorder has finished; shared because it outlives the recorder
std::unique_ptr<Recorder> make_sequence_recorder(const ContentConfig& content, VehicleId vehicle,
                                                 const std::string& sensor, std::shared_ptr<const StaticScene> world,
                                                 std::shared_ptr<SequenceStatistics> statistics);

/// "velodyne/000012.bin".
std::string frame_file(const char* folder, int frame, const char* extension);

}  // namespace swiftlet::sim
