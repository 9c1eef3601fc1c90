// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/scenario/config_files.hpp"

/// A small configuration that uses every method of ConfigVisitor, and files that exist only in memory. Shared by the
/// tests of the reader and its fuzz target.
namespace swiftlet::sim {

struct EngineConfig : ModuleConfigOf<EngineConfig> {
  double power_kW = 1.5;
  int cylinders = 4;

  void visit(ConfigVisitor& v) override {
    v.field("power_kW", power_kW, "[kW] at full throttle", Range::positive());
    v.field("cylinders", cylinders, "[-] of the engine", Range::between(1, 16));
  }
};

struct SailConfig : ModuleConfigOf<SailConfig> {
  double area_m2 = 12.0;

  void visit(ConfigVisitor& v) override { v.field("area_m2", area_m2, "[m^2] of the sail", Range::positive()); }
};

inline std::span<const ModuleType> drive_types() {
  static const ModuleType kTypes[] = {{"engine", "burns something", make_module_config<EngineConfig>},
                                      {"sail", "catches the wind", make_module_config<SailConfig>}};
  return kTypes;
}

struct PilotConfig : ModuleConfigOf<PilotConfig> {
  std::string model;
  std::string name;
  double reaction_s = 0.3;
  Module drive{drive_types(), "engine"};

  void visit(ConfigVisitor& v) override {
    v.model("model", model, "pilots", "[-] preset");
    v.field("name", name, "[-] of the pilot");
    v.field("reaction_s", reaction_s, "[s] until something is done", Range::non_negative());
    v.module("drive", drive, drive_types(), "[-] what the pilot holds");
  }
};

inline std::span<const ModuleType> pilot_types() {
  static const ModuleType kTypes[] = {{"pilot", "a person", make_module_config<PilotConfig>},
                                      {"sail", "a sail of its own", make_module_config<SailConfig>}};
  return kTypes;
}

struct NoiseConfig {
  double sigma_range_m = 0.02;
  double drop_probability = 0.0;

  void visit(ConfigVisitor& v) {
    v.field("sigma_range_m", sigma_range_m, "[m] standard deviation of the range", Range::non_negative());
    v.field("drop_probability", drop_probability, "[-] chance that a return is lost", Range::probability());
  }
};

struct BoatConfig {
  std::string model;
  std::string name;
  double rate_hz = 10.0;
  double tilt_deg = 0.0;
  double speed_mps = 1.0;
  double drag_N_per_mps = 0.5;
  int width_px = 640;
  Eigen::Vector3d position_m = {1.0, 2.0, 3.0};
  NoiseConfig noise;
  std::vector<Module> crew;
  Module drive{drive_types(), "engine"};

  void visit(ConfigVisitor& v) {
    v.model("model", model, "boats", "[-] preset");
    v.field("name", name, "[-] of the boat");
    v.field("rate_hz", rate_hz, "[Hz] of the sensor", Range::positive());
    v.field("tilt_deg", tilt_deg, "[deg] of the sensor");
    v.field("speed_mps", speed_mps, "[m/s] cruise", Range{-10.0, 10.0, true, true});
    v.field("drag_N_per_mps", drag_N_per_mps, "[N/(m/s)] in water", Range::non_negative());
    v.field("width_px", width_px, "[px] of the picture", Range::between(16, 4096));
    v.field("position_m", position_m, "[m] at the start");
    v.object("noise", noise, "of the sensor");
    v.modules("crew", crew, pilot_types(), "[-] aboard");
    v.module("drive", drive, drive_types(), "[-] propulsion");
  }
};

struct FleetConfig {
  bool racing = false;
  std::uint64_t seed = 1;
  std::string title = "fleet";
  std::string sky = "clear";
  std::string chart;
  double low = 0.0;
  double high = 1.0;
  Eigen::Vector2d size_m = {10.0, 20.0};
  std::vector<double> times_s = {1.0, 2.0, 3.0};
  std::vector<std::string> tags;
  std::vector<Eigen::Vector3d> buoys_m;
  std::vector<BoatConfig> boats = std::vector<BoatConfig>(2);

  void visit(ConfigVisitor& v) {
    v.field("racing", racing, "[-] or cruising");
    v.field("seed", seed, "[-] of the weather");
    v.field("title", title, "[-] of the regatta");
    v.choice("sky", sky, {"clear", "cloudy", "overcast"}, "[-] weather");
    v.file("chart", chart, "[-] of the water");
    v.field("low", low, "[-] lower end");
    v.field("high", high, "[-] upper end");
    v.field("size_m", size_m, "[m] of the water", Range::positive());
    v.field("times_s", times_s, "[s] of the start signals", Range::between(0.0, std::numeric_limits<double>::max()));
    v.field("tags", tags, "[-] free words");
    v.field("buoys_m", buoys_m, "[m] to go round");
    v.list("boats", boats, "in the order of their numbers");
    v.check(low < high, "low", "less than high");
    for (std::size_t i = 1; i < boats.size(); ++i) {
      const bool same = !boats[i].name.empty() && boats[i].name == boats[i - 1].name;
      v.check(!same, ("boats[" + std::to_string(i) + "].name").c_str(), "another name than the boat before");
    }
  }
};

/// Files by path; assets lie below /assets, scenarios below /scenarios.
class MemoryFiles final : public ConfigFiles {
 public:
  using Map = std::map<std::string, std::string>;
  explicit MemoryFiles(Map files = {}) : files_(std::move(files)) {}

  bool is_file(const std::filesystem::path& path) const override { return files_.contains(key(path)); }
  std::string read(const std::filesystem::path& path) const override {
    const auto file = files_.find(key(path));
    if (file == files_.end()) throw std::runtime_error(path.string() + ": cannot be read");
    return file->second;
  }
  std::vector<std::string> list(const std::filesystem::path& folder) const override {
    std::vector<std::string> names;
    for (const auto& [path, text] : files_) {
      const std::filesystem::path file(path);
      if (file.parent_path() == folder.lexically_normal()) names.push_back(file.filename().string());
    }
    return names;
  }
  std::vector<std::filesystem::path> asset_roots() const override { return {"/assets"}; }
  std::vector<std::filesystem::path> scenario_roots() const override { return {"/scenarios"}; }

 private:
  static std::string key(const std::filesystem::path& path) { return path.lexically_normal().string(); }

  Map files_;
};

/// Files that the corpus of the fuzz target may name.
inline MemoryFiles example_files() {
  return MemoryFiles({
      {"/in/calm.yaml", "title: calm\nboats:\n  - {name: first, rate_hz: 5}\n  - {name: second, crew: [pilot]}\n"},
      {"/in/circle.yaml", "base: circle.yaml\n"},
      {"/in/broken.yaml", "title: [\n"},
      {"/in/chart.csv", "x\n"},
      {"/in/own.yaml", "rate_hz: 7\n"},
      {"/scenarios/storm.yaml", "base: /in/calm.yaml\nsky: overcast\n"},
      {"/assets/boats/dinghy.yaml",
       "# A small boat. With a sail.\nrate_hz: 20\nnoise: {sigma_range_m: 0.1, drop_probability: 0.25}\n"
       "drive: {type: sail, area_m2: 7}\ncrew: [{type: pilot, name: ann}, {type: pilot, name: bob}]\n"},
      {"/assets/boats/leaky.yaml", "rate_hz: -1\nsigma: 2\n"},
      {"/assets/boats/raft.yaml", "base: dinghy.yaml\nrate_hz: 2\n"},
      {"/assets/boats/vain.yaml", "model: dinghy\n"},
      {"/assets/pilots/ann.yaml", "type: pilot\nname: ann\nreaction_s: 0.1\n"},
      {"/assets/pilots/wind.yaml", "type: sail\narea_m2: 3\n"},
  });
}

}  // namespace swiftlet::sim
