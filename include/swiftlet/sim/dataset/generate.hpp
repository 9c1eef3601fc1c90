// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "swiftlet/sim/dataset/flight.hpp"
#include "swiftlet/sim/dataset/sequence_info.hpp"

/// From a dataset file to a directory:
///   README.md  manifest.json  dataset.yaml  semantic-kitti.yaml  charts/  sequences/NN/...
namespace swiftlet::sim {

struct GenerateOptions {
  std::filesystem::path directory;
  int jobs = 1;         ///< worker processes
  bool resume = false;  ///< continue an interrupted generation
  std::function<bool()> canceled;
  std::function<void(int done, int all, const std::string& note)> progress;
};

/// Wall time of flights by activity.
struct FlightTiming {
  double prepare_s = 0.0;   ///< worlds and paths, including rejected draws of flights
  double simulate_s = 0.0;  ///< the simulation itself
  double record_s = 0.0;    ///< time for which the simulation waited for writing and hashing
  double beside_s = 0.0;    ///< processor time of the writing in parallel with the simulation

  void add(const FlightTiming& other);
};

struct GenerateReport {
  int flights_done = 0, flights_all = 0;
  bool canceled = false;
  std::vector<SequenceInfo> sequences;
  double wall_s = 0.0;
  FlightTiming timing;  ///< sum over all simulated flights
};

/// Writes the missing sequences. Throws InputError when the directory holds other files or a dataset of another
/// configuration, std::runtime_error with the first failure. Finished sequences are kept in any case.
GenerateReport generate_dataset(const DatasetPlan& plan, const GenerateOptions& options);

/// Simulates one flight and writes its sequences, each under a temporary name until it is complete; existing sequences
/// are left unchanged. A flight that cannot be planned or that ends in a crash is drawn again.
FlightTiming write_flight(const DatasetPlan& plan, const Flight& flight, const std::filesystem::path& directory,
                          int threads);

/// Rebuilds the flight of a finished sequence exactly as it was written, for verification.
PreparedFlight restore_flight(const std::filesystem::path& sequence_directory, const SequenceInfo& info);

/// Description of the dataset as a whole: manifest.json.
std::string manifest_json(const DatasetPlan& plan, const std::vector<SequenceInfo>& sequences,
                          const std::vector<FileEntry>& files, bool complete);

/// The class table in the form that readers of SemanticKITTI use (semantic-kitti.yaml of semantic-kitti-api).
std::string class_table(const DatasetPlan& plan, const std::vector<SequenceInfo>& sequences);

}  // namespace swiftlet::sim
