// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/dataset/verify.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>

#include "sim/dataset/frame.hpp"
#include "sim/dataset/hash.hpp"
#include "sim/dataset/sequence_recorder.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/dataset/generate.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/shallow_json.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// [-] Number of frames above which the description of a sequence is rejected as corrupt.
constexpr std::int64_t kMaxFrames = 100'000'000;
/// [-] Maximum number of problems in a report; further ones are left out.
constexpr std::size_t kMaxProblems = 50;
/// [-] Numbers in a line of poses.txt: a 3 x 4 matrix, row by row.
constexpr int kPoseNumbers = 12;

std::string read_text(const fs::path& path) {
  if (!fs::is_regular_file(path)) return {};  // opening a FIFO would block
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::int64_t count_files(const fs::path& folder) {
  if (!fs::is_directory(folder)) return 0;
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

/// True for a relative path that cannot leave its base directory.
bool stays_within(const fs::path& path) {
  return path.is_relative() && path.native().find('\0') == std::string::npos && !path.empty() &&
         std::find(path.begin(), path.end(), "..") == path.end();
}

/// Count of numbers in a line, separated by single blanks; nullopt when the line contains anything else.
std::optional<int> count_numbers(std::string_view line) {
  int count = 0;
  while (!line.empty()) {
    const std::size_t end = std::min(line.find(' '), line.size());
    double value = 0.0;
    const auto [stop, problem] = std::from_chars(line.data(), line.data() + end, value);
    if (problem != std::errc() || stop != line.data() + end) return std::nullopt;
    ++count;
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return count;
}

bool is_known_label(std::uint16_t label) {
  static const std::set<std::uint16_t> known = [] {
    std::set<std::uint16_t> labels = {0, static_cast<std::uint16_t>(SurfaceClass::kVehicle)};
    for (const char* name : static_class_names()) labels.insert(static_cast<std::uint16_t>(*surface_class_of(name)));
    return labels;
  }();
  return known.contains(label);
}

class Verification {
 public:
  Verification(fs::path directory, const VerifyOptions& options)
      : directory_(std::move(directory)), options_(options) {}

  VerifyReport run() {
    read_manifest();
    const auto complete = manifest_.find("complete");
    if (complete == manifest_.end() || *complete != true)
      problem("the dataset is not complete; continue with swiftlet dataset --resume");
    report_.poses_outside = poses_outside(sequences_);
    check_files();
    for (const SequenceInfo& info : sequences_) check_layout(info);
    // Files with wrong hashes would also fail the re-simulation.
    if (report_.ok() && options_.frames > 0) resimulate();
    return report_;
  }

 private:
  void problem(const std::string& text) {
    if (report_.problems.size() < kMaxProblems) report_.problems.push_back(text);
  }

  bool canceled() const { return options_.canceled && options_.canceled(); }
  void report_progress(double done, const std::string& note) const {
    if (options_.progress) options_.progress(done, note);
  }

  void read_manifest() {
    const fs::path path = directory_ / "manifest.json";
    if (!fs::exists(path)) throw InputError(directory_.string() + ": expected a dataset, found no manifest.json");
    manifest_ = parse_shallow<Json>(read_text(path));
    const auto is_list = [&](const char* key) { return manifest_.contains(key) && manifest_.at(key).is_array(); };
    const auto has = [](const Json& entry, const char* key) { return entry.is_object() && entry.contains(key); };
    const std::string place = path.string() + ": ";
    if (!manifest_.is_object() || !is_list("files") || !is_list("sequences") ||
        !std::all_of(manifest_.at("files").begin(), manifest_.at("files").end(), [&](const Json& file) {
          return has(file, "path") && file["path"].is_string() && has(file, "bytes") &&
                 file["bytes"].is_number_unsigned() && has(file, "xxh128") && file["xxh128"].is_string();
        })) {
      throw InputError(place +
                       "expected the manifest of a dataset with the lists files and sequences, found something else");
    }
    for (const Json& file : manifest_.at("files")) {
      const auto name = file["path"].get<std::string>();
      if (!stays_within(name))
        throw InputError(place + "files: expected paths within the dataset, found \"" + name + "\"");
    }
    if (manifest_.at("sequences").empty()) problem("manifest.json: expected a dataset with sequences, found none");
    for (const Json& sequence : manifest_.at("sequences")) {
      try {
        read_sequence(sequence);
      } catch (const InputError& error) {
        problem(error.what());
      }
    }
  }

  void read_sequence(const Json& entry) {
    const auto text_at = [](const Json& json, const std::string& key) {
      try {
        return json_at<std::string>(json, key);
      } catch (const InputError& error) {
        throw InputError(std::string("manifest.json: ") + error.what());
      }
    };
    const std::string fingerprint = text_at(manifest_, "fingerprint"), state_hash = text_at(entry, "state_hash");
    const std::string name = text_at(entry, "sequence");
    const auto number = number_in<int>(name);
    if (!number || sequence_name(*number) != name)
      throw InputError("manifest.json: sequences: expected a number such as 07, found \"" + name + "\"");
    SequenceInfo info = read_sequence_info(directory_ / "sequences" / name);
    const std::string place = "sequences/" + name + "/sequence.json: ";
    if (info.instance < 1 || static_cast<std::size_t>(info.instance) > info.vehicles.size() ||
        info.statistics.frames < 0 || info.statistics.frames > kMaxFrames) {
      return problem(place + "expected instance 1 to " + std::to_string(info.vehicles.size()) + " and 0 to " +
                     std::to_string(kMaxFrames) + " frames, found instance " + std::to_string(info.instance) + " and " +
                     std::to_string(info.statistics.frames) + " frames");
    }
    if (info.sequence != *number) {
      return problem(place + "expected sequence " + name + ", found " + sequence_name(info.sequence));
    }
    if (info.fingerprint != fingerprint || info.state_hash != state_hash)
      problem(place + "belongs to another dataset: its fingerprint or state_hash differs from manifest.json");
    sequences_.push_back(std::move(info));
  }

  void check_files() {
    std::set<std::string> listed = {"manifest.json", ".lock"};
    const std::size_t all = manifest_.at("files").size();
    for (const Json& file : manifest_.at("files")) {
      if (canceled()) return;
      const auto name = file["path"].get<std::string>();
      listed.insert(name);
      check_file(name, file["bytes"].get<std::uint64_t>(), file["xxh128"].get<std::string>());
      ++report_.files;
      if (report_.files % 64 == 0) {
        report_progress(0.5 * static_cast<double>(report_.files) / static_cast<double>(all), "hashes");
      }
    }
    for (const auto& entry : fs::recursive_directory_iterator(directory_)) {
      if (entry.is_directory()) continue;
      const std::string name = entry.path().lexically_relative(directory_).generic_string();
      if (!listed.contains(name)) problem(name + ": not listed in manifest.json");
    }
  }

  void check_file(const std::string& name, std::uint64_t bytes, const std::string& hash) {
    const fs::path path = directory_ / name;
    std::error_code error;
    const std::uintmax_t size = fs::file_size(path, error);
    if (error) return problem(name + ": " + error.message());
    if (size != bytes) {
      return problem(name + ": expected " + std::to_string(bytes) + " bytes, found " + std::to_string(size));
    }
    try {
      const std::string found = hex(hash_of_file(path));
      if (found != hash) problem(name + ": expected the hash " + hash + ", found " + found);
    } catch (const std::exception& unreadable) {
      problem(unreadable.what());
    }
  }

  void check_layout(const SequenceInfo& info) {
    const fs::path root = directory_ / "sequences" / sequence_name(info.sequence);
    const std::string name = "sequences/" + sequence_name(info.sequence);
    const int frames = static_cast<int>(info.statistics.frames);
    report_.frames += frames;
    std::vector<const char*> folders = {"velodyne", "labels"};
    if (fs::exists(root / "point_truth")) folders.push_back("point_truth");
    if (fs::exists(root / "images")) folders.insert(folders.end(), {"images/range", "images/intensity"});
    std::int64_t most_files = 0;  // largest number of files in a folder; frames beyond it are not checked
    for (const char* folder : folders) {
      const std::int64_t found = count_files(root / folder);
      most_files = std::max(most_files, found);
      if (found != frames) {
        problem(name + "/" + folder + ": expected " + std::to_string(frames) + " files, found " +
                std::to_string(found));
      }
    }
    check_lines(root / "poses.txt", name + "/poses.txt", frames, kPoseNumbers);
    check_lines(root / "times.txt", name + "/times.txt", frames, 1);
    std::int64_t points = 0;
    for (int i = 0; i < std::min<std::int64_t>(frames, most_files) && !canceled(); ++i)
      points += check_frame(root, name, i);
    if (points != info.statistics.points) {
      problem(name + ": expected " + std::to_string(info.statistics.points) + " points, found " +
              std::to_string(points));
    }
    check_boxes(root / "boxes.csv", name + "/boxes.csv", frames, info);
  }

  void check_lines(const fs::path& path, const std::string& name, int lines, int numbers) {
    std::istringstream text(read_text(path));
    int count = 0;
    for (std::string line; std::getline(text, line); ++count) {
      if (count_numbers(line) != numbers) {
        return problem(name + ":" + std::to_string(count + 1) + ": expected " + std::to_string(numbers) + " numbers");
      }
    }
    if (count != lines)
      problem(name + ": expected " + std::to_string(lines) + " lines, found " + std::to_string(count));
  }

  /// @return number of points of the frame
  std::int64_t check_frame(const fs::path& root, const std::string& name, int frame) {
    const std::string scan = frame_file("velodyne", frame, "bin"), label = frame_file("labels", frame, "label");
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(root / scan, error);
    if (error) return 0;  // check_layout() reports missing files of the folder
    if (bytes % kPointBytes != 0)
      problem(name + "/" + scan + ": expected a multiple of " + std::to_string(kPointBytes) +
              " bytes (four float32 per point), found " + std::to_string(bytes) + " bytes");
    const std::string labels = read_text(root / label);
    const std::size_t points = bytes / kPointBytes;
    if (labels.size() != points * kLabelBytes) {
      problem(name + "/" + label + ": expected " + std::to_string(points) + " labels, found " +
              std::to_string(labels.size() / kLabelBytes));
    }
    for (std::size_t i = 0; i + kLabelBytes <= labels.size(); i += kLabelBytes) {
      std::uint16_t surface_class = 0;
      std::memcpy(&surface_class, labels.data() + i, sizeof surface_class);
      if (is_known_label(surface_class)) continue;
      problem(name + "/" + label + ": class " + std::to_string(surface_class) + " is not in the class table");
      break;
    }
    const fs::path truth = root / frame_file("point_truth", frame, "bin");
    if (fs::exists(truth) && fs::file_size(truth) != points * kPointTruthBytes) {
      problem(name + "/" + frame_file("point_truth", frame, "bin") + ": expected " + std::to_string(points) +
              " records");
    }
    return static_cast<std::int64_t>(points);
  }

  void check_boxes(const fs::path& path, const std::string& name, int frames, const SequenceInfo& info) {
    std::istringstream text(read_text(path));
    std::string line;
    std::getline(text, line);
    const std::size_t columns = static_cast<std::size_t>(std::count(line.begin(), line.end(), ','));
    int count = 0;
    for (int number = 2; std::getline(text, line); ++number, ++count) {
      int frame = -1;
      std::from_chars(line.data(), line.data() + line.size(), frame);
      if (frame < 0 || frame >= frames ||
          static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) != columns) {
        return problem(name + ":" + std::to_string(number) + ": expected " + std::to_string(columns + 1) +
                       " columns, the first a frame below " + std::to_string(frames));
      }
    }
    const std::int64_t expected = std::int64_t{frames} * (static_cast<std::int64_t>(info.vehicles.size()) - 1);
    if (count != expected) {
      problem(name + ": expected " + std::to_string(expected) + " boxes, found " + std::to_string(count));
    }
  }

  // Random frames of each sequence, drawn without replacement.
  std::map<std::size_t, std::set<int>> draw_frames() const {
    std::int64_t all = 0;
    for (const SequenceInfo& info : sequences_) all += info.statistics.frames;
    const auto wanted = static_cast<std::size_t>(std::min<std::int64_t>(options_.frames, all));
    const Random random(options_.seed, "dataset.verify", json_at<std::string>(manifest_, "fingerprint"));
    std::set<std::int64_t> drawn;
    for (std::uint32_t i = 0; drawn.size() < wanted; ++i) {
      drawn.insert(static_cast<std::int64_t>(random.uniform(i, 0) * static_cast<double>(all)));
    }
    std::map<std::size_t, std::set<int>> frames;
    for (std::int64_t frame : drawn) {
      std::size_t sequence = 0;
      while (frame >= sequences_[sequence].statistics.frames) frame -= sequences_[sequence++].statistics.frames;
      frames[sequence].insert(static_cast<int>(frame));
    }
    return frames;
  }

  void resimulate() {
    const ContentConfig content = load_dataset(directory_ / "dataset.yaml").content;
    const auto drawn = draw_frames();
    double done = 0.0;
    for (const auto& [sequence, frames] : drawn) {
      if (canceled()) return;
      report_progress(0.5 + 0.5 * done / static_cast<double>(drawn.size()),
                      "simulating sequence " + sequence_name(sequences_[sequence].sequence) + " again");
      resimulate(sequences_[sequence], content, frames);
      done += 1.0;
    }
  }

  void resimulate(const SequenceInfo& info, const ContentConfig& content, const std::set<int>& frames) {
    const fs::path root = directory_ / "sequences" / sequence_name(info.sequence);
    const PreparedFlight prepared = restore_flight(root, info);
    Simulation simulation(prepared.scenario, 0, prepared.world);
    const auto observer = static_cast<std::size_t>(info.instance - 1);
    std::int64_t num_scans = 0;
    const std::int64_t last_scan = std::int64_t{*frames.rbegin()} * content.every;
    Frame frame;
    while (!simulation.finished() && num_scans <= last_scan) {
      if (canceled()) return;
      simulation.tick();
      for (const auto& scan : simulation.view().scans[observer]) {
        if (scan->scan.sensor != info.sensor) continue;
        const std::int64_t number = num_scans++;
        const auto frame_number = static_cast<int>(number / content.every);
        if (number % content.every != 0 || !frames.contains(frame_number)) continue;
        encode_frame(*scan, content, frame);
        compare(root, frame_number, content, frame);
      }
    }
    if (num_scans <= last_scan) {
      problem("sequences/" + sequence_name(info.sequence) + ": the flight simulated again ends before frame " +
              std::to_string(*frames.rbegin()));
    }
  }

  void compare(const fs::path& root, int number, const ContentConfig& content, const Frame& frame) {
    const auto compare_file = [&](const std::string& file, const ByteBuffer& bytes) {
      const std::string stored = read_text(root / file);
      if (stored.size() == bytes.size() && std::memcmp(stored.data(), bytes.bytes().data(), bytes.size()) == 0) return;
      problem((root / file).lexically_relative(directory_).generic_string() + ": differs when simulated again");
    };
    compare_file(frame_file("velodyne", number, "bin"), frame.velodyne);
    compare_file(frame_file("labels", number, "label"), frame.labels);
    if (content.point_truth) compare_file(frame_file("point_truth", number, "bin"), frame.point_truth);
    ++report_.resimulated;
  }

  fs::path directory_;
  VerifyOptions options_;
  Json manifest_;
  std::vector<SequenceInfo> sequences_;
  VerifyReport report_;
};

}  // namespace

VerifyReport verify_dataset(const fs::path& directory, const VerifyOptions& options) {
  return Verification(directory, options).run();
}

}  // namespace swiftlet::sim
