// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/airframe.hpp"
#include "swiftlet/core/config.hpp"
#include "swiftlet/core/observation.hpp"

namespace swiftlet::sim {

struct Scenario;
struct Scene;
struct VehicleState;
struct LabeledScan;
struct VehicleShape;
class Series;

/// Something that happened: a crash, a take-off, a mission that ended. One line of events.jsonl.
struct Event {
  TimeNs t = 0;
  std::string kind;  ///< "crash", "mission", ...
  VehicleId vehicle = kNoVehicle;
  std::string partner;  ///< of a crash: "trunk 17", or the other vehicle's name
  Vector3 p_world_m = Vector3::Zero();
  std::string note;

  static void visit(auto& e, auto& v) {
    v.time("t_s", e.t, "[s] when it happened");
    v.field("kind", e.kind, "[-] crash, mission, ...");
    v.vehicle("vehicle", e.vehicle, "[-] to whom; none: to the whole run");
    v.field("partner", e.partner, "[-] what or whom it crashed into");
    v.field("position_*_m", e.p_world_m, "[m] true position in the world");
    v.field("note", e.note, "[-] more about it");
  }
};

/// What stays the same during a run.
struct RunInfo {
  const Scenario* scenario = nullptr;
  const Scene* scene = nullptr;
  std::vector<std::string> vehicle_names;                           ///< by VehicleId
  std::vector<const Airframe*> airframes;                           ///< by VehicleId
  std::vector<std::shared_ptr<const VehicleShape>> vehicle_shapes;  ///< by VehicleId
  std::vector<const Series*> series;                                ///< what metrics tell by tick
  std::filesystem::path directory;                                  ///< where to write; exists
};

/// One tick as recorders see it: truth beside what was sensed and done. All spans by VehicleId.
struct TickView {
  TimeNs t = 0;
  std::span<const VehicleState> states;
  std::span<const Observation> observations;
  std::span<const Action* const> actions;
  std::span<const std::vector<std::shared_ptr<const LabeledScan>>> scans;  ///< completed in this tick
  std::span<const Event> events;                                           ///< of this tick
  std::span<const double> clearance_m;  ///< to the nearest surface or vehicle; empty: nobody measured it
  std::span<const std::unique_ptr<Agent>> agents = {};  ///< to be asked for their maps; stay until the run ends
};

/// Writes one output format. Everything it creates lies in RunInfo::directory.
class Recorder {
 public:
  virtual ~Recorder() = default;
  virtual void begin(const RunInfo& info) = 0;
  virtual void write(const TickView& tick) = 0;
  /// Flushes and closes; returns the paths written, relative to the run directory. Throws std::runtime_error when
  /// anything could not be written (disk full).
  virtual std::vector<std::filesystem::path> finish() = 0;
};

/// One row of sim/registry/recorders.cpp.
struct RecorderType {
  ModuleType module;
  std::unique_ptr<Recorder> (*make)(const ModuleConfig& config);
};

std::span<const RecorderType> recorder_types();
std::span<const ModuleType> recorder_module_types();
std::unique_ptr<Recorder> make_recorder(const Module& config);

}  // namespace swiftlet::sim
