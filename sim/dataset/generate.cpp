// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/dataset/generate.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "sim/dataset/data_card.hpp"
#include "sim/dataset/hash.hpp"
#include "swiftlet/sim/batch/worker_pool.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/shallow_json.hpp"
#include "swiftlet/sim/run/processors.hpp"
#include "swiftlet/sim/run/version.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kManifest = "manifest.json";

/// Prevents two generations from writing into one directory.
class DirectoryLock {
 public:
  explicit DirectoryLock(const fs::path& directory) {
    const fs::path path = directory / ".lock";
    file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file_ < 0) throw std::runtime_error("cannot write " + path.string() + ": " + std::strerror(errno));
    if (::flock(file_, LOCK_EX | LOCK_NB) == 0) return;
    ::close(file_);
    throw InputError(directory.string() + ": expected a directory without another writer, found one in use");
  }
  ~DirectoryLock() { ::close(file_); }
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

 private:
  int file_ = -1;
};

std::string fingerprint_in(const fs::path& directory) {
  std::ifstream in = open_to_read(directory / kManifest);
  const Json json = parse_shallow<Json>(in);
  return json_value::as<std::string>(json.is_object() && json.contains("fingerprint") ? json["fingerprint"] : Json())
      .value_or("");
}

/// Writes dataset.yaml and its scenarios, so that the directory is self-contained.
void record_configuration(const DatasetPlan& plan, const fs::path& directory) {
  DatasetConfig config = plan.config;
  make_inner_directory(directory / "scenarios");
  for (FamilyConfig& family : config.families) {
    const std::string name = "scenarios/" + family.name + ".yaml";
    write_file(directory / name, write_scenario(load_scenario(family.scenario)));
    family.scenario = name;
  }
  write_file(directory / "dataset.yaml", write_dataset(config));
}

/// True for a generation that was killed before its first manifest, with only files that are written again. It creates
/// `sequences` first; a folder with only a dataset.yaml belongs to the user.
bool is_begun(const fs::path& directory) {
  std::error_code missing;
  if (!fs::is_empty(directory / "sequences", missing) || missing) return false;
  const std::set<std::string> known_names = {".lock",        "sequences",         "scenarios",
                                             "dataset.yaml", "dataset.yaml.part", "manifest.json.part"};
  for (const auto& entry : fs::directory_iterator(directory)) {
    if (!known_names.contains(entry.path().filename().string())) return false;
  }
  return true;
}

void open_directory(const DatasetPlan& plan, const GenerateOptions& options) {
  const fs::path& directory = options.directory;
  if (fs::exists(directory / kManifest)) {
    if (!options.resume) {
      throw InputError(directory.string() +
                       ": expected a new name or an empty directory, found a dataset; continue it with --resume");
    }
    if (fingerprint_in(directory) != plan.fingerprint) {
      throw InputError(directory.string() +
                       ": expected a dataset of the same configuration and version, found another one (see its "
                       "dataset.yaml); nothing was changed");
    }
    return;
  }
  const bool begun = options.resume && is_begun(directory);
  if (!begun && fs::exists(directory) && (!fs::is_directory(directory) || !fs::is_empty(directory))) {
    throw InputError(
        directory.string() +
        ": expected a new name, an empty directory or a dataset, found something else; it was left as it is");
  }
  make_directory(directory);
  make_inner_directory(directory / "sequences");
  record_configuration(plan, directory);
  write_file(directory / kManifest, manifest_json(plan, {}, {}, false));
}

/// Removes files of killed workers.
void remove_partial(const DatasetPlan& plan, const fs::path& directory) {
  for (const Flight& flight : plan.flights) {
    for (int i = 0; i < flight.num_sequences; ++i)
      fs::remove_all(directory / "sequences" / ("." + sequence_name(flight.first_sequence + i) + ".partial"));
  }
}

bool is_finished(const Flight& flight, const fs::path& directory) {
  for (int i = 0; i < flight.num_sequences; ++i) {
    if (!fs::exists(directory / "sequences" / sequence_name(flight.first_sequence + i) / "sequence.json")) return false;
  }
  return true;
}

std::vector<SequenceInfo> read_sequences(const DatasetPlan& plan, const fs::path& directory) {
  std::vector<SequenceInfo> sequences;
  for (const Flight& flight : plan.flights) {
    for (int i = 0; i < flight.num_sequences; ++i) {
      sequences.push_back(read_sequence_info(directory / "sequences" / sequence_name(flight.first_sequence + i)));
      if (sequences.back().fingerprint != plan.fingerprint) {
        throw std::runtime_error("sequence " + sequence_name(flight.first_sequence + i) +
                                 " belongs to another dataset");
      }
    }
  }
  return sequences;
}

/// All files outside the sequences, and the description of each sequence.
std::vector<FileEntry> write_descriptions(const DatasetPlan& plan, const std::vector<SequenceInfo>& sequences,
                                          const fs::path& directory) {
  write_file(directory / "semantic-kitti.yaml", class_table(plan, sequences));
  write_data_card(plan, sequences, directory);
  std::vector<FileEntry> files;
  for (const FileEntry& file : list_files(directory, {}, "sequences")) {
    if (file.path != kManifest && file.path != ".lock") files.push_back(file);
  }
  for (const SequenceInfo& info : sequences) {
    const std::string name = "sequences/" + sequence_name(info.sequence) + "/sequence.json";
    files.push_back({name, fs::file_size(directory / name), hex(hash_of_file(directory / name))});
  }
  return files;
}

std::vector<Job> unfinished(const DatasetPlan& plan, const fs::path& directory) {
  std::vector<Job> jobs;
  for (const Flight& flight : plan.flights) {
    if (!is_finished(flight, directory))
      jobs.push_back({static_cast<std::uint64_t>(flight.number), static_cast<std::uint64_t>(flight.number)});
  }
  return jobs;
}

/// Writes all that describes the finished sequences, and returns them.
std::vector<SequenceInfo> complete_dataset(const DatasetPlan& plan, const fs::path& directory) {
  std::vector<SequenceInfo> sequences = read_sequences(plan, directory);
  const std::vector<FileEntry> files = write_descriptions(plan, sequences, directory);
  write_file(directory / kManifest, manifest_json(plan, sequences, files, true));
  std::error_code ignored;
  fs::remove(directory / ".lock", ignored);
  return sequences;
}

}  // namespace

GenerateReport generate_dataset(const DatasetPlan& plan, const GenerateOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  open_directory(plan, options);
  const DirectoryLock lock(options.directory);
  make_inner_directory(options.directory / "sequences");  // an existing one may be a link, which throws
  remove_partial(plan, options.directory);

  const std::vector<Job> jobs = unfinished(plan, options.directory);
  GenerateReport report;
  report.flights_all = static_cast<int>(plan.flights.size());
  report.flights_done = report.flights_all - static_cast<int>(jobs.size());

  const int workers = std::max(1, std::min(options.jobs, static_cast<int>(jobs.size())));
  const int threads = std::max(1, available_processors() / workers);
  WorkerPoolOptions pool;
  pool.workers = workers;
  std::string failure;
  // Stop at the first failure: further attempts on a full disk fail as well.
  pool.canceled = [&] { return !failure.empty() || (options.canceled && options.canceled()); };
  WorkerPoolEvents events;
  events.finished = [&](const JobResult& result) {
    if (result.status != JobStatus::kDone) {
      if (failure.empty()) {
        failure = "flight " + std::to_string(result.id) + " " + name_of(result.status) + ": " + result.message;
      }
      return;
    }
    ++report.flights_done;
    std::array<double, 4> s{};
    std::memcpy(s.data(), result.bytes.data(), std::min(sizeof s, result.bytes.size()));
    report.timing.add({s[0], s[1], s[2], s[3]});
    if (options.progress) options.progress(report.flights_done, report.flights_all, "");
  };
  events.idle = [&](int) {
    if (options.progress) options.progress(report.flights_done, report.flights_all, "");
  };
  const auto work = [&](std::uint64_t job) {
    const FlightTiming timing = write_flight(plan, plan.flights[job], options.directory, threads);
    const std::array s = {timing.prepare_s, timing.simulate_s, timing.record_s, timing.beside_s};
    return std::string(reinterpret_cast<const char*>(s.data()), sizeof s);
  };
  const bool complete = jobs.empty() || run_jobs(jobs, work, pool, events);
  if (!failure.empty()) {
    throw std::runtime_error(failure + " (" + std::to_string(report.flights_done) + " of " +
                             std::to_string(report.flights_all) +
                             " flights are finished and kept; continue with --resume)");
  }
  report.canceled = !complete;
  if (!report.canceled) report.sequences = complete_dataset(plan, options.directory);
  report.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

std::string manifest_json(const DatasetPlan& plan, const std::vector<SequenceInfo>& sequences,
                          const std::vector<FileEntry>& files, bool complete) {
  Json json;
  json["dataset"] = plan.config.name;
  json["description"] = plan.config.description;
  json["complete"] = complete;
  json["version"] = version();
  json["revision"] = git_revision();
  json["fingerprint"] = plan.fingerprint;
  Json& splits = json["splits"] = Json::object();
  for (const SplitConfig& split : plan.config.splits) {
    splits[split.name] = {{"first_seed", split.first_seed}, {"flights", split.flights}};
  }
  Json list = Json::array(), all = Json::array();
  const auto add = [&](const std::string& prefix, const FileEntry& file) {
    all.push_back({{"path", prefix + file.path}, {"bytes", file.bytes}, {"xxh128", file.xxh128}});
  };
  for (const FileEntry& file : files) add("", file);
  for (const SequenceInfo& info : sequences) {
    list.push_back({{"sequence", sequence_name(info.sequence)},
                    {"split", info.split},
                    {"flight", info.flight},
                    {"seed", info.seed},
                    {"attempt", info.attempt},
                    {"family", info.family},
                    {"vehicle", info.vehicle},
                    {"sensor", info.sensor},
                    {"frames", info.statistics.frames},
                    {"points", info.statistics.points},
                    {"state_hash", info.state_hash}});
    for (const FileEntry& file : info.files) add("sequences/" + sequence_name(info.sequence) + "/", file);
  }
  json["sequences"] = std::move(list);
  json["files"] = std::move(all);
  return json.dump(1) + "\n";
}

}  // namespace swiftlet::sim
