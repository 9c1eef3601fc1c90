// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/dataset/sequence_info.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "sim/dataset/hash.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/shallow_json.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using RangeBin = SequenceStatistics::RangeBin;

constexpr const char* kFile = "sequence.json";

/// Largest plausible count of points or frames in a sequence; sums over many sequences stay far below 2^63.
constexpr std::int64_t kMaxCount = 1'000'000'000'000'000;

std::string expected_bins(std::size_t found) {
  return ": expected " + std::to_string(SequenceStatistics::kRangeBins) + " values, found " + std::to_string(found);
}

std::int64_t count_at(const Json& json, const std::string& key) {
  const auto count = json_at<std::int64_t>(json, key);
  if (count < -kMaxCount || count > kMaxCount)
    throw InputError(key + ": expected a count below 10^15, found " + std::to_string(count));
  return count;
}

const Json& object_at(const Json& json, const std::string& key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_object())
    throw InputError(key + ": expected an object, found " + (found == json.end() ? "nothing" : "something else"));
  return *found;
}

template <class Array, class Field>
Json column(const Array& bins, Field RangeBin::*field) {
  Json values = Json::array();
  for (const RangeBin& bin : bins) values.push_back(bin.*field);
  return values;
}

template <class Field>
void read_column(const Json& json, const char* key, std::array<RangeBin, SequenceStatistics::kRangeBins>& bins,
                 Field RangeBin::*field) {
  const auto values = json_at<std::vector<Field>>(json, key);
  if (values.size() < bins.size()) throw InputError(std::string(key) + expected_bins(values.size()));
  for (std::size_t i = 0; i < bins.size(); ++i) bins[i].*field = values[i];
}

Json json_of(const SequenceStatistics& s) {
  Json json;
  json["frames"] = s.frames;
  json["points"] = s.points;
  json["rows"] = s.rows;
  json["columns"] = s.columns;
  json["duration_s"] = s.duration_s;
  json["flown_m"] = s.flown_m;
  json["least_clearance_m"] = s.least_clearance_m;
  json["frames_walled"] = s.frames_walled;
  json["frames_outside"] = s.frames_outside;
  Json& classes = json["points_by_class"] = Json::object();
  for (const auto& [label, count] : s.points_by_class) classes[std::to_string(label)] = count;
  json["range_bin_m"] = SequenceStatistics::kRangeBin_m;
  json["points_by_range"] = s.points_by_range;
  Json& vehicles = json["vehicles_by_range"];
  vehicles["boxes"] = column(s.vehicles_by_range, &RangeBin::boxes);
  vehicles["in_view"] = column(s.vehicles_by_range, &RangeBin::in_view);
  vehicles["detected"] = column(s.vehicles_by_range, &RangeBin::detected);
  vehicles["well_detected"] = column(s.vehicles_by_range, &RangeBin::well_detected);
  vehicles["points"] = column(s.vehicles_by_range, &RangeBin::points);
  json["pixel_shift_by_row"] = s.pixel_shift_by_row;
  return json;
}

SequenceStatistics statistics_of(const Json& json) {
  SequenceStatistics s;
  s.frames = count_at(json, "frames");
  s.points = count_at(json, "points");
  s.rows = json_at<int>(json, "rows");
  s.columns = json_at<int>(json, "columns");
  s.duration_s = json_at<double>(json, "duration_s");
  s.flown_m = json_at<double>(json, "flown_m");
  s.least_clearance_m = json_at<double>(json, "least_clearance_m");
  // Optional, since earlier versions did not count them.
  if (json.contains("frames_walled")) s.frames_walled = count_at(json, "frames_walled");
  if (json.contains("frames_outside")) s.frames_outside = count_at(json, "frames_outside");
  const Json& classes = object_at(json, "points_by_class");
  for (const auto& [label, count] : classes.items()) {
    const auto number = number_in<std::uint16_t>(label);
    if (!number) throw InputError("points_by_class: expected a class number, found \"" + label + "\"");
    s.points_by_class[*number] = count_at(classes, label);
  }
  const auto by_range = json_at<std::vector<std::int64_t>>(json, "points_by_range");
  if (by_range.size() < s.points_by_range.size()) throw InputError("points_by_range" + expected_bins(by_range.size()));
  std::copy_n(by_range.begin(), s.points_by_range.size(), s.points_by_range.begin());
  const Json& vehicles = object_at(json, "vehicles_by_range");
  read_column(vehicles, "boxes", s.vehicles_by_range, &RangeBin::boxes);
  read_column(vehicles, "in_view", s.vehicles_by_range, &RangeBin::in_view);
  read_column(vehicles, "detected", s.vehicles_by_range, &RangeBin::detected);
  read_column(vehicles, "well_detected", s.vehicles_by_range, &RangeBin::well_detected);
  read_column(vehicles, "points", s.vehicles_by_range, &RangeBin::points);
  s.pixel_shift_by_row = json_at<std::vector<int>>(json, "pixel_shift_by_row");
  return s;
}

SequenceInfo sequence_of(const Json& json) {
  SequenceInfo info;
  const auto sequence = json_at<std::string>(json, "sequence");
  const auto number = number_in<int>(sequence);
  if (!number || *number < 0) throw InputError("sequence: expected a number, found \"" + sequence + "\"");
  info.sequence = *number;
  info.split = json_at<std::string>(json, "split");
  info.flight = json_at<int>(json, "flight");
  info.seed = json_at<std::uint64_t>(json, "seed");
  info.attempt = json_at<int>(json, "attempt");
  info.family = json_at<std::string>(json, "family");
  info.vehicle = json_at<std::string>(json, "vehicle");
  info.instance = json_at<int>(json, "instance");
  info.sensor = json_at<std::string>(json, "sensor");
  info.sensor_model = json_at<std::string>(json, "sensor_model");
  info.vehicles = json_at<std::vector<std::string>>(json, "vehicles");
  info.models = json_at<std::vector<std::string>>(json, "models");
  info.state_hash = json_at<std::string>(json, "state_hash");
  info.fingerprint = json_at<std::string>(json, "fingerprint");
  info.version = json_at<std::string>(json, "version");
  info.revision = json_at<std::string>(json, "revision");
  info.reflectivities = json_at<std::vector<double>>(json, "reflectivities");
  info.statistics = statistics_of(object_at(json, "statistics"));
  const auto files = json.find("files");
  if (files == json.end() || !files->is_array()) throw InputError("files: expected a list, found something else");
  for (const Json& file : *files) {
    info.files.push_back({json_at<std::string>(file, "path"), json_at<std::uint64_t>(file, "bytes"),
                          json_at<std::string>(file, "xxh128")});
  }
  return info;
}

}  // namespace

std::string to_json(const SequenceInfo& info) {
  Json json;
  json["sequence"] = sequence_name(info.sequence);
  json["split"] = info.split;
  json["flight"] = info.flight;
  json["seed"] = info.seed;
  json["attempt"] = info.attempt;
  json["family"] = info.family;
  json["vehicle"] = info.vehicle;
  json["instance"] = info.instance;
  json["sensor"] = info.sensor;
  json["sensor_model"] = info.sensor_model;
  json["vehicles"] = info.vehicles;
  json["models"] = info.models;
  json["state_hash"] = info.state_hash;
  json["fingerprint"] = info.fingerprint;
  json["version"] = info.version;
  json["revision"] = info.revision;
  json["reflectivities"] = info.reflectivities;
  json["statistics"] = json_of(info.statistics);
  Json& files = json["files"] = Json::array();
  for (const FileEntry& file : info.files) {
    files.push_back({{"path", file.path}, {"bytes", file.bytes}, {"xxh128", file.xxh128}});
  }
  return json.dump(1) + "\n";
}

SequenceInfo read_sequence_info(const fs::path& directory) {
  const fs::path path = directory / kFile;
  std::ifstream in = open_to_read(path);
  try {
    const Json json = parse_shallow<Json>(in);
    if (!json.is_object()) throw InputError("expected a JSON object, found something else");
    return sequence_of(json);
  } catch (const InputError& problem) {
    throw InputError(path.string() + ": not the description of a sequence: " + problem.what());
  }
}

std::string poses_outside(const std::vector<SequenceInfo>& sequences) {
  SequenceStatistics all;
  std::vector<std::pair<std::string, SequenceStatistics>> splits;
  for (const SequenceInfo& info : sequences) {
    if (info.statistics.frames_walled == 0) continue;
    if (splits.empty() || splits.back().first != info.split) splits.emplace_back(info.split, SequenceStatistics());
    splits.back().second.add(info.statistics);
    all.add(info.statistics);
  }
  if (splits.empty()) return {};
  const auto share = [](const SequenceStatistics& s) {
    return fmt::format("{:.1f} %",
                       100.0 * static_cast<double>(s.frames_outside) / static_cast<double>(s.frames_walled));
  };
  std::string text = share(all) + " of " + std::to_string(all.frames_walled) + " poses lie outside walls (";
  for (std::size_t i = 0; i < splits.size(); ++i) {
    text += (i > 0 ? ", " : "") + splits[i].first + " " + share(splits[i].second);
  }
  return text + ")";
}

std::vector<FileEntry> list_files(const fs::path& directory, std::vector<FileEntry> known, const std::string& without) {
  const auto by_path = [](const FileEntry& a, const FileEntry& b) { return a.path < b.path; };
  std::sort(known.begin(), known.end(), by_path);
  std::vector<FileEntry> files;
  for (fs::recursive_directory_iterator at(directory), end; at != end; ++at) {
    const fs::directory_entry& entry = *at;
    FileEntry file;
    file.path = entry.path().lexically_relative(directory).generic_string();
    if (entry.is_directory() && file.path == without) at.disable_recursion_pending();
    if (!entry.is_regular_file()) continue;
    if (file.path == kFile) continue;
    const auto found = std::lower_bound(known.begin(), known.end(), file, by_path);
    if (found != known.end() && found->path == file.path) {
      file = *found;
    } else {
      file.bytes = entry.file_size();
      file.xxh128 = hex(hash_of_file(entry.path()));
    }
    files.push_back(std::move(file));
  }
  std::sort(files.begin(), files.end(), by_path);
  return files;
}

std::string sequence_name(int sequence) { return fmt::format("{:02}", sequence); }

}  // namespace swiftlet::sim
