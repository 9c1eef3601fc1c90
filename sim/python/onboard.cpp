// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include <map>
#include <memory>
#include <optional>

#include "sim/python/bindings.hpp"
#include "sim/python/field_values.hpp"
#include "sim/python/fields.hpp"
#include "sim/python/maps.hpp"
#include "sim/python/samples.hpp"
#include "sim/python/scan.hpp"
#include "sim/python/scenario.hpp"
#include "sim/python/use.hpp"
#include "swiftlet/core/agent/localization_status.hpp"
#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/localization/imu_check.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/run/agent_events.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"

namespace swiftlet::python {
namespace {

AgentSetup setup_of(const sim::Scenario& scenario, int vehicle) {
  const sim::VehicleConfig& config = scenario.vehicles[vehicle];
  AgentSetup setup;
  setup.self = vehicle;
  setup.num_vehicles = static_cast<int>(scenario.vehicles.size());
  for (const sim::VehicleConfig& other : scenario.vehicles) setup.vehicle_names.push_back(other.name);
  setup.airframe = config.airframe;
  setup.start_known = config.start.known;
  if (config.start.known != StartKnown::kNothing) setup.T_local_body_start.translation() = config.start.position_m;
  if (config.start.known == StartKnown::kPose)
    setup.T_local_body_start.linear() =
        Eigen::AngleAxisd(config.start.yaw_deg * kRadPerDeg, Vector3::UnitZ()).toRotationMatrix();
  setup.tick_s = scenario.tick_s;
  for (const Module& sensor : config.sensors) dynamic_cast<const sim::SensorConfig&>(*sensor.config).describe(setup);
  return setup;
}

/// Mounts of a vehicle's LiDARs, T_body_lidar by name.
std::map<std::string, Pose> mounts_of(const sim::VehicleConfig& vehicle) {
  std::map<std::string, Pose> mounts;
  const std::vector<std::string> names = sim::sensor_names(vehicle.sensors);
  const sim::VehicleShape shape = sim::make_vehicle_shape(vehicle.airframe, vehicle.markers);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto* lidar = dynamic_cast<const sim::LidarConfig*>(vehicle.sensors[i].config.get());
    if (lidar != nullptr) mounts.emplace(names[i], lidar->mount.place_on(shape, lidar->pattern));
  }
  return mounts;
}

/// The scan, with the mount of its sensor unless it has one of its own.
std::shared_ptr<const Scan> mounted(const HeldScan& held, const std::map<std::string, Pose>& mounts) {
  if (held.has_mount) return held.scan;
  const auto mount = mounts.find(held.scan->sensor);
  if (mount == mounts.end()) {
    std::vector<std::string> names;
    for (const auto& [name, T_body_lidar] : mounts) names.push_back(name);
    throw py::value_error("add_scan: expected T_body_lidar, or the sensor to be a LiDAR of the vehicle" +
                          (names.empty() ? " (it has none)" : ", " + sim::one_of(names)) + ", found \"" +
                          held.scan->sensor + "\"" + sim::did_you_mean(held.scan->sensor, names));
  }
  auto scan = std::make_shared<Scan>(*held.scan);
  scan->T_body_lidar = mount->second;
  return scan;
}

/// Checks that measurements and steps are in the order of their times.
class TimeOrder {
 public:
  /// A measurement, valid at `t` and complete at `end`. Throws ValueError when it is older than one of its kind.
  void add(const std::string& kind, TimeNs t, TimeNs end) {
    Latest& latest = latest_.try_emplace(kind, Latest{t, end}).first->second;
    if (t < latest.t)
      throw py::value_error(kind + ": t_ns: expected " + std::to_string(latest.t) +
                            ", as the one before, or later, found " + std::to_string(t));
    latest = {t, end};
  }
  /// Throws ValueError unless the step is later than the one before and not earlier than any measurement.
  void step(TimeNs t) {
    if (last_step_ && t <= *last_step_)
      throw py::value_error("step: t_ns: expected a time after that of the step before, " +
                            std::to_string(*last_step_) + ", found " + std::to_string(t));
    for (const auto& [kind, latest] : latest_) {
      if (latest.end <= t) continue;
      throw py::value_error("step: t_ns: expected " + std::to_string(latest.end) + ", as of the latest " + kind +
                            (latest.end > latest.t ? " at the end of its sweep" : "") + ", or later, found " +
                            std::to_string(t));
    }
    last_step_ = t;
  }

 private:
  struct Latest {
    TimeNs t = 0, end = 0;
  };
  std::map<std::string, Latest> latest_;  // kind of measurement to its latest time
  std::optional<TimeNs> last_step_;
};

/// The software of one vehicle without a simulator, for measurements from any source.
class Onboard {
 public:
  Onboard(const ReadScenario& read, int vehicle) : events_of_(vehicle) {
    const std::vector<sim::VehicleConfig>& vehicles = read.scenario.vehicles;
    if (vehicle < 0 || vehicle >= static_cast<int>(vehicles.size()))
      throw py::index_error("vehicle: expected a number below " + std::to_string(vehicles.size()) + ", found " +
                            std::to_string(vehicle));
    const sim::VehicleConfig& config = vehicles[vehicle];
    agent_ = make_agent(config.agent, setup_of(read.scenario, vehicle));
    mounts_ = mounts_of(config);
    observation_.self = vehicle;
    num_vehicles_ = static_cast<int>(vehicles.size());
    action_ = &idle_;
  }

  void add(const std::string& kind, const py::dict& values) {
    const Use use = call();
    bool found = false;
    Observation::each_samples(observation_, [&](auto& samples) {
      using Sample = typename std::decay_t<decltype(samples)>::value_type;
      if (kind != Sample::kName) return;
      found = true;
      const Sample sample = filled<Sample>(kind, values, num_vehicles_);
      if constexpr (std::is_same_v<Sample, ImuSample>) check_units(sample);
      times_.add(kind, sample.t, sample.t);
      samples.push_back(sample);
    });
    if (!found) reject_kind(observation_, kind);
  }
  void add_scan(const HeldScan& held) {
    const Use use = call();
    std::shared_ptr<const Scan> scan = mounted(held, mounts_);
    times_.add("scan of " + scan->sensor, scan->stamp, scan->stamp + scan->duration);
    observation_.scans.push_back(std::move(scan));
  }

  void step(TimeNs t) {
    const Use use = call();
    times_.step(t);
    observation_.t = t;
    const py::gil_scoped_release parallel;
    action_ = &agent_->step(observation_);
    events_of_.collect(t, *action_, action_->estimate.T_world_body().translation(), events_);
    const VehicleId self = observation_.self;
    observation_.clear();
    observation_.self = self;
  }

  const Action& action() const {
    const Use use = call();
    return *action_;
  }
  LocalizationStatus localization_status() const {
    const Use use = call();
    const auto* reporter = dynamic_cast<const LocalizationReporter*>(agent_.get());
    return reporter != nullptr ? reporter->localization_status() : LocalizationStatus();
  }
  Table events() const {
    const Use use = call();
    return Table::copy_of(std::span<const sim::Event>(events_));
  }
  std::vector<Counter> counters() const {
    const Use use = call();
    std::vector<Counter> counters;
    agent_->append_counters(counters);
    return counters;
  }
  py::dict maps() const {
    const Use use = call();
    return maps_of(*agent_);
  }

 private:
  Use call() const { return {in_use_, "Onboard"}; }

  /// Throws ValueError when the samples are in other units or axes.
  void check_units(const ImuSample& sample) {
    imu_check_.add(sample);
    if (!imu_check_.fault().empty()) throw py::value_error(imu_check_.fault());
  }

  std::unique_ptr<Agent> agent_;
  std::map<std::string, Pose> mounts_;  // T_body_lidar of each LiDAR
  Observation observation_;
  Action idle_;
  const Action* action_ = nullptr;
  int num_vehicles_ = 0;
  TimeOrder times_;
  ImuCheck imu_check_;
  sim::AgentEvents events_of_;
  std::vector<sim::Event> events_;
  mutable std::atomic<bool> in_use_ = false;
};

py::list dicts_of(const std::vector<Counter>& counters) {
  py::list dicts;
  for (const Counter& counter : counters) {
    dicts.append(py::dict(py::arg("what") = counter.what, py::arg("count") = counter.count, py::arg("of") = counter.of,
                          py::arg("setting") = "agent." + counter.setting));
  }
  return dicts;
}

using OnboardClass = py::class_<Onboard>;

/// What the software reports on itself.
void bind_reports(OnboardClass& onboard) {
  onboard
      .def_property_readonly(
          "fault", [](const Onboard& o) { return o.localization_status().fault; },
          "Reason why the estimate is not valid, such as \"no IMU\"; empty while it is.")
      .def_property_readonly(
          "warning", [](const Onboard& o) { return o.localization_status().warning; },
          "Degradation of an estimate that is still valid, such as dead reckoning by the IMU alone; empty: none.")
      .def_property_readonly(
          "mission", [](const Onboard& o) { return kMissionStatusWords[static_cast<std::size_t>(o.action().mission)]; },
          "running, endless, done or failed; failed once the estimate was not valid.")
      .def_property_readonly(
          "mission_note", [](const Onboard& o) { return o.action().mission_note; }, "Reason of a failure or a wait.")
      .def_property_readonly("events", &Onboard::events,
                             "Events so far: corrections of the local frame, changes of the mission, faults and "
                             "warnings of localization, each at the estimated position.")
      .def_property_readonly(
          "counters", [](const Onboard& o) { return dicts_of(o.counters()); },
          "Counts of what exceeded a setting so far: dicts of what, count, of (the total; 0: not counted) and setting, "
          "the key to change.");
}

/// What the software estimates and commands.
void bind_outputs(OnboardClass& onboard) {
  onboard.def_property_readonly("estimate", [](const Onboard& o) { return Table::row(o.action().estimate); })
      .def_property_readonly("detections",
                             [](const Onboard& o) -> std::optional<Table> {
                               if (!o.action().has_detections) return std::nullopt;
                               return Table::copy_of(std::span<const Detection>(o.action().detections));
                             })
      .def_property_readonly("tracks",
                             [](const Onboard& o) { return Table::copy_of(std::span<const Track>(o.action().tracks)); })
      .def_property_readonly(
          "relatives",
          [](const Onboard& o) { return Table::copy_of(std::span<const RelativeEstimate>(o.action().relatives)); })
      .def_property_readonly("reference", [](const Onboard& o) { return Table::row(o.action().reference); })
      .def_property_readonly("rotor_command",
                             [](const Onboard& o) {
                               return py::array_t<double>(static_cast<py::ssize_t>(kMaxRotors),
                                                          o.action().rotor_command.data());
                             })
      .def("maps", &Onboard::maps, "As the property of a simulator's vehicle.");
}

}  // namespace

void bind_onboard(py::module_& module) {
  OnboardClass onboard(
      module, "Onboard",
      "The software of one vehicle without a simulator: localization or SLAM, detector, tracker, mapping and "
      "guidance, fed with measurements from anywhere.");
  onboard
      .def(py::init<const ReadScenario&, int>(), py::arg("scenario"), py::arg("vehicle") = 0,
           "scenario: its vehicle's agent, sensors and start define the software. One thread at a time may use "
           "it.")
      .def(
          "add", [](Onboard& o, const std::string& kind, const py::kwargs& values) { o.add(kind, values); },
          py::arg("kind"),
          "A sample that is new since the last step: imu, odometry, gnss, altimeter, compass, pose, neighbors, with "
          "all columns of their tables, such as add('imu', t_ns=0, omega_radps=(0, 0, 0), f_mps2=(0, 0, 9.81)). Of one "
          "kind, times do not go back. ValueError when IMU samples are in g or deg/s, or in other axes.")
      .def("add_scan", &Onboard::add_scan, py::arg("scan"),
           "A scan that is new since the last step. Without T_body_lidar of its own it has the mount that the scenario "
           "gives its sensor.")
      .def("step", &Onboard::step, py::arg("t_ns"),
           "One tick at the instant t_ns [ns], later than the tick before, and not before the end of a sweep that was "
           "added.");
  bind_outputs(onboard);
  bind_reports(onboard);
}

}  // namespace swiftlet::python
