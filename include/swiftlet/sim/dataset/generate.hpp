// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "swiftlet/sim/dataset/flight.hpp"
#include "swiftlet/sim/dataset/sequence_info.hpp"

/// Generation of a dataset directory from a dataset file:
///   README.md  manifest.json  dataset.yaml  semantic-kitti.yaml  charts/  sequences/NN/...
namespace swiftlet::sim {

struct GenerateOptions {
  std::filesystem::path directory;
  int jobs = 1;                    ///< number of worker processes
  bool resume = false;             ///< continue an interrupted generation
  std::function<bool()> canceled;  ///< polled; true stops the generation
  /// Called with the number of finished flights, the number of all flights, and an optional remark.
  std::function<void(int done, int all, const std::string& note)> progress;
};

/// Wall time of one or several flights by activity.
struct FlightTiming {
  double prepare_s = 0.0;   ///< generation of worlds and paths, and attempts of flights that are drawn again
  double simulate_s = 0.0;  ///< simulation without recording
  double record_s = 0.0;    ///< writing and hashing for which the simulation waits
  double beside_s = 0.0;    ///< processor time of writing in parallel with the simulation; part of no other duration

  void add(const FlightTiming& other);
};

struct GenerateReport {
  int flights_done = 0, flights_all = 0;
  bool canceled = false;
  std::vector<SequenceInfo> sequences;
  double wall_s = 0.0;
  FlightTiming timing;  ///< sum over the flights that this call simulated
};

/// Generates the missing sequences of a dataset. Throws InputError when the directory contains other files or a dataset
/// of another configuration, and std::runtime_error with the first failure of a flight. Finished sequences are always
/// kept.
GenerateReport generate_dataset(const DatasetPlan& plan, const GenerateOptions& options);

/// Simulates one flight and writes its sequences, each under a temporary name until it is complete; existing sequences
/// are left unchanged. A flight that cannot be planned or that ends in a crash is drawn again.
FlightTiming write_flight(const DatasetPlan& plan, const Flight& flight, const std::filesystem::path& directory,
                          int threads);

/// Rebuilds the flight of a finished sequence identically, to verify the sequence.
PreparedFlight restore_flight(const std::filesystem::path& sequence_directory, const SequenceInfo& info);

/// Content of manifest.json, the description of the whole dataset.
std::string manifest_json(const DatasetPlan& plan, const std::vector<SequenceInfo>& sequences,
                          const std::vector<FileEntry>& files, bool complete);

/// Content of semantic-kitti.yaml: the classes in the format of semantic-kitti-api, for readers of SemanticKITTI.
std::string class_table(const DatasetPlan& plan, const std::vector<SequenceInfo>& sequences);

}  // namespace swiftlet::sim
