// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/batch_plan.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "sim/batch/change_places.hpp"
#include "sim/batch/sweep.hpp"
#include "swiftlet/sim/batch/shell.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/scenario/config_files.hpp"
#include "swiftlet/sim/scenario/document.hpp"
#include "swiftlet/sim/scenario/loader.hpp"
#include "swiftlet/sim/scenario/units.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

std::string hash_text(const std::string& text) { return hex64(XXH3_64bits(text.data(), text.size())); }

/// A scenario file relative to the batch file, otherwise a scenario by name. A batch may have the name of its scenario.
std::string find_scenario(const std::string& name, const fs::path& batch_file) {
  for (const char* extension : {"", ".yaml"}) {
    const fs::path beside = batch_file.parent_path() / (name + extension);
    std::error_code ignored;
    if (fs::is_regular_file(beside, ignored) && !fs::equivalent(beside, batch_file, ignored))
      return beside.lexically_normal().string();
  }
  return name;
}

std::vector<std::uint64_t> seeds_of(const SeedsConfig& config, std::size_t num_points) {
  std::vector<std::uint64_t> seeds;
  for (const std::string& text : config.list) seeds.push_back(std::strtoull(text.c_str(), nullptr, 10));
  if (seeds.empty()) {
    const std::size_t count =
        config.pairing == SeedsConfig::Pairing::kZip ? num_points : static_cast<std::size_t>(config.count);
    seeds.resize(count);
    std::iota(seeds.begin(), seeds.end(), config.first);
  }
  if (config.pairing == SeedsConfig::Pairing::kZip && seeds.size() != num_points) {
    throw InputError("seeds.list: expected as many seeds as the sweep has points (" + std::to_string(num_points) +
                     ") with pairing \"zip\", found " + std::to_string(seeds.size()));
  }
  if (std::set<std::uint64_t>(seeds.begin(), seeds.end()).size() != seeds.size()) {
    throw InputError("seeds.list: expected every seed once");
  }
  return seeds;
}

/// The part of a scenario that an episode shares with others: without seed, outputs and name.
std::string meaning(Scenario scenario) {
  scenario.seed = 0;
  scenario.name = "episode";
  scenario.description.clear();
  scenario.recorders.clear();
  scenario.snapshots.clear();
  return write_scenario(scenario);
}

/// Hashes of the files named by a resolved scenario; their paths are absolute.
void add_files(const Node& node, std::map<std::string, std::string>& hashes) {
  std::error_code ignored;
  if (node.is_scalar() && node.text.starts_with('/') && fs::is_regular_file(node.text, ignored)) {
    hashes[node.text] = hash_text(system_files().read(node.text));
  }
  for (const Node& item : node.items) add_files(item, hashes);
  for (const Entry& entry : node.entries) add_files(entry.value, hashes);
}

bool is_number(const std::string& text) { return parse_quantity(text).has_value(); }

}  // namespace

BatchPlan::BatchPlan(const fs::path& file, const ConfigChanges& overrides) {
  config_ = load_batch_config(file, overrides);
  file_ = fs::absolute(Loader(system_files()).path_of(file)).lexically_normal();
  if (config_.variants.empty()) config_.variants.push_back({config_.name, "", {}});
  try {
    points_ = sweep_points(config_.sweep);
    seeds_ = seeds_of(config_.seeds, points_.size());
  } catch (const InputError& error) {
    throw InputError(file_.string() + ": " + error.what());
  }
  for (const VariantConfig& variant : config_.variants) {
    scenarios_.push_back(find_scenario(variant.scenario.empty() ? config_.scenario : variant.scenario, file_));
  }
  try {
    fingerprint_ = make_fingerprint();
  } catch (const InputError& error) {  // a change by `set` or the sweep that a scenario does not accept
    const std::string message = with_places_of_changes(error.what(), Loader(system_files()).load(file));
    throw InputError(message == error.what() ? file_.string() + ": " + message : message);
  }
  for (std::size_t v = 0; v < scenarios_.size(); ++v) {
    const bool is_swept = std::any_of(config_.sweep.parameters.begin(), config_.sweep.parameters.end(),
                                      [](const ParameterConfig& p) { return p.key == "world_seed"; });
    world_is_fixed_.push_back(is_swept || scenario_of(episode(v)).world_seed != 0);
  }
}

std::uint64_t BatchPlan::num_episodes() const {
  const std::uint64_t pairs =
      config_.seeds.pairing == SeedsConfig::Pairing::kZip ? points_.size() : points_.size() * seeds_.size();
  return pairs * config_.variants.size();
}

Episode BatchPlan::episode(std::uint64_t id) const {
  Episode episode;
  episode.id = id;
  episode.variant = id % config_.variants.size();
  const std::uint64_t pair = id / config_.variants.size();
  const bool zip = config_.seeds.pairing == SeedsConfig::Pairing::kZip;
  episode.point = zip ? pair : pair / seeds_.size();
  episode.seed = seeds_.at(zip ? pair : pair % seeds_.size());
  return episode;
}

ConfigChanges BatchPlan::changes_of(const Episode& episode) const {
  ConfigChanges changes = config_.set;
  const ConfigChanges& of_variant = config_.variants[episode.variant].set;
  changes.insert(changes.end(), of_variant.begin(), of_variant.end());
  for (std::size_t i = 0; i < config_.sweep.parameters.size(); ++i) {
    changes.emplace_back(config_.sweep.parameters[i].key, points_[episode.point][i]);
  }
  changes.emplace_back("seed", std::to_string(episode.seed));
  return changes;
}

Scenario BatchPlan::scenario_of(const Episode& episode) const {
  return load_scenario(scenarios_[episode.variant], changes_of(episode));
}

std::string BatchPlan::command_of(const Episode& episode) const {
  std::string command = "swiftlet run " + in_shell_quotes(scenarios_[episode.variant]);
  for (const auto& [key, value] : changes_of(episode)) {
    command += key == "seed" ? " --seed " + value : " --set " + in_shell_quotes(key + "=" + value);
  }
  return command;
}

std::uint64_t BatchPlan::group_of(const Episode& episode) const {
  std::string of_world;
  for (std::size_t i = 0; i < config_.sweep.parameters.size(); ++i) {
    if (config_.sweep.parameters[i].key.starts_with("world")) of_world += points_[episode.point][i] + "\n";
  }
  if (!world_is_fixed_[episode.variant]) of_world += std::to_string(episode.seed);
  return XXH3_64bits(of_world.data(), of_world.size());
}

std::vector<std::uint64_t> BatchPlan::episodes_of(const Shard& shard) const {
  std::map<std::uint64_t, std::size_t> order;  // groups by first appearance
  std::vector<std::pair<std::size_t, std::uint64_t>> sorted;
  for (std::uint64_t id = 0; id < num_episodes(); ++id) {
    sorted.emplace_back(order.emplace(group_of(episode(id)), order.size()).first->second, id);
  }
  std::sort(sorted.begin(), sorted.end());
  const std::uint64_t n = sorted.size();
  const auto count = static_cast<std::uint64_t>(shard.count), index = static_cast<std::uint64_t>(shard.index);
  std::vector<std::uint64_t> ids;
  for (std::uint64_t i = index * n / count; i < (index + 1) * n / count; ++i) ids.push_back(sorted[i].second);
  return ids;
}

// Applies every word (a model, a type) of a swept key alone to every variant, since it may refer to further files, but
// only the first and the last of swept numbers, so that errors appear before any flight.
std::string BatchPlan::make_fingerprint() const {
  std::string text;
  std::map<std::string, std::string> files;
  const auto add = [&](const std::string& scenario, const ConfigChanges& changes) {
    const std::string resolved = meaning(load_scenario(scenario, changes));
    text += resolved;
    add_files(parse_document(resolved, {"resolved", "."}), files);
  };
  for (std::size_t v = 0; v < config_.variants.size(); ++v) {
    ConfigChanges base = config_.set;
    base.insert(base.end(), config_.variants[v].set.begin(), config_.variants[v].set.end());
    text += "variant " + config_.variants[v].name + "\n";
    add(scenarios_[v], base);
    for (std::size_t p = 0; p < config_.sweep.parameters.size(); ++p) {
      std::set<std::string> values;
      for (const auto& point : points_) {
        if (!is_number(point[p])) values.insert(point[p]);
      }
      values.insert({points_.front()[p], points_.back()[p]});
      for (const std::string& value : values) {
        ConfigChanges changes = base;
        changes.emplace_back(config_.sweep.parameters[p].key, value);
        add(scenarios_[v], changes);
      }
    }
  }
  for (const auto& [path, hash] : files) text += "file " + hash + "\n";
  for (const ParameterConfig& parameter : config_.sweep.parameters)
    text += "parameter " + parameter.key + " " + parameter.name + "\n";
  for (const auto& point : points_) {
    for (const std::string& value : point) text += value + " ";
    text += "\n";
  }
  text += SeedsConfig::kPairings[static_cast<std::size_t>(config_.seeds.pairing)];
  for (const std::uint64_t seed : seeds_) text += " " + std::to_string(seed);
  return hash_text(text);
}

}  // namespace swiftlet::sim
