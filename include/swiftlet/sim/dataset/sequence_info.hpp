// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "swiftlet/sim/dataset/hash.hpp"
#include "swiftlet/sim/dataset/sequence_recorder.hpp"

namespace swiftlet::sim {

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
