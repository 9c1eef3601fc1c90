// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/dataset/dataset_config.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/recording/recorder.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/scenario/recorder_paths.hpp"
#include "swiftlet/sim/scenario/reference.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"
#include "swiftlet/sim/scenario/yaml_writer.hpp"

namespace swiftlet::sim {
namespace {

constexpr const char* kEachVehicle = "vehicles[*]";

bool is_name(const std::string& name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), allowed);
}

std::string element(const char* list, std::size_t index, const char* key) {
  return std::string(list) + "[" + std::to_string(index) + "]." + key;
}

template <class Element>
void check_names(ConfigVisitor& v, const std::vector<Element>& elements, const char* list) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const std::string key = element(list, i, "name");
    v.check(is_name(elements[i].name), key.c_str(), "a name of letters, digits, '_' and '-'");
    const auto same = [&](const Element& other) { return other.name == elements[i].name; };
    v.check(std::count_if(elements.begin(), elements.end(), same) == 1, key.c_str(), "a name that no other has");
  }
}

// The worlds of one split must not occur in another, so that splits are independent.
void check_seeds(ConfigVisitor& v, const std::vector<SplitConfig>& splits) {
  for (std::size_t i = 0; i < splits.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const std::uint64_t end_i = splits[i].first_seed + static_cast<std::uint64_t>(splits[i].flights);
      const std::uint64_t end_j = splits[j].first_seed + static_cast<std::uint64_t>(splits[j].flights);
      const bool apart = end_i <= splits[j].first_seed || end_j <= splits[i].first_seed;
      v.check(apart, element("splits", i, "first_seed").c_str(),
              "seeds that the split " + splits[j].name + " does not use (" + std::to_string(splits[j].first_seed) +
                  " to " + std::to_string(end_j - 1) + ")");
    }
  }
}

std::string draw(const VariationConfig& variation, const Random& random, std::uint32_t index) {
  const double u = random.uniform(index, 0);
  if (variation.law == VariationConfig::Law::kChoice) {
    return variation.choices[static_cast<std::size_t>(u * static_cast<double>(variation.choices.size()))];
  }
  if (variation.law == VariationConfig::Law::kWhole) {
    return shortest(variation.min + std::floor(u * (variation.max - variation.min + 1.0)));
  }
  if (variation.law == VariationConfig::Law::kLogUniform)
    return shortest(variation.min * elementary::pow(variation.max / variation.min, u));
  return shortest(variation.min + u * (variation.max - variation.min));
}

}  // namespace

void VariationConfig::visit(ConfigVisitor& v) {
  v.field("key", key,
          "[-] key path in the scenario, such as world.stems_per_ha; vehicles[*]. stands for every vehicle, with "
          "independent draws");
  v.choice(
      "law", law, kLaws,
      "[-] uniform in [min, max]; log_uniform: uniform in the logarithm; whole: whole numbers; choice: one of choices");
  v.field("min", min, "[-] smallest value, in the unit of the key");
  v.field("max", max, "[-] largest value, in the unit of the key");
  v.field("choices", choices, "[-] values of law choice, in the syntax of the scenario");
  v.check(!key.empty(), "key", "a key path of the scenario");
  v.check(min <= max, "max", "a number that is not below min");
  v.check(law != VariationConfig::Law::kLogUniform || min > 0.0, "min", "a number > 0 for law log_uniform");
  v.check(law != VariationConfig::Law::kWhole || (min == std::floor(min) && max == std::floor(max)), "min",
          "whole numbers as min and max for law whole");
  v.check((law == VariationConfig::Law::kChoice) == !choices.empty(), "choices",
          "values with law choice, and only with it");
}

void FlightConfig::visit(ConfigVisitor& v) {
  v.field("speed_min_mps", speed_min_mps, "[m/s] smallest cruise speed; that of a vehicle is drawn between both",
          Range::positive());
  v.field("speed_max_mps", speed_max_mps, "[m/s] largest cruise speed", Range::positive());
  v.field("acceleration_mps2", acceleration_mps2, "[m/s^2] largest horizontal acceleration", Range::positive());
  v.field("vertical_speed_mps", vertical_speed_mps, "[m/s] largest vertical speed", Range::positive());
  v.field("vertical_acceleration_mps2", vertical_acceleration_mps2, "[m/s^2] largest vertical acceleration",
          Range::positive());
  v.field("height_min_m", height_min_m, "[m] lowest height of flight above the ground", Range::positive());
  v.field("height_max_m", height_max_m, "[m] highest height of flight above the ground", Range::positive());
  v.field("margin_m", margin_m, "[m] minimum planned distance from the sphere around the vehicle to any surface",
          Range::positive());
  v.field("border_m", border_m, "[m] width of the excluded strip along the edge of the world", Range::non_negative());
  v.choice("indoors", indoors, {"auto", "true", "false"},
           "[-] whether flights stay inside walls; auto: in worlds whose walls enclose at least a tenth of the ground");
  v.field("leg_min_m", leg_min_m, "[m] minimum straight-line distance between successive goals", Range::positive());
  v.field("leg_max_m", leg_max_m, "[m] largest straight-line distance between successive goals", Range::positive());
  v.field("revisit_share", revisit_share, "[-] share of goals at already visited positions (closes loops)",
          Range::probability());
  v.field("separation_m", separation_m, "[m] minimum planned distance between the centers of two vehicles",
          Range::positive());
  v.field("partner_min_m", partner_min_m, "[m] minimum distance of the other vehicles' goals from the first vehicle",
          Range::positive());
  v.field("partner_max_m", partner_max_m,
          "[m] greatest distance of the other vehicles' goals from the first vehicle; uniform in the logarithm",
          Range::positive());
  v.field("in_view_share", in_view_share, "[-] share of the other vehicles' goals visible from the first vehicle",
          Range::probability());
  v.field("cell_m", cell_m, "[m] cell size of the grid for path search", Range::positive());
  v.check(speed_min_mps <= speed_max_mps, "speed_max_mps", "a number that is not below speed_min_mps");
  v.check(height_min_m < height_max_m, "height_max_m", "a number above height_min_m");
  v.check(leg_min_m < leg_max_m, "leg_max_m", "a number above leg_min_m");
  v.check(partner_min_m < partner_max_m, "partner_max_m", "a number above partner_min_m");
  v.check(separation_m <= partner_min_m, "partner_min_m", "a number that is not below separation_m");
}

void FamilyConfig::visit(ConfigVisitor& v) {
  v.field("name", name, "[-] name of the family, for the data card");
  v.file("scenario", scenario, "[-] scenario file: world, vehicles, sensors; starts and guidance are replaced");
  v.field("weight", weight, "[-] relative frequency among the families", Range::positive());
  v.field("vehicles_min", vehicles_min,
          "[-] minimum number of vehicles; the first n fly, with n drawn from here to all; 0: always all",
          Range{0, 1000, false, false});
  v.field("reflectivity_spread", reflectivity_spread,
          "[-] the world's materials: each reflectivity is multiplied by exp(spread * normal)",
          Range::between(0.0, 2.0));
  v.object("flight", flight, "paths through the free space");
  v.list("vary", vary, "values drawn for each flight");
  v.check(!scenario.empty(), "scenario", "a scenario file");
}

void SplitConfig::visit(ConfigVisitor& v) {
  v.field("name", name, "[-] name of the split; readers of SemanticKITTI expect train, valid and test");
  v.field("flights", flights, "[-] number of flights", Range{0, 10000, false, false});
  v.field("first_seed", first_seed,
          "[-] seed of the first flight; flight k has seed first_seed + k, which determines its world and all draws");
}

void ContentConfig::visit(ConfigVisitor& v) {
  v.field("every", every, "[-] every n-th scan is written", Range{1, 1e6, false, false});
  v.choice(
      "remission", remission, {"reflectivity", "intensity"},
      "[-] fourth number of a point: range-corrected, 1 = white Lambertian; or as received, 1 = such a wall at 10 m");
  v.field("deskew", deskew,
          "[-] transform each point to the true sensor pose at the start of the sweep (motion compensation)");
  v.field("point_truth", point_truth,
          "[-] whether point_truth/ is written: time, ring, column, true range and incidence of each point");
  v.field("images", images, "[-] whether images/ is written: range and intensity as 16-bit PNG, for LiDARs with rows");
  v.field("range_unit_m", range_unit_m, "[m] range per unit of a range image", Range::positive());
  v.field("intensity_unit", intensity_unit,
          "[-] intensity per unit of an intensity image, 1 = white Lambertian wall at 10 m", Range::positive());
  v.field("trajectory_rate_hz", trajectory_rate_hz, "[Hz] pose rate of the TUM files; 0: every tick",
          Range::between(0.0, 1e5));
  v.check(trajectory_rate_hz == 0.0 || trajectory_rate_hz >= 1e-3, "trajectory_rate_hz", "0, or at least 0.001");
  v.field("tables", tables, "[-] csv/: topics of the recorder csv");
  v.field("snapshots", snapshots, "[-] whether the pictures of the scenario are taken in every sequence");
  v.check(!snapshots || !picture_library().empty(), "snapshots",
          "false in a program built without pictures (docs/pictures.md)");
}

void PicturesConfig::visit(ConfigVisitor& v) {
  v.field("flights_per_split", flights_per_split, "[-] number of first flights of each split with pictures",
          Range{0, 1000, false, false});
  v.list("cameras", cameras, "pictures for the data card");
  v.check(flights_per_split == 0 || cameras.empty() || !picture_library().empty(), "flights_per_split",
          "0 in a program built without pictures (docs/pictures.md)");
}

void DatasetConfig::visit(ConfigVisitor& v) {
  v.field("name", name, "[-] name of the dataset");
  v.field("description", description, "[-] a sentence for the data card");
  v.field("max_attempts", max_attempts,
          "[-] largest number of draws of a flight that cannot be planned or ends in a crash",
          Range{1, 1000, false, false});
  v.list("splits", splits, "splits of the dataset, by seed");
  v.list("families", families, "worlds and teams");
  v.object("content", content, "files and labels of each sequence");
  v.modules("recorders", recorders, recorder_module_types(),
            "[-] additional recorders in every sequence, such as mcap");
  v.object("pictures", pictures, "pictures for the data card");
  check_recorders(v, recorders, nullptr);
  v.check(is_name(name), "name", "a name of letters, digits, '_' and '-'");
  v.check(!families.empty(), "families", "at least one family");
  check_names(v, splits, "splits");
  check_names(v, families, "families");
  check_seeds(v, splits);
}

DatasetConfig load_dataset(const std::filesystem::path& file,
                           const std::vector<std::pair<std::string, std::string>>& overrides) {
  DatasetConfig config;
  read_config(
      file, [&](ConfigVisitor& v) { config.visit(v); }, overrides);
  return config;
}

std::string write_dataset(const DatasetConfig& config) {
  DatasetConfig copy = config;
  return write_config([&](ConfigVisitor& v) { copy.visit(v); });
}

std::string dataset_reference() {
  DatasetConfig config;
  return "# Reference of dataset files\n\nThis page is generated: `swiftlet reference dataset`. "
         "The purpose of the keys is in docs/datasets.md, the syntax of values in docs/reference.md.\n\n" +
         reference_tables([&](ConfigVisitor& v) { config.visit(v); }, "Dataset");
}

std::vector<std::pair<std::string, std::string>> draw_overrides(const FamilyConfig& family, int num_vehicles,
                                                                std::uint64_t seed, int attempt) {
  std::vector<std::pair<std::string, std::string>> overrides;
  for (const VariationConfig& variation : family.vary) {
    const Random random(seed, "dataset.vary", variation.key + "#" + std::to_string(attempt));
    const std::size_t star = variation.key.find(kEachVehicle);
    if (star == std::string::npos) {
      overrides.emplace_back(variation.key, draw(variation, random, 0));
      continue;
    }
    for (int i = 0; i < num_vehicles; ++i) {
      std::string key = variation.key;
      key.replace(star, std::string(kEachVehicle).size(), "vehicles[" + std::to_string(i) + "]");
      overrides.emplace_back(key, draw(variation, random, static_cast<std::uint32_t>(i)));
    }
  }
  return overrides;
}

}  // namespace swiftlet::sim
