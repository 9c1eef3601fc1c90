// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {

/// A dataset of seconds in a folder of its own: three UAVs among a few trees, two of them with LiDARs, one of them
/// small and with rows, the other a Mid-360.
class SmallDataset {
 public:
  SmallDataset() {
    write("team.yaml", R"(
name: small_team
duration_s: 1.2
tick_s: 0.01
world: {type: forest_thesis, num_trees: 30}
vehicles:
  - name: uav1
    model: f450
    sensors:
      - {type: lidar, name: lidar, range_max_m: 60, pattern: {type: ouster, columns: 512, rows: 64}}
      - {type: imu, name: imu}
      - {type: gnss, name: gnss}
    agent: {type: stack, localization: ground_truth}
  - name: uav2
    model: f330
    sensors:
      - {type: lidar, name: fast, model: mid360, rate_hz: 5}
    agent: {type: stack, localization: ground_truth}
  - name: uav3
    model: f330
    agent: {type: stack, localization: ground_truth}
)");
    write("small.yaml", R"(
name: small
description: A dataset for tests.
splits:
  - {name: train, flights: 2, first_seed: 100}
  - {name: valid, flights: 1, first_seed: 200}
families:
  - name: trees
    scenario: team.yaml
    reflectivity_spread: 0.2
    flight: {speed_max_mps: 2, height_max_m: 8, partner_max_m: 15}
    vary:
      - {key: "vehicles[*].airframe.reflectivity", min: 0.2, max: 0.8}
pictures: {flights_per_split: 0}
)");
  }

  const std::filesystem::path& directory() const { return directory_.path(); }
  std::filesystem::path file() const { return directory() / "small.yaml"; }
  std::filesystem::path out() const { return directory() / "out"; }
  void write(const std::string& name, const std::string& text) const { std::ofstream(directory() / name) << text; }

 private:
  TemporaryDirectory directory_;
};

}  // namespace swiftlet::sim
