// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/slam_map/slam_map_recorder.hpp"

#include <algorithm>
#include <utility>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/slam_map/slam_map_file.hpp"

namespace swiftlet::sim {
namespace {

class SlamMapRecorder : public Recorder {
 public:
  explicit SlamMapRecorder(SlamMapConfig config) : config_(std::move(config)) {}

  void begin(const RunInfo& info) override {
    directory_ = info.directory;
    names_ = info.vehicle_names;
    for (const std::string& wanted : config_.vehicles) {
      if (std::find(names_.begin(), names_.end(), wanted) != names_.end()) continue;
      throw InputError("recorder slam_map: vehicles: expected the name of a vehicle, found '" + wanted + "'");
    }
  }

  void write(const TickView& tick) override {
    const bool first = providers_.empty();
    providers_.assign(tick.agents.size(), nullptr);
    for (std::size_t i = 0; i < tick.agents.size(); ++i)
      providers_[i] = dynamic_cast<const SavedMapProvider*>(tick.agents[i].get());
    if (first) require_providers();
  }

  std::vector<std::filesystem::path> finish() override {
    std::vector<std::filesystem::path> paths;
    for (std::size_t i = 0; i < providers_.size(); ++i) {
      if (!is_selected(i) || providers_[i] == nullptr) continue;
      const std::shared_ptr<const SavedMap> map = providers_[i]->saved_map();
      if (map == nullptr) continue;
      paths.push_back(std::filesystem::path(config_.folder) / (names_[i] + std::string(kSlamMapExtension)));
      write_file(directory_ / paths.back(), slam_map_content(*map), MissingFolders::kMade);
    }
    return paths;
  }

 private:
  bool is_selected(std::size_t i) const {
    return config_.vehicles.empty() ||
           std::find(config_.vehicles.begin(), config_.vehicles.end(), names_[i]) != config_.vehicles.end();
  }
  bool provides_map(std::size_t i) const { return providers_[i] != nullptr && providers_[i]->saved_map() != nullptr; }

  /// Checks that all named vehicles, or at least one if none is named, keep a map.
  void require_providers() const {
    bool any = false;
    for (std::size_t i = 0; i < providers_.size(); ++i) {
      any = any || provides_map(i);
      if (config_.vehicles.empty() || !is_selected(i) || provides_map(i)) continue;
      throw InputError("recorder slam_map: vehicles: expected localization: {type: slam, global: {enabled: true}} on " +
                       names_[i] + ", found another");
    }
    if (any) return;
    throw InputError(
        "recorder slam_map: expected a vehicle with localization: {type: slam, global: {enabled: true}}, found none");
  }

  SlamMapConfig config_;
  std::filesystem::path directory_;
  std::vector<std::string> names_;
  std::vector<const SavedMapProvider*> providers_;  // indexed by VehicleId; null: no map
};

}  // namespace

void SlamMapConfig::visit(ConfigVisitor& v) {
  v.field("vehicles", vehicles, "[-] names of the vehicles whose maps are written; empty: all that keep one");
  v.field("folder", folder, "[-] folder in the run directory");
}

std::unique_ptr<Recorder> make_slam_map_recorder(const ModuleConfig& config) {
  return std::make_unique<SlamMapRecorder>(dynamic_cast<const SlamMapConfig&>(config));
}

}  // namespace swiftlet::sim
