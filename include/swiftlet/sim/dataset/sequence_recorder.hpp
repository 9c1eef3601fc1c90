// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "swiftlet/sim/dataset/dataset_config.hpp"
#include "swiftlet/sim/dataset/hash.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

/// Statistics of a sequence for the data card; sums over frames.
struct SequenceStatistics {
  static constexpr int kRangeBins = 50;
  static constexpr double kRangeBin_m = 2.0;
  /// Vehicles by distance; the last bin also holds all farther ones.
  struct RangeBin {
    std::int64_t boxes = 0;          ///< vehicles at this distance
    std::int64_t in_view = 0;        ///< boxes of which at least a tenth of the silhouette is visible
    std::int64_t detected = 0;       ///< boxes with at least one point
    std::int64_t well_detected = 0;  ///< boxes with at least five points
    std::int64_t points = 0;
  };

  std::int64_t frames = 0;
  std::int64_t points = 0;
  std::map<std::uint16_t, std::int64_t> points_by_class;
  std::array<RangeBin, kRangeBins> vehicles_by_range{};
  std::array<std::int64_t, kRangeBins> points_by_range{};
  double flown_m = 0.0;
  double duration_s = 0.0;
  double least_clearance_m = 1e9;
  std::int64_t frames_walled = 0;       ///< frames in worlds whose walls enclose a part of the ground
  std::int64_t frames_outside = 0;      ///< frames_walled in which walls do not enclose the LiDAR
  std::vector<int> pixel_shift_by_row;  ///< column shift of each row of the range images; empty: no images
  int rows = 0, columns = 0;
  std::vector<FileEntry> files;  ///< frame files with their hashes
  double beside_s = 0.0;         ///< processor time of writing frames in parallel with the simulation

  void add(const SequenceStatistics& other);
};

/// Writes the scans of one LiDAR as a sequence (docs/datasets.md); a separate thread writes the frames.
/// @param world  world of the run, for visibility
/// @param statistics  complete when the recorder has finished; shared because it outlives the recorder
std::unique_ptr<Recorder> make_sequence_recorder(const ContentConfig& content, VehicleId vehicle,
                                                 const std::string& sensor, std::shared_ptr<const StaticScene> world,
                                                 std::shared_ptr<SequenceStatistics> statistics);

/// "velodyne/000012.bin".
std::string frame_file(const char* folder, int frame, const char* extension);

}  // namespace swiftlet::sim
