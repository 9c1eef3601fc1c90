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

/// Identity of the batch, common to all rows of one database.
struct BatchInfo {
  std::string name;
  std::string description;
  std::string file;         ///< the batch file's path
  std::string text;         ///< its resolved content
  std::string fingerprint;  ///< BatchPlan::fingerprint()
  std::string version;
  std::string git_revision;
  std::uint64_t num_episodes = 0;  ///< number of episodes of the whole batch
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
  std::string outcome;                  ///< outcome of the run's missions; empty unless done
  std::string state_hash;
  double simulated_s = 0.0;
  std::string message;  ///< reason when not done
  std::string command;  ///< command that repeats this episode alone
  std::vector<MetricRow> metrics;
  // Machine-dependent values:
  std::string host;
  double setup_wall_s = 0.0;
  double flight_wall_s = 0.0;
  double wall_s = 0.0;  ///< total wall time, measured by the coordinator
  bool built_world = false;

  bool done() const { return status == "done"; }
  /// True if the results equal those of another row of the same episode, apart from machine-dependent values.
  bool agrees_with(const EpisodeRow& other) const;
};

/// One SQLite database of results. Every episode is one transaction of a journalled database: episodes for which add()
/// has returned survive a kill at any moment.
class ResultStore {
 public:
  enum class Mode { kCreate, kAppend, kRead };

  /// kCreate: the file must not exist. kAppend: created if missing. Throws InputError when the file is not such a
  /// database, std::runtime_error when it cannot be written.
  ResultStore(std::filesystem::path file, Mode mode);
  ~ResultStore();
  ResultStore(ResultStore&&) noexcept;

  const std::filesystem::path& file() const;

  /// Empty in a new database.
  std::optional<BatchInfo> info() const;
  void set_info(const BatchInfo& info);

  std::set<std::uint64_t> episode_ids() const;
  std::map<std::string, std::uint64_t> count_by_status() const;
  void add(const EpisodeRow& row);
  /// Removes episodes that are not done, so that they are flown again. Returns their number.
  std::uint64_t remove_unfinished();
  /// Sorted by episode number.
  std::vector<EpisodeRow> episodes(bool with_metrics = true) const;
  std::optional<EpisodeRow> episode(std::uint64_t id) const;
  /// All values except the machine-dependent ones, as text; equal for equal results.
  std::string dump() const;
  /// Merges the journal into the database file.
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// episodes.csv (a row an episode, metrics as columns) and metrics.csv (a row a metric) in `directory`.
void export_csv(const ResultStore& store, const std::filesystem::path& directory);

}  // namespace swiftlet::sim
