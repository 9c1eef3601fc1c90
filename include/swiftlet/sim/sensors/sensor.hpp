// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/core/base/observation.hpp"
#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/sensors/clock_config.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet {
struct AgentSetup;
}

namespace swiftlet::sim {

/// Configuration common to all sensors. A `visit` starts with `model` (if it has presets), then `visit_common`.
struct SensorConfig : ModuleConfig {
  std::string name;        ///< unique on its vehicle; empty: the type's name
  ClockConfig clock;       ///< error of the stamps; not known to the agent
  double latency_s = 0.0;  ///< from the time of validity to the delivery; does not change stamps

  void visit_common(ConfigVisitor& v);
  /// Adds the sensor's properties known to the vehicle's software before the start.
  virtual void describe(AgentSetup&) const {}
};

template <class Derived>
struct SensorConfigOf : SensorConfig {
  std::unique_ptr<ModuleConfig> clone() const override {
    return std::make_unique<Derived>(static_cast<const Derived&>(*this));
  }
};

/// Input of every sensor's constructor.
struct SensorSetup {
  std::uint64_t seed = 0;
  VehicleId vehicle = 0;
  std::string name;    ///< unique on its vehicle
  std::string entity;  ///< "vehicle/name", key of its random streams
  std::shared_ptr<const StaticScene> world;
  std::shared_ptr<const Scene> scene;                               ///< for the materials
  std::vector<std::shared_ptr<const VehicleShape>> vehicle_shapes;  ///< indexed by VehicleId
  std::vector<std::string> vehicle_names;                           ///< indexed by VehicleId
};

/// Measures the truth at its own exact instants and delivers samples in the first tick at or after them.
/// One thread at a time per sensor; several sensors run in parallel.
class Sensor {
 public:
  explicit Sensor(SensorSetup setup) : setup_(std::move(setup)) {}
  virtual ~Sensor() = default;

  const std::string& name() const { return setup_.name; }
  /// Measures, on `truth`, everything due in (previous tick, now] and appends it to `out`.
  virtual void measure(TimeNs now, const StateHistory& truth, Observation& out) = 0;
  /// Scans of the last measure(), with truth, for recorders. Empty for sensors other than a LiDAR.
  virtual std::span<const std::shared_ptr<LabeledScan>> scans() const { return {}; }
  /// True if measure(now) produces a scan, which may then be traced in parts beforehand:
  virtual bool makes_scan_by(TimeNs /*now*/) const { return false; }
  /// Begins the due sweep and returns its number of parts. Each must be traced once before measure(now), by any thread
  /// and in any order. Without this call, measure() traces everything.
  virtual int begin_sweep(TimeNs /*now*/, const StateHistory& /*truth*/) { return 0; }
  virtual void trace_part(int /*part*/) {}
  /// Viewing direction of a part as an ordinal number: tracing the parts of all sensors in this order reuses data in
  /// the processor's caches.
  virtual int heading_of_part(int /*part*/) const { return 0; }
  /// Longest time before now for which the sensor needs the history [s].
  virtual double look_back_s() const { return 0.0; }

 protected:
  /// The sensor's own random stream for a purpose ("gnss.drift"), independent of other sensors of the team.
  Random stream(const char* purpose) const { return Random(setup_.seed, purpose, setup_.entity); }

  SensorSetup setup_;
};

/// Instants k * period (+ phase), delivered in order.
class Schedule {
 public:
  Schedule() = default;
  explicit Schedule(double rate_hz, TimeNs first = 0) : period_(from_seconds(1.0 / rate_hz)), first_(first) {}
  /// The next instant that is due at or before `now`; false when there is none. Advances.
  bool next(TimeNs now, TimeNs& due, std::uint32_t& index) {
    const TimeNs t = first_ + static_cast<TimeNs>(count_) * period_;
    if (t > now) return false;
    due = t;
    index = count_++;
    return true;
  }
  /// True if an instant is due at or before `now`.
  bool is_due(TimeNs now) const { return due() <= now; }
  /// Time and index of the instant that next() will return.
  TimeNs due() const { return first_ + static_cast<TimeNs>(count_) * period_; }
  std::uint32_t index() const { return count_; }
  TimeNs period() const { return period_; }

 private:
  TimeNs period_ = kNsPerSecond;
  TimeNs first_ = 0;
  std::uint32_t count_ = 0;
};

/// Names of the sensors of one vehicle: as configured, otherwise by type; repeated types are numbered from 2 ("imu",
/// "imu2"). Throws std::invalid_argument when two have the same configured name.
std::vector<std::string> sensor_names(std::span<const Module> sensors);

}  // namespace swiftlet::sim
