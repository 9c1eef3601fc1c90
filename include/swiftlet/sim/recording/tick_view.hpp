// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/airframe.hpp"
#include "swiftlet/core/base/observation.hpp"
#include "swiftlet/sim/recording/series.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "swiftlet/sim/world/scene.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// A discrete event: a crash, a take-off, the end of a mission. One line of events.jsonl.
struct Event {
  TimeNs t = 0;
  std::string kind;  ///< "crash", "mission", ...
  VehicleId vehicle = kNoVehicle;
  std::string partner;  ///< other party of a crash: "trunk 17", or the other vehicle's name
  Vector3 p_world_m = Vector3::Zero();
  std::string note;

  static void visit(auto& e, auto& v) {
    v.time("t_s", e.t, "[s] time of the event");
    v.field("kind", e.kind, "[-] kind: crash, mission, ...");
    v.vehicle("vehicle", e.vehicle, "[-] vehicle concerned; none: the whole run");
    v.field("partner", e.partner, "[-] object or vehicle hit in a crash");
    v.field("position_*_m", e.p_world_m, "[m] true position in the world");
    v.field("note", e.note, "[-] details");
  }
};

class StaticScene;

/// Data that is constant during a run.
struct RunInfo {
  std::string scenario;  ///< name of the scenario
  const Scene* scene = nullptr;
  std::shared_ptr<const StaticScene> static_scene = nullptr;  ///< ray-tracing structure of `scene`; null: not built
  std::vector<std::string> vehicle_names;                     ///< indexed by VehicleId
  std::vector<const Airframe*> airframes;                     ///< indexed by VehicleId
  std::vector<std::shared_ptr<const VehicleShape>> vehicle_shapes;  ///< indexed by VehicleId
  std::vector<const Series*> series;                                ///< tables that metrics fill in every tick
  TimeNs start_time = 0;                                            ///< added to every recorded time
  std::filesystem::path directory;                                  ///< output directory; exists
};

/// One tick for recorders: truth, sensor data and actions. All spans are indexed by VehicleId.
struct TickView {
  TimeNs t = 0;
  std::span<const VehicleState> states;
  std::span<const Observation> observations;
  std::span<const Action* const> actions;
  std::span<const std::vector<std::shared_ptr<const LabeledScan>>> scans;  ///< completed in this tick
  std::span<const Event> events;                                           ///< events of this tick
  std::span<const double> clearance_m;  ///< distance to the nearest surface or vehicle; empty: not measured
  std::span<const std::unique_ptr<Agent>> agents = {};  ///< access to the agents' maps; valid until the run ends
};

}  // namespace swiftlet::sim
