// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/render/render_config.hpp"

namespace swiftlet::sim {

/// One number or word of the scenario that is drawn for each flight.
struct VariationConfig {
  std::string key;  ///< key path in the scenario; `vehicles[*]` stands for each vehicle, with independent draws
  enum class Law { kUniform, kLogUniform, kWhole, kChoice };
  static constexpr const char* kLaws[] = {"uniform", "log_uniform", "whole", "choice"};
  Law law = Law::kUniform;
  double min = 0.0;
  double max = 1.0;
  std::vector<std::string> choices;

  void visit(ConfigVisitor& v);
};

/// Flights along planned paths through the free space of a world that the vehicles do not know in advance.
struct FlightConfig {
  double speed_min_mps = 1.0;
  double speed_max_mps = 3.0;
  double acceleration_mps2 = 1.2;
  double vertical_speed_mps = 1.0;
  double vertical_acceleration_mps2 = 0.7;
  double height_min_m = 1.5;
  double height_max_m = 5.0;
  double margin_m = 0.6;
  double border_m = 2.0;
  enum class Indoors { kAuto, kTrue, kFalse };
  Indoors indoors = Indoors::kAuto;
  double leg_min_m = 6.0;
  double leg_max_m = 30.0;
  double revisit_share = 0.3;
  double separation_m = 2.0;
  double partner_min_m = 2.5;
  double partner_max_m = 60.0;
  double in_view_share = 0.8;
  double cell_m = 0.5;

  void visit(ConfigVisitor& v);
};

/// A family of flights: a scenario and the values drawn for each flight.
struct FamilyConfig {
  std::string name = "family";
  std::string scenario;  ///< file
  double weight = 1.0;
  int vehicles_min = 0;  ///< 0: always the whole team
  double reflectivity_spread = 0.0;
  FlightConfig flight;
  std::vector<VariationConfig> vary;

  void visit(ConfigVisitor& v);
};

struct SplitConfig {
  std::string name = "train";
  int flights = 1;
  std::uint64_t first_seed = 1;

  void visit(ConfigVisitor& v);
};

/// Files and labels written for each sequence.
struct ContentConfig {
  int every = 1;
  enum class Remission { kReflectivity, kIntensity };
  Remission remission = Remission::kReflectivity;
  bool deskew = false;
  bool point_truth = true;
  bool images = true;
  double range_unit_m = 0.002;
  double intensity_unit = 0.0005;
  double trajectory_rate_hz = 100.0;
  std::vector<std::string> tables = {"imu", "gnss"};
  bool snapshots = false;

  void visit(ConfigVisitor& v);
};

struct PicturesConfig {
  int flights_per_split = 1;
  std::vector<CameraConfig> cameras;

  void visit(ConfigVisitor& v);
};

/// A dataset: families of worlds, flown and recorded as labeled sequences in splits.
struct DatasetConfig {
  std::string name = "dataset";
  std::string description;
  int max_attempts = 8;
  std::vector<SplitConfig> splits = std::vector<SplitConfig>(1);
  std::vector<FamilyConfig> families;
  ContentConfig content;
  std::vector<Module> recorders;
  PicturesConfig pictures;

  void visit(ConfigVisitor& v);
};

/// Reads a dataset file with its `base:` chain and the overrides. Throws InputError.
DatasetConfig load_dataset(const std::filesystem::path& file,
                           const std::vector<std::pair<std::string, std::string>>& overrides = {});
/// The complete configuration with every default written out.
std::string write_dataset(const DatasetConfig& config);

/// Every key of a dataset file as Markdown.
std::string dataset_reference();

/// The overrides of the scenario that flight `seed` draws, in the order of the variations. A pure function.
/// @param attempt  0 first; incremented when the previous attempt's flight cannot be planned or flown
std::vector<std::pair<std::string, std::string>> draw_overrides(const FamilyConfig& family, int num_vehicles,
                                                                std::uint64_t seed, int attempt);

}  // namespace swiftlet::sim
