// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/recorder_paths.hpp"

#include <algorithm>

#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"

namespace swiftlet::sim {
namespace {

std::string element(std::size_t index, const std::string& key) {
  return "recorders[" + std::to_string(index) + "]." + key;
}

void check_vehicle(ConfigVisitor& v, const std::string& name, const std::vector<std::string>& known,
                   const std::string& key) {
  v.check(contains(known, name), key.c_str(), one_of(known) + did_you_mean(name, known));
}

/// True if every part of the path is a plain name, so that the path stays below the run directory.
bool is_output_path(const std::string& path) {
  if (path.size() > 255 || path.ends_with(".part")) return false;  // .part marks incomplete files
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    if (!is_file_name(std::string_view(path).substr(begin, end - begin))) return false;
    begin = end + 1;
  }
  return true;
}

/// True if `path` is the folder itself or inside it.
bool lies_in(const std::string& path, const std::string& folder) {
  return path == folder || path.starts_with(folder + "/");
}

/// True if two selections overlap. An empty selection contains all.
bool overlap(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  return a.empty() || b.empty() ||
         std::any_of(a.begin(), a.end(), [&](const std::string& name) { return contains(b, name); });
}

bool collide(const RecorderOutput& a, const RecorderOutput& b) {
  if (a.is_file || b.is_file) return lies_in(a.place, b.place) || lies_in(b.place, a.place);
  return a.place == b.place && a.kind == b.kind && overlap(a.vehicles, b.vehicles) && overlap(a.streams, b.streams);
}

}  // namespace

bool is_file_name(std::string_view name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  };
  return !name.empty() && name.size() <= 64 && name.front() != '.' && name.front() != '-' &&
         std::all_of(name.begin(), name.end(), allowed);
}

void check_recorders(ConfigVisitor& v, const std::vector<Module>& recorders, const std::vector<std::string>* vehicles) {
  std::vector<RecorderOutput> earlier = {{"", "summary.json", true, "", {}, {}},
                                         {"", "scenario.yaml", true, "", {}, {}}};
  for (std::size_t i = 0; i < recorders.size(); ++i) {
    const auto* config = dynamic_cast<const OutputProvider*>(recorders[i].config.get());
    if (config == nullptr) continue;
    const RecorderOutput output = config->output();
    const std::string key = element(i, output.key);
    for (std::size_t j = 0; vehicles != nullptr && j < output.vehicles.size(); ++j) {
      check_vehicle(v, output.vehicles[j], *vehicles, element(i, "vehicles") + "[" + std::to_string(j) + "]");
    }
    v.check(is_output_path(output.place), key.c_str(),
            "a path within the run directory, of names of letters, digits, '_', '-' and '.'");
    const auto taken = std::find_if(earlier.begin(), earlier.end(),
                                    [&](const RecorderOutput& other) { return collide(output, other); });
    v.check(taken == earlier.end(), key.c_str(),
            "files that nothing else writes; " + output.place + " is written already");
    earlier.push_back(output);
  }
}

}  // namespace swiftlet::sim
