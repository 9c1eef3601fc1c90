// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "swiftlet/sim/metrics/metric_table.hpp"

namespace swiftlet::sim {

/// What all rows of one database have in common.
struct BatchInfo {
  std::string name;
  std::string description;
  std::string file;         ///< the batch file's path
  std::string text;         ///< its resolved content
  std::string fingerprint;  ///< BatchPlan::fingerprint()
  std::string version;
  std::string git_revision;
  std::uint64_t num_episodes = 0;  ///< of the whole batch
  std::vector<std::string> variants;
  std::vector<std::string> parameters;
};

/// Everything that is stored of one episode.
struct EpisodeRow {
  std::uint64_t id = 0;
  std::string variant;
  std::size_t point = 0;
  std::uint64_t seed = 0;
  std::vector<std::string> parameters;  ///< values, by parameter
  std::string status;                   ///< name_of(JobStatus)
  std::string outcome;                  ///< of the missions; empty unless done
  std::string state_hash;
  double simulated_s = 0.0;
  std::string message;  ///< why it is not done
  std::string command;  ///< repeats it alone
  std::vector<MetricRow> metrics;
  // Of the machine:
  std::string host;
  double setup_wall_s = 0.0;
  double flight_wall_s = 0.0;
  double wall_s = 0.0;  ///< as the coordinator saw it
  bool built_world = false;

  bool done() const { return status == "done"; }
  /// Does it say the same as another row of that episode, wherever and however fast each was flown?
  bool agrees_with(const EpisodeRow& other) const;
};

/// One SQLite database of results. Every episode is one transaction of a journalled database: a kill at any moment
/// loses no episode that add() has returned from.
class ResultStore {
 public:
  enum class Mode { kCreate, kAppend, kRead };

  /// kCreate: nothing may be there. kAppend: made when it is not there. Throws InputError when the file is not such a
  /// database, std::runtime_error when it cannot be written.
  ResultStore(std::filesystem::path file, Mode mode);
  ~ResultStore();
  ResultStore(ResultStore&&) noexcept;

  const std::filesystem::path& file() const;

  /// Empty in a database that was just made.
  std::optional<BatchInfo> info() const;
  void set_info(const BatchInfo& info);

  std::set<std::uint64_t> episode_ids() const;
  std::map<std::string, std::uint64_t> count_by_status() const;
  void add(const EpisodeRow& row);
  /// Removes what is not done, so that it is flown again; the number of those.
  std::uint64_t remove_unfinished();
  /// In the order of their numbers.
  std::vector<EpisodeRow> episodes(bool with_metrics = true) const;
  std::optional<EpisodeRow> episode(std::uint64_t id) const;
  /// Everything but what belongs to the machine, as text: equal for equal results.
  std::string dump() const;
  /// Folds the journal into the database, so that it is one file.
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// episodes.csv (a row an episode, metrics as columns) and metrics.csv (a row a metric) in `directory`.
void export_csv(const ResultStore& store, const std::filesystem::path& directory);

}  // namespace swiftlet::sim
