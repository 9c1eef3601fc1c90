// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <chrono>
#include <cstdio>
#include <stdexcept>

#include "sim/dataset/sequence_recorder.hpp"
#include "swiftlet/sim/dataset/generate.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/recorders/csv.hpp"
#include "swiftlet/sim/recorders/tum.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/render/snapshot_recorder.hpp"
#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/run/version.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// The sequence of one LiDAR during writing.
struct OpenSequence {
  LidarOfTeam lidar;
  int number = 0;
  fs::path partial, destination;
  std::shared_ptr<SequenceStatistics> statistics = std::make_shared<SequenceStatistics>();
};

template <class Config>
std::unique_ptr<Recorder> recorder_of(const char* type, const Config& config) {
  Module module(recorder_module_types(), type);
  module.as<Config>() = config;
  return make_recorder(module);
}

std::vector<OpenSequence> open_sequences(const Flight& flight, const Scenario& scenario, const fs::path& directory) {
  const std::vector<LidarOfTeam> lidars = lidars_of(scenario);
  if (static_cast<int>(lidars.size()) != flight.num_sequences) {
    throw std::runtime_error(
        fmt::format("flight {}: expected {} LiDARs, found {} (variations must not change how many there are)",
                    flight.number, flight.num_sequences, lidars.size()));
  }
  std::vector<OpenSequence> sequences;
  for (int i = 0; i < flight.num_sequences; ++i) {
    OpenSequence sequence;
    sequence.lidar = lidars[static_cast<std::size_t>(i)];
    sequence.number = flight.first_sequence + i;
    sequence.destination = directory / "sequences" / sequence_name(sequence.number);
    sequence.partial = directory / "sequences" / ("." + sequence_name(sequence.number) + ".partial");
    fs::remove_all(sequence.partial);
    fs::create_directories(sequence.partial);
    sequences.push_back(std::move(sequence));
  }
  return sequences;
}

void attach_recorders(Simulation& simulation, const DatasetPlan& plan, const std::vector<OpenSequence>& sequences,
                      const World& world) {
  const ContentConfig& content = plan.config.content;
  for (const OpenSequence& sequence : sequences) {
    simulation.attach(make_sequence_recorder(content, sequence.lidar.vehicle, sequence.lidar.sensor, world.static_scene,
                                             sequence.statistics),
                      sequence.partial);
    TumConfig tum;
    tum.rate_hz = content.trajectory_rate_hz;
    simulation.attach(recorder_of("tum", tum), sequence.partial);
    if (!content.tables.empty()) {
      CsvConfig csv;
      csv.topics = content.tables;
      simulation.attach(recorder_of("csv", csv), sequence.partial);
    }
  }
  // Recordings of the whole flight are written once.
  for (const Module& recorder : plan.config.recorders) {
    simulation.attach(make_recorder(recorder), sequences.front().partial);
  }
  const auto& snapshots = simulation.scenario().snapshots;
  if (!snapshots.empty()) simulation.attach(make_snapshot_recorder(snapshots), sequences.front().partial);
}

/// @return description of the crash if a vehicle crashed
std::string fly_to_the_end(Simulation& simulation) {
  while (!simulation.finished()) {
    simulation.tick();
    for (const Event& event : simulation.view().events) {
      if (event.kind != "crash") continue;
      return fmt::format("{} crashed into {} at {:.2f} s",
                         simulation.info().vehicle_names[static_cast<std::size_t>(event.vehicle)], event.partner,
                         to_seconds(event.t));
    }
  }
  return {};
}

std::string model_of(const Scenario& scenario, const LidarOfTeam& lidar) {
  for (const Module& sensor : scenario.vehicles[static_cast<std::size_t>(lidar.vehicle)].sensors) {
    const auto* config = dynamic_cast<const LidarConfig*>(sensor.config.get());
    if (config != nullptr && config->name == lidar.sensor) return config->model;
  }
  return {};
}

SequenceInfo describe(const DatasetPlan& plan, const Flight& flight, int attempt, const PreparedFlight& prepared,
                      const Simulation& simulation, const OpenSequence& sequence) {
  SequenceInfo info;
  info.sequence = sequence.number;
  info.split = flight.split;
  info.flight = flight.number;
  info.seed = flight.seed;
  info.attempt = attempt;
  info.family = plan.config.families[static_cast<std::size_t>(flight.family)].name;
  for (const VehicleConfig& vehicle : prepared.scenario.vehicles) {
    info.vehicles.push_back(vehicle.name);
    info.models.push_back(vehicle.model);
  }
  info.vehicle = info.vehicles[static_cast<std::size_t>(sequence.lidar.vehicle)];
  info.instance = sequence.lidar.vehicle + 1;
  info.sensor = sequence.lidar.sensor;
  info.sensor_model = model_of(prepared.scenario, sequence.lidar);
  info.state_hash = hex64(simulation.state_hash());
  info.fingerprint = plan.fingerprint;
  info.version = version();
  info.revision = git_revision();
  info.reflectivities = prepared.reflectivities;
  info.statistics = *sequence.statistics;
  info.statistics.frames_walled = prepared.has_interior ? info.statistics.frames : 0;
  if (!prepared.has_interior) info.statistics.frames_outside = 0;
  info.files = list_files(sequence.partial, sequence.statistics->files);
  return info;
}

void commit(const OpenSequence& sequence) {
  // A sequence finished by an earlier generation has equal bytes.
  if (fs::exists(sequence.destination)) {
    fs::remove_all(sequence.partial);
  } else {
    fs::rename(sequence.partial, sequence.destination);
  }
}

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

double stage_s(const Simulation& simulation, const std::string& wanted) {
  for (const auto& [stage, seconds] : simulation.summary().stage_wall_s) {
    if (stage == wanted) return seconds;
  }
  return 0.0;
}

/// @return reason to draw the flight again, or empty
std::string try_flight(const DatasetPlan& plan, const Flight& flight, int attempt, const fs::path& directory,
                       int threads, FlightTiming& timing) {
  const auto start = Clock::now();
  const PreparedFlight prepared = prepare_flight(plan, flight, attempt);
  const std::vector<OpenSequence> sequences = open_sequences(flight, prepared.scenario, directory);
  Simulation simulation(prepared.scenario, threads, prepared.world);
  attach_recorders(simulation, plan, sequences, prepared.world);
  const auto ready = Clock::now();
  const std::string crash = fly_to_the_end(simulation);
  if (!crash.empty()) {
    for (const OpenSequence& sequence : sequences) fs::remove_all(sequence.partial);
    return crash;
  }
  const auto flown = Clock::now();
  const double recorders_s = stage_s(simulation, "recorders");
  simulation.finish();
  for (const OpenSequence& sequence : sequences) {
    write_file(sequence.partial / "scenario.yaml", write_scenario(prepared.scenario));
    const SequenceInfo info = describe(plan, flight, attempt, prepared, simulation, sequence);
    write_file(sequence.partial / "sequence.json", to_json(info));
  }
  for (const OpenSequence& sequence : sequences) commit(sequence);
  timing.prepare_s += std::chrono::duration<double>(ready - start).count();
  timing.simulate_s = std::chrono::duration<double>(flown - ready).count() - recorders_s;
  timing.record_s = recorders_s + seconds_since(flown);
  for (const OpenSequence& sequence : sequences) timing.beside_s += sequence.statistics->beside_s;
  return {};
}

}  // namespace

void FlightTiming::add(const FlightTiming& other) {
  prepare_s += other.prepare_s;
  simulate_s += other.simulate_s;
  record_s += other.record_s;
  beside_s += other.beside_s;
}

FlightTiming write_flight(const DatasetPlan& plan, const Flight& flight, const fs::path& directory, int threads) {
  FlightTiming timing;
  std::string reason;
  for (int attempt = 0; attempt < plan.config.max_attempts; ++attempt) {
    const auto start = Clock::now();
    try {
      reason = try_flight(plan, flight, attempt, directory, threads, timing);
      if (reason.empty()) return timing;
    } catch (const NoPathFound& error) {
      reason = error.what();
    }
    timing.prepare_s += seconds_since(start);
  }
  throw std::runtime_error(fmt::format("flight {} (seed {}): {} attempts failed, the last because {}", flight.number,
                                       flight.seed, plan.config.max_attempts, reason));
}

PreparedFlight restore_flight(const fs::path& sequence_directory, const SequenceInfo& info) {
  PreparedFlight prepared;
  prepared.scenario = load_scenario(sequence_directory / "scenario.yaml");
  prepared.reflectivities = info.reflectivities;
  prepared.world = make_flight_world(prepared.scenario, info.reflectivities);
  return prepared;
}

}  // namespace swiftlet::sim
