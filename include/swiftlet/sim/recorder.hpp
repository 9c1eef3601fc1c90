// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/airframe.hpp"
#include "swiftlet/core/config.hpp"
#include "swiftlet/core/observation.hpp"

namespace swiftlet::sim {

struct Scenario;
struct Scene;
struct VehicleState;
struct LabeledScan;
struct VehicleShape;

/// Something that happened: a crash, a take-off, a mission that ended. One line of events.jsonl.
struct Event {
  TimeNs t = 0;
  std::string kind;  ///< "crash", "mission", ...
  VehicleId vehicle = kNoVehicle;
  std::string partner;  ///< of a crash: "trunk 17", or the other vehicle's name
  Vector3 p_world_m = Vector3::Zero();
  std::string note;
};

/// What stays the same during a run.
struct RunInfo {
  const Scenario* scenario = nullptr;
  const Scene* scene = nullptr;
  std::vector<std::string> vehicle_names;                           ///< by VehicleId
  std::vector<const Airframe*> airframes;                           ///< by VehicleId
  std::vector<std::shared_ptr<const VehicleShape>> vehicle_shapes;  ///< by VehicleId
  std::filesystem::path directory;                                  ///< where to write; exists
};

/// How a detector or a tracker did on one target in one scan, or one of its estimates that belongs to none (Vrba 2025,
/// eqs. 67-71). What is not measured is NaN.
struct DetectionScore {
  enum class Stage { kDetector, kTracker };
  TimeNs t = 0;  ///< for which the estimate holds; the middle of the sweep when there is none
  VehicleId observer = kNoVehicle;
  Stage stage = Stage::kDetector;
  VehicleId target = kNoVehicle;  ///< kNoVehicle: a false estimate
  double distance_m = 0.0;        ///< true, observer to target (false estimate: to the estimate)
  int visible_points = -1;        ///< returns of the scan that lie on the target; -1: there was no scan
  bool found = false;             ///< an estimate lies nearer than MetricsConfig::true_positive_m
  std::uint32_t track_id = 0;
  double position_error_m = 0.0;     ///< eq. (68)
  double speed_error_mps = 0.0;      ///< eq. (69)
  double direction_error_rad = 0.0;  ///< eq. (70), of targets that move
  double nees = 0.0;                 ///< squared error of the position over the covariance it was told with
  double latency_s = 0.0;            ///< from t to now
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
  std::span<const DetectionScore> detection_scores = {};  ///< of what was detected and tracked in this tick
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

/// One row of sim/recorders/registry.cpp.
struct RecorderType {
  ModuleType module;
  std::unique_ptr<Recorder> (*make)(const ModuleConfig& config);
};

std::span<const RecorderType> recorder_types();
std::span<const ModuleType> recorder_module_types();
std::unique_ptr<Recorder> make_recorder(const Module& config);

}  // namespace swiftlet::sim
