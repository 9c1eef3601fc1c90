// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "swiftlet/sim/dataset/dataset_config.hpp"
#include "swiftlet/sim/run/simulation.hpp"

namespace swiftlet::sim {

/// One simulated flight of a dataset. Each LiDAR aboard gives one sequence.
struct Flight {
  int number = 0;
  std::string split;
  std::uint64_t seed = 0;
  int family = 0;
  int num_vehicles = 1;
  int first_sequence = 0;
  int num_sequences = 1;
  bool pictures = false;  ///< snapshots for the data card are taken
};

/// All flights of a dataset: a pure function of its configuration and of the scenarios that it names.
struct DatasetPlan {
  DatasetConfig config;
  std::vector<Flight> flights;
  std::string fingerprint;  ///< hash of everything that determines the content; equal fingerprints give equal bytes
};
/// Reads the scenarios. Throws InputError.
DatasetPlan plan_dataset(const DatasetConfig& config);

/// A flight ready to be simulated: the scenario with its paths, and the world with its materials.
struct PreparedFlight {
  Scenario scenario;
  World world;
  std::vector<double> reflectivities;  ///< drawn reflectivity of each material of the world
  bool has_interior = false;           ///< walls enclose a part of the ground
};
/// The world of a scenario with the given material reflectivities; empty: those of the generator.
World make_flight_world(const Scenario& scenario, const std::vector<double>& reflectivities);

/// The world is too narrow for the requested flights.
class NoPathFound : public std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Draws, plans and checks one attempt. Throws NoPathFound.
PreparedFlight prepare_flight(const DatasetPlan& plan, const Flight& flight, int attempt);

/// A LiDAR of a scenario.
struct LidarOfTeam {
  VehicleId vehicle = 0;
  std::string sensor;
};
std::vector<LidarOfTeam> lidars_of(const Scenario& scenario);

}  // namespace swiftlet::sim
