// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/merge.hpp"

#include <unistd.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>

#include "sim/batch/writer_lock.hpp"
#include "swiftlet/sim/batch/result_store.hpp"
#include "swiftlet/sim/batch/run_batch.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

// [-] Maximum number of missing episodes that a merge lists.
constexpr std::size_t kMissingShown = 10;
constexpr std::string_view kUnfinished = ".results.merging-";  // followed by the process number

/// The preferred one of two rows of an episode; independent of their order.
const EpisodeRow& better(const EpisodeRow& a, const EpisodeRow& b) {
  if (a.done() != b.done()) return a.done() ? a : b;
  const auto key = [](const EpisodeRow& row) {
    return std::tie(row.status, row.message, row.host, row.wall_s, row.command);
  };
  return key(b) < key(a) ? b : a;
}

[[noreturn]] void fail_disagreement(const EpisodeRow& a, const EpisodeRow& b, const fs::path& from) {
  std::string what = "state hash " + a.state_hash + " and " + b.state_hash;
  if (a.state_hash == b.state_hash) {
    what = "another number of metrics";
    for (std::size_t i = 0; i < std::min(a.metrics.size(), b.metrics.size()); ++i) {
      const MetricRow &m = a.metrics[i], &n = b.metrics[i];
      if (m.name == n.name && m.vehicle == n.vehicle && m.text == n.text && (m.value == n.value || m.value != m.value))
        continue;
      what = "metric " + m.name;
      break;
    }
  }
  throw InputError(from.string() + ": episode " + std::to_string(a.id) +
                   ": expected equal results from every source, found different ones (" + what +
                   "); were they made by different builds or machines?");
}

class Merger {
 public:
  explicit Merger(ResultStore& store) : store_(store) {}

  void add(const fs::path& file) {
    const ResultStore source(file, ResultStore::Mode::kRead);
    const auto info = source.info();
    if (!info) return;  // killed before writing its batch info
    if (first_) {
      require_same_batch(*info, *first_, file);
      // The kept path does not depend on the order of the sources.
      if (std::tie(info->file, info->text, info->git_revision) <
          std::tie(first_->file, first_->text, first_->git_revision))
        first_ = info;
    } else {
      first_ = info;
    }
    store_.set_info(*first_);
    for (const std::uint64_t id : source.episode_ids()) add_episode(*source.episode(id), file);
  }

  const std::optional<BatchInfo>& info() const { return first_; }
  std::uint64_t overlaps() const { return overlaps_; }

 private:
  void add_episode(const EpisodeRow& row, const fs::path& file) {
    const auto known = store_.episode(row.id);
    if (!known) return store_.add(row);
    ++overlaps_;
    if (known->done() && row.done() && !known->agrees_with(row)) fail_disagreement(*known, row, file);
    const EpisodeRow& winner = better(*known, row);
    if (&winner == &row) store_.add(row);
  }

  ResultStore& store_;
  std::optional<BatchInfo> first_;
  std::uint64_t overlaps_ = 0;
};

void add_databases(std::vector<fs::path>& found, const fs::path& directory) {
  if (!fs::is_directory(directory)) return;
  for (const auto& entry : fs::directory_iterator(directory)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() == ".sqlite" && !name.starts_with('.') && entry.is_regular_file())
      found.push_back(entry.path());
  }
}

bool is_unfinished(const std::string& name) {
  if (!name.starts_with(kUnfinished)) return false;
  const std::string rest = name.substr(std::min(name.find_first_not_of("0123456789", kUnfinished.size()), name.size()));
  return name.size() > kUnfinished.size() + rest.size() &&
         (rest == ".sqlite" || rest == ".sqlite-wal" || rest == ".sqlite-shm" || rest == ".sqlite-journal");
}

/// Removes files of killed merges into this directory. Requires the lock of its database.
void remove_unfinished(const fs::path& directory) {
  std::vector<fs::path> unfinished;
  for (const auto& entry : fs::directory_iterator(directory)) {
    if (is_unfinished(entry.path().filename().string())) unfinished.push_back(entry.path());
  }
  std::error_code error;
  for (const fs::path& path : unfinished) fs::remove(path, error);
}

}  // namespace

std::vector<fs::path> find_databases(const std::vector<fs::path>& sources) {
  std::vector<fs::path> found;
  for (const fs::path& source : sources) {
    const std::size_t before = found.size();
    if (fs::is_directory(source)) {
      add_databases(found, source);
      add_databases(found, source / "shards");
    } else if (fs::is_regular_file(source)) {
      found.push_back(source);
    }
    if (found.size() == before)
      throw InputError(source.string() + ": expected a batch directory or a database of results, found none");
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

MergeOutcome merge_batches(const std::vector<fs::path>& databases, const fs::path& out) {
  std::error_code error;
  make_directory(out);
  const fs::path destination = out / "results.sqlite";
  const WriterLock lock(destination);  // a batch still writing there would continue in a deleted file
  remove_unfinished(out);
  PartialFile database(destination, out / (std::string(kUnfinished) + std::to_string(getpid()) + ".sqlite"));
  const fs::path& partial = database.partial();
  std::vector<fs::path> sources = databases;
  const auto is_destination = [&](const fs::path& path) {
    return fs::exists(destination) && fs::equivalent(path, destination);
  };
  if (fs::exists(destination) && std::none_of(sources.begin(), sources.end(), is_destination))
    sources.push_back(destination);
  MergeOutcome outcome;
  try {
    ResultStore store(partial, ResultStore::Mode::kCreate);
    Merger merger(store);
    for (const fs::path& file : sources) merger.add(file);
    if (!merger.info()) throw InputError(out.string() + ": expected results to merge, found none");
    outcome.expected = merger.info()->num_episodes;
    outcome.overlaps = merger.overlaps();
    outcome.by_status = store.count_by_status();
    const std::set<std::uint64_t> ids = store.episode_ids();
    outcome.episodes = ids.size();
    for (std::uint64_t id = 0; id < outcome.expected && outcome.first_missing.size() < kMissingShown; ++id) {
      if (!ids.contains(id)) outcome.first_missing.push_back(id);
    }
    export_csv(store, out);
    store.close();
  } catch (...) {
    remove_unfinished(out);
    throw;
  }
  for (const char* suffix : {"-wal", "-shm", "-journal"})
    fs::remove(destination.string() + suffix, error);  // journals of the replaced database
  database.commit();
  return outcome;
}

}  // namespace swiftlet::sim
