// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/dataset/sequence_info.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "swiftlet/sim/dataset/hash.hpp"
#include "swiftlet/sim/io/shallow_json.hpp"
#include "swiftlet/sim/io/text.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using RangeBin = SequenceStatistics::RangeBin;

constexpr const char* kFile = "sequence.json";

template <class Array, class Field>
Json column(const Array& bins, Field RangeBin::*field) {
  Json values = Json::array();
  for (const RangeBin& bin : bins) values.push_back(bin.*field);
  return values;
}

template <class Field>
void read_column(const Json& json, std::array<RangeBin, SequenceStatistics::kRangeBins>& bins, Field RangeBin::*field) {
  for (std::size_t i = 0; i < bins.size(); ++i) bins[i].*field = json.at(i).get<Field>();
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
  s.frames = json.at("frames").get<std::int64_t>();
  s.points = json.at("points").get<std::int64_t>();
  s.rows = json.at("rows").get<int>();
  s.columns = json.at("columns").get<int>();
  s.duration_s = json.at("duration_s").get<double>();
  s.flown_m = json.at("flown_m").get<double>();
  s.least_clearance_m = json.at("least_clearance_m").get<double>();
  s.frames_walled = json.value("frames_walled", std::int64_t{0});  // earlier versions did not count them
  s.frames_outside = json.value("frames_outside", std::int64_t{0});
  for (const auto& [label, count] : json.at("points_by_class").items()) {
    const auto number = number_in<std::uint16_t>(label);
    if (!number) throw std::runtime_error("points_by_class: expected a class number, found \"" + label + "\"");
    s.points_by_class[*number] = count.get<std::int64_t>();
  }
  for (std::size_t i = 0; i < s.points_by_range.size(); ++i) {
    s.points_by_range[i] = json.at("points_by_range").at(i).get<std::int64_t>();
  }
  const Json& vehicles = json.at("vehicles_by_range");
  read_column(vehicles.at("boxes"), s.vehicles_by_range, &RangeBin::boxes);
  read_column(vehicles.at("in_view"), s.vehicles_by_range, &RangeBin::in_view);
  read_column(vehicles.at("detected"), s.vehicles_by_range, &RangeBin::detected);
  read_column(vehicles.at("well_detected"), s.vehicles_by_range, &RangeBin::well_detected);
  read_column(vehicles.at("points"), s.vehicles_by_range, &RangeBin::points);
  s.pixel_shift_by_row = json.at("pixel_shift_by_row").get<std::vector<int>>();
  return s;
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
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path.string());
  try {
    const Json json = parse_shallow<Json>(in);
    SequenceInfo info;
    const std::string sequence = json.at("sequence").get<std::string>();
    const auto number = number_in<int>(sequence);
    if (!number) throw std::runtime_error("sequence: expected a number, found \"" + sequence + "\"");
    info.sequence = *number;
    info.split = json.at("split").get<std::string>();
    info.flight = json.at("flight").get<int>();
    info.seed = json.at("seed").get<std::uint64_t>();
    info.attempt = json.at("attempt").get<int>();
    info.family = json.at("family").get<std::string>();
    info.vehicle = json.at("vehicle").get<std::string>();
    info.instance = json.at("instance").get<int>();
    info.sensor = json.at("sensor").get<std::string>();
    info.sensor_model = json.at("sensor_model").get<std::string>();
    info.vehicles = json.at("vehicles").get<std::vector<std::string>>();
    info.models = json.at("models").get<std::vector<std::string>>();
    info.state_hash = json.at("state_hash").get<std::string>();
    info.fingerprint = json.at("fingerprint").get<std::string>();
    info.version = json.at("version").get<std::string>();
    info.revision = json.at("revision").get<std::string>();
    info.reflectivities = json.at("reflectivities").get<std::vector<double>>();
    info.statistics = statistics_of(json.at("statistics"));
    for (const Json& file : json.at("files")) {
      info.files.push_back({file.at("path").get<std::string>(), file.at("bytes").get<std::uint64_t>(),
                            file.at("xxh128").get<std::string>()});
    }
    return info;
  } catch (const std::exception& error) {
    throw std::runtime_error(path.string() + ": not the description of a sequence: " + error.what());
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
