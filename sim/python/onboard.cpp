// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include <map>
#include <memory>

#include "sim/python/bindings.hpp"
#include "sim/python/field_values.hpp"
#include "sim/python/fields.hpp"
#include "sim/python/maps.hpp"
#include "sim/python/samples.hpp"
#include "sim/python/scan.hpp"
#include "sim/python/scenario.hpp"
#include "sim/python/use.hpp"
#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::python {
namespace {

/// The software of one vehicle without a simulator, for measurements from any source.
class Onboard {
 public:
  Onboard(const ReadScenario& read, int vehicle) {
    const std::vector<sim::VehicleConfig>& vehicles = read.scenario.vehicles;
    if (vehicle < 0 || vehicle >= static_cast<int>(vehicles.size()))
      throw py::index_error("vehicle: expected a number below " + std::to_string(vehicles.size()) + ", found " +
                            std::to_string(vehicle));
    const sim::VehicleConfig& config = vehicles[vehicle];
    AgentSetup setup;
    setup.self = vehicle;
    setup.num_vehicles = static_cast<int>(vehicles.size());
    for (const sim::VehicleConfig& other : vehicles) setup.vehicle_names.push_back(other.name);
    setup.airframe = config.airframe;
    setup.start_known = config.start.known;
    if (config.start.known != StartKnown::kNothing) setup.T_local_body_start.translation() = config.start.position_m;
    if (config.start.known == StartKnown::kPose) {
      const double yaw_rad = config.start.yaw_deg * EIGEN_PI / 180.0;
      setup.T_local_body_start.linear() = Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ()).toRotationMatrix();
    }
    setup.tick_s = read.scenario.tick_s;
    for (const Module& sensor : config.sensors) dynamic_cast<const sim::SensorConfig&>(*sensor.config).describe(setup);
    agent_ = make_agent(config.agent, setup);
    observation_.self = setup.self;
    num_vehicles_ = setup.num_vehicles;
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
      note_time(kind, sample.t);
      samples.push_back(sample);
    });
    if (!found) reject_kind(observation_, kind);
  }
  void add_scan(const HeldScan& held) {
    const Use use = call();
    note_time("scan of " + held.scan->sensor, held.scan->stamp);
    observation_.scans.push_back(held.scan);
  }

  void step(TimeNs t) {
    const Use use = call();
    require_time(t);
    observation_.t = t;
    const py::gil_scoped_release parallel;
    action_ = &agent_->step(observation_);
    stepped_ = true;
    const VehicleId self = observation_.self;
    observation_.clear();
    observation_.self = self;
  }

  const Action& action() const {
    const Use use = call();
    return *action_;
  }
  py::dict maps() const {
    const Use use = call();
    return maps_of(*agent_);
  }

 private:
  Use call() const { return {in_use_, "Onboard"}; }

  /// Times of one kind must not decrease.
  void note_time(const std::string& kind, TimeNs t) {
    TimeNs& latest = latest_.try_emplace(kind, t).first->second;
    if (t < latest)
      throw py::value_error(kind + ": t_ns: expected " + std::to_string(latest) +
                            ", as the one before, or later, found " + std::to_string(t));
    latest = t;
  }

  /// A step must be later than the previous one and not earlier than its measurements.
  void require_time(TimeNs t) const {
    if (stepped_ && t <= observation_.t)
      throw py::value_error("step: t_ns: expected a time after that of the step before, " +
                            std::to_string(observation_.t) + ", found " + std::to_string(t));
    for (const auto& [kind, latest] : latest_) {
      if (latest > t)
        throw py::value_error("step: t_ns: expected " + std::to_string(latest) + ", as of the latest " + kind +
                              ", or later, found " + std::to_string(t));
    }
  }

  std::unique_ptr<Agent> agent_;
  Observation observation_;
  Action idle_;
  const Action* action_ = nullptr;
  int num_vehicles_ = 0;
  bool stepped_ = false;
  std::map<std::string, TimeNs> latest_;  // latest time by kind
  mutable std::atomic<bool> in_use_ = false;
};

}  // namespace

void bind_onboard(py::module_& module) {
  py::class_<Onboard>(
      module, "Onboard",
      "The software of one vehicle without a simulator: localization or SLAM, detector, tracker, mapping and "
      "guidance, fed with measurements from anywhere.")
      .def(py::init<const ReadScenario&, int>(), py::arg("scenario"), py::arg("vehicle") = 0,
           "scenario: its vehicle's agent, sensors and start define the software. One thread at a time may use "
           "it.")
      .def(
          "add", [](Onboard& o, const std::string& kind, const py::kwargs& values) { o.add(kind, values); },
          py::arg("kind"),
          "A sample that is new since the last step: imu, odometry, gnss, altimeter, compass, pose, neighbors, with "
          "all columns of their tables, such as add('imu', t_ns=0, omega_radps=(0, 0, 0), f_mps2=(0, 0, 9.81)). Of one "
          "kind, times do not go back.")
      .def("add_scan", &Onboard::add_scan, py::arg("scan"), "A scan that is new since the last step.")
      .def("step", &Onboard::step, py::arg("t_ns"), "One tick at the instant t_ns [ns], later than the tick before.")
      .def_property_readonly("estimate", [](const Onboard& o) { return Table::row(o.action().estimate); })
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

}  // namespace swiftlet::python
