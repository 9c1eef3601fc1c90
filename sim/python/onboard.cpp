// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include <limits>
#include <memory>

#include "sim/python/bindings.hpp"
#include "sim/python/field_values.hpp"
#include "sim/python/fields.hpp"
#include "sim/python/maps.hpp"
#include "sim/python/samples.hpp"
#include "sim/python/scan.hpp"
#include "sim/python/scenario.hpp"
#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/sim/sensors/sensor.hpp"

namespace swiftlet::python {
namespace {

/// The software of one vehicle without a simulator: it is told what its sensors measured, from anywhere.
class Onboard {
 public:
  Onboard(const ReadScenario& read, std::size_t vehicle) {
    const std::vector<sim::VehicleConfig>& vehicles = read.scenario.vehicles;
    if (vehicle >= vehicles.size()) throw py::index_error("there is no such vehicle");
    const sim::VehicleConfig& config = vehicles[vehicle];
    AgentSetup setup;
    setup.self = static_cast<VehicleId>(vehicle);
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
    action_ = &idle_;
  }

  void add(const std::string& kind, const py::dict& values) {
    bool found = false;
    Observation::each_samples(observation_, [&](auto& samples) {
      using Sample = typename std::decay_t<decltype(samples)>::value_type;
      if (kind != Sample::kName) return;
      found = true;
      samples.push_back(filled<Sample>(values));
    });
    if (!found) reject_kind(observation_, kind);
  }
  void add_scan(const HeldScan& held) { observation_.scans.push_back(held.scan); }

  void step(TimeNs t) {
    observation_.t = t;
    const py::gil_scoped_release parallel;
    action_ = &agent_->step(observation_);
    const VehicleId self = observation_.self;
    observation_.clear();
    observation_.self = self;
  }

  const Action& action() const { return *action_; }
  const Agent& agent() const { return *agent_; }

 private:
  std::unique_ptr<Agent> agent_;
  Observation observation_;
  Action idle_;
  const Action* action_ = nullptr;
};

using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// A range image of one's own: every beam with its direction.
HeldScan make_scan(const Floats& range_m, const Floats& directions, TimeNs t_ns, double duration_s,
                   const std::string& sensor, double range_max_m, double sigma_range_m,
                   const py::object& reflectivity) {
  if (range_m.ndim() != 2) throw py::value_error("range_m: expected (rows, cols)");
  const auto rows = static_cast<int>(range_m.shape(0)), cols = static_cast<int>(range_m.shape(1));
  if (directions.ndim() != 3 || directions.shape(0) != rows || directions.shape(1) != cols || directions.shape(2) != 3)
    throw py::value_error("directions_lidar: expected (rows, cols, 3) as range_m has them");
  auto beams = std::make_shared<BeamTable>();
  beams->rows = rows;
  beams->cols = cols;
  beams->directions_lidar.resize(static_cast<std::size_t>(rows) * cols);
  std::copy_n(directions.data(), directions.size(), beams->directions_lidar.front().data());
  beams->origins_lidar.assign(beams->directions_lidar.size(), Eigen::Vector3f::Zero());
  beams->column_offset_s.resize(cols);
  for (int i = 0; i < cols; ++i) beams->column_offset_s[i] = static_cast<float>(duration_s * i / cols);
  auto scan = std::make_shared<Scan>();
  scan->sensor = sensor;
  scan->stamp = t_ns;
  scan->duration = from_seconds(duration_s);
  scan->range_max_m = range_max_m;
  scan->sigma_range_m = sigma_range_m;
  scan->range_m.assign(range_m.data(), range_m.data() + range_m.size());
  for (float& range : scan->range_m) {
    if (!(range > 0.0F) || range > range_max_m) range = 0.0F;  // NaN and infinity are no returns
  }
  scan->intensity.assign(scan->range_m.size(), 0.0F);
  if (!reflectivity.is_none()) {
    const auto values = reflectivity.cast<Floats>();
    if (values.size() != range_m.size())
      throw py::value_error("reflectivity: expected (rows, cols) as range_m has them");
    scan->reflectivity.assign(values.data(), values.data() + values.size());
  } else {
    scan->reflectivity.assign(scan->range_m.size(), 0.0F);
  }
  scan->beams = std::move(beams);
  return HeldScan(std::shared_ptr<const Scan>(std::move(scan)));
}

}  // namespace

void bind_onboard(py::module_& module) {
  module.def(
      "make_scan", &make_scan, py::arg("range_m"), py::arg("directions_lidar"), py::arg("t_ns"), py::kw_only(),
      py::arg("duration_s") = 0.0, py::arg("sensor") = "lidar", py::arg("range_max_m") = 120.0,
      py::arg("sigma_range_m") = 0.02, py::arg("reflectivity") = py::none(),
      "A scan from one's own arrays: range_m (rows, cols) [m], 0 or not finite: no return; directions_lidar (rows, "
      "cols, 3), unit vectors. Columns fire one after another during duration_s [s].");
  py::class_<Onboard>(
      module, "Onboard",
      "The software of one vehicle without a simulator: localization or SLAM, detector, tracker, mapping and "
      "guidance, fed with measurements from anywhere.")
      .def(py::init<const ReadScenario&, std::size_t>(), py::arg("scenario"), py::arg("vehicle") = 0,
           "scenario: its vehicle's agent, sensors and start tell what the software is.")
      .def(
          "add", [](Onboard& o, const std::string& kind, const py::kwargs& values) { o.add(kind, values); },
          py::arg("kind"),
          "A sample that is new since the last step: imu, odometry, gnss, altimeter, compass, pose, neighbors, with "
          "the "
          "columns of their tables, such as add('imu', t_ns=0, omega_radps=(0, 0, 0), f_mps2=(0, 0, 9.81)).")
      .def("add_scan", &Onboard::add_scan, py::arg("scan"), "A scan that is new since the last step.")
      .def("step", &Onboard::step, py::arg("t_ns"), "One tick at the instant t_ns [ns].")
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
      .def(
          "maps", [](const Onboard& o) { return maps_of(o.agent()); }, "As of a vehicle of a simulator.");
}

}  // namespace swiftlet::python
