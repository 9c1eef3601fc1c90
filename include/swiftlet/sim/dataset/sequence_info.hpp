// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace swiftlet::sim {

/// Entry of a manifest: a file of a dataset.
struct FileEntry {
  std::string path;  ///< relative
  std::uint64_t bytes = 0;
  std::string xxh128;
};

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

/// Content of sequences/NN/sequence.json.
struct SequenceInfo {
  int sequence = 0;
  std::string split;
  int flight = 0;
  std::uint64_t seed = 0;
  int attempt = 0;
  std::string family;
  std::string vehicle;  ///< carrier of the LiDAR
  int instance = 0;     ///< instance label of the points on that vehicle
  std::string sensor;
  std::string sensor_model;
  std::vector<std::string> vehicles;
  std::vector<std::string> models;  ///< model of each vehicle
  std::string state_hash;
  std::string fingerprint;  ///< fingerprint of the dataset
  std::string version, revision;
  std::vector<double> reflectivities;
  SequenceStatistics statistics;
  std::vector<FileEntry> files;  ///< all but sequence.json
};

std::string to_json(const SequenceInfo& info);
/// Throws std::runtime_error with the path and the reason.
SequenceInfo read_sequence_info(const std::filesystem::path& directory);

/// The share of LiDAR poses outside walls, of all frames and by split: "25.0 % of 480 poses lie outside walls (train
/// 0.0 %, valid 100.0 %)". Empty when no world has walls that enclose some of the ground.
std::string poses_outside(const std::vector<SequenceInfo>& sequences);

/// Size and hash of every file below a directory, by name, without sequence.json.
/// @param known  files with known size and hash, not read again
/// @param without  folder to exclude
std::vector<FileEntry> list_files(const std::filesystem::path& directory, std::vector<FileEntry> known = {},
                                  const std::string& without = {});

/// "00", "07", "113".
std::string sequence_name(int sequence);

}  // namespace swiftlet::sim
