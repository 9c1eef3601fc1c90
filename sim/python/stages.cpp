// SPDX-License-Identifier: BSD-3-Clause
#include "sim/python/stages.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "sim/python/fields.hpp"
#include "sim/python/modules.hpp"
#include "sim/python/samples.hpp"
#include "sim/python/scan.hpp"
#include "sim/python/values.hpp"
#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/stage_tables/detectors.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"

namespace swiftlet::python {
namespace {

/// A cloud held by Python.
struct HeldCloud {
  std::shared_ptr<const LocalCloud> cloud;
};

/// Inputs lent to a Python module for the duration of one step.
struct Lent {
  const Observation* observation = nullptr;  ///< null: the step is over
  const StateEstimate* estimate = nullptr;   ///< null for agents, which estimate their own state
  std::span<const std::shared_ptr<const LocalCloud>> clouds = {};
  std::span<const Detection> detections = {};
  std::span<const Track> tracks = {};
  std::span<const RelativeEstimate> relatives = {};
  const OccupancyView* map = nullptr;
  Outbox* outbox = nullptr;
  double dt_s = 0.0;

  const Observation& sensed() const {
    if (observation == nullptr)
      throw std::runtime_error("the arguments of a step are valid until it returns: copy them to keep them");
    return *observation;
  }
  const StateEstimate& known() const {
    (void)sensed();
    if (estimate == nullptr) throw std::runtime_error("an agent makes its own estimate");
    return *estimate;
  }
  const OccupancyView& mapped() const {
    (void)sensed();
    if (map == nullptr) throw std::runtime_error("there is no map: name one by `mapping:` in the scenario");
    return *map;
  }
};

/// Output of a Python guidance.
struct Goal {
  Reference reference;
  bool in_world = true;
  bool is_feasible = false;
  double speed_limit_mps = std::numeric_limits<double>::infinity();
  bool motors_on = true;
  MissionStatus mission = MissionStatus::kRunning;
  std::string note;
};

/// Output of a Python agent.
struct Command {
  std::vector<double> rotors;
  std::optional<Pose> T_world_body;
  Vector3 v_world_mps = Vector3::Zero();
  Reference reference;
  MissionStatus mission = MissionStatus::kEndless;
};

py::array vector_array(const Vector3& value) { return py::array_t<double>(3, value.data()); }

MissionStatus mission_from(const std::string& word) {
  const auto status = enum_named<MissionStatus>(word, kMissionStatusWords);
  if (!status) throw py::value_error("mission: expected running, endless, done or failed, found \"" + word + "\"");
  return *status;
}

/// The object, its bound method `step`, and the inputs lent to it.
class Stepper {
 public:
  Stepper(const ModuleConfig& config, const AgentSetup& setup)
      : its_class(*dynamic_cast<const PythonConfig&>(config).of),
        object_(make_object(dynamic_cast<const PythonConfig&>(config), setup)) {
    const py::gil_scoped_acquire python;
    step_ = std::make_unique<OwnedObject>(object_->get().attr("step"));
    name_ = py::handle(its_class.type).attr("__qualname__").cast<std::string>() + ".step";
    lent_object_ = std::make_unique<OwnedObject>(py::cast(lent_));
  }

  /// Requires the GIL.
  py::object step(const Lent& lent) {
    *lent_ = lent;
    struct End {
      Lent& lent;
      ~End() { lent = {}; }
    } end{*lent_};
    return step_->get()(lent_object_->get());
  }

  /// Throws TypeError with class and method for an invalid return value of the step.
  [[noreturn]] void reject(const std::string& expected, py::handle found) const {
    throw py::type_error(name_ + ": expected " + expected + ", found " + shown(found));
  }
  /// Throws ValueError with class and method for a non-finite number returned by the step.
  template <class Value>
  void require_finite(const Value& value, const char* what) const {
    if (!is_finite(value)) (void)finite(value, name_ + ": " + what);
  }
  const std::string& name() const { return name_; }

  const PythonClass& its_class;

 private:
  std::shared_ptr<Lent> lent_ = std::make_shared<Lent>();
  std::unique_ptr<OwnedObject> object_, step_, lent_object_;
  std::string name_;  // class and method
};

class PythonGuidance final : public Guidance {
 public:
  PythonGuidance(const ModuleConfig& config, const GuidanceSetup& setup) : stepper_(config, setup.agent) {
    const Pose& start = setup.agent.T_local_body_start;
    goal_.reference.position_m = start.translation();
    goal_.reference.yaw_rad = yaw_of(start.linear());
    goal_.in_world = false;
  }

  GuidanceNeeds needs() const override {
    const PythonClass& definition = stepper_.its_class;
    return {.clouds = definition.needs_clouds,
            .map = definition.needs_map,
            .relatives = definition.needs_relatives,
            .world = definition.needs_world};
  }

  void step(const GuidanceInput& input, GuidanceOutput& output, Outbox& outbox) override {
    take({.observation = &input.observation,
          .estimate = &input.estimate,
          .clouds = input.clouds,
          .detections = input.detections,
          .tracks = input.tracks,
          .relatives = input.relatives,
          .map = input.map,
          .outbox = &outbox,
          .dt_s = input.dt_s});
    output.goal = goal_.in_world ? FrameChange::to_local(input.estimate).reference(goal_.reference) : goal_.reference;
    output.goal_is_feasible = goal_.is_feasible;
    output.speed_limit_mps = goal_.speed_limit_mps;
    output.motors_on = goal_.motors_on;
    output.mission = goal_.mission;
    output.note = goal_.note.c_str();
  }

 private:
  void take(const Lent& lent) {
    const py::gil_scoped_acquire python;
    const py::object wanted = stepper_.step(lent);
    if (wanted.is_none()) return;  // the last goal holds
    if (py::isinstance<Goal>(wanted)) {
      goal_ = wanted.cast<const Goal&>();
    } else {
      const double yaw_rad =
          goal_.in_world ? goal_.reference.yaw_rad : FrameChange::to_world(*lent.estimate).yaw(goal_.reference.yaw_rad);
      goal_ = {};
      goal_.reference.position_m = vector_from(wanted, stepper_.name() + ": a goal");
      goal_.reference.yaw_rad = yaw_rad;
    }
    const Reference& reference = goal_.reference;
    stepper_.require_finite(reference.position_m, "position_m");
    stepper_.require_finite(reference.velocity_mps, "velocity_mps");
    stepper_.require_finite(reference.acceleration_mps2, "acceleration_mps2");
    stepper_.require_finite(reference.yaw_rad, "yaw_rad");
    stepper_.require_finite(reference.yaw_rate_radps, "yaw_rate_radps");
    if (!(goal_.speed_limit_mps >= 0.0))
      throw py::value_error(stepper_.name() + ": speed_limit_mps: expected 0 or more, found " +
                            std::to_string(goal_.speed_limit_mps));
  }

  Stepper stepper_;
  Goal goal_;
};

class PythonDetector final : public Detector {
 public:
  PythonDetector(const ModuleConfig& config, const AgentSetup& setup) : stepper_(config, setup) {}

  void step(const DetectorInput& input, DetectorOutput& output, Outbox& outbox) override {
    const py::gil_scoped_acquire python;
    const py::object found = stepper_.step(
        {.observation = &input.observation, .estimate = &input.estimate, .clouds = input.clouds, .outbox = &outbox});
    if (found.is_none()) return;
    output.has_detections = true;
    output.stamp = input.clouds.empty() ? input.t : input.clouds.back()->stamp();
    const TimeNs middle = input.clouds.empty() ? input.t : (output.stamp + input.clouds.back()->end()) / 2;
    if (!py::isinstance<py::iterable>(found)) stepper_.reject("a list of Detection, or None", found);
    for (const py::handle one : found) {
      if (!py::isinstance<Detection>(one)) stepper_.reject("a list of Detection, or None", found);
      Detection& detection = output.detections.emplace_back(one.cast<const Detection&>());
      stepper_.require_finite(detection.position_m, "position_m");
      stepper_.require_finite(detection.covariance, "sigma_m");
      stepper_.require_finite(detection.extent_m, "extent_m");
      stepper_.require_finite(detection.confidence, "confidence");
      if (detection.t == 0) detection.t = middle;
    }
  }

 private:
  Stepper stepper_;
};

class PythonAgent final : public Agent {
 public:
  PythonAgent(const ModuleConfig& config, const AgentSetup& setup)
      : stepper_(config, setup), num_rotors_(setup.airframe.num_rotors()) {
    action_.mission = MissionStatus::kEndless;
  }

  const Action& step(const Observation& observation) override {
    action_.clear_outputs();
    Outbox outbox(observation.self);
    const py::gil_scoped_acquire python;
    const py::object wanted = stepper_.step({.observation = &observation, .outbox = &outbox});
    if (wanted.is_none()) return action_;
    if (py::isinstance<Command>(wanted)) {
      const auto& command = wanted.cast<const Command&>();
      take_rotors(command.rotors);
      stepper_.require_finite(command.v_world_mps, "v_world_mps");
      stepper_.require_finite(command.reference.position_m, "reference_m");
      if (command.T_world_body) (void)rigid(*command.T_world_body, stepper_.name() + ": T_world_body");
      action_.mission = command.mission;
      action_.reference = command.reference;
      action_.estimate.t = observation.t;
      action_.estimate.valid = command.T_world_body.has_value();
      action_.estimate.T_local_body = command.T_world_body.value_or(Pose::Identity());
      action_.estimate.v_local_mps = command.v_world_mps;
    } else {
      const Numbers<double> rotors(numbers_from(wanted, stepper_.name() + ": rotors"));
      take_rotors({rotors.data(), rotors.data() + rotors.size()});
    }
    outbox.empty_into(action_.messages);
    return action_;
  }

 private:
  void take_rotors(const std::vector<double>& commands) {
    if (static_cast<int>(commands.size()) != num_rotors_)
      throw py::value_error(stepper_.name() + ": rotors: expected " + std::to_string(num_rotors_) + " numbers, found " +
                            std::to_string(commands.size()));
    for (const double command : commands) stepper_.require_finite(command, "rotors");
    std::ranges::copy(commands, action_.rotor_command.begin());
  }

  Stepper stepper_;
  int num_rotors_;
  Action action_;
};

const PythonClass& class_of(const ModuleConfig& config) { return *dynamic_cast<const PythonConfig&>(config).of; }

std::unique_ptr<Guidance> make_python_guidance(const ModuleConfig& config, const GuidanceSetup& setup) {
  return std::make_unique<PythonGuidance>(config, setup);
}
std::unique_ptr<Detector> make_python_detector(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<PythonDetector>(config, setup);
}
std::unique_ptr<Agent> make_python_agent(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<PythonAgent>(config, setup);
}
void add_needs(const ModuleConfig& config, AgentNeeds& needs) {
  needs.true_pose = needs.true_pose || class_of(config).needs.true_pose;
  needs.true_neighbors = needs.true_neighbors || class_of(config).needs.true_neighbors;
}
void add_needs_of_detector(const ModuleConfig& config, AgentNeeds& needs) {
  add_needs(config, needs);
  needs.detects = true;
}
AgentNeeds needs_of_agent(const ModuleConfig& config) { return class_of(config).needs; }

template <class Row>
Table table_of(const Lent& lent, std::span<const Row> Lent::*rows) {
  (void)lent.sensed();
  return Table::copy_of(lent.*rows);
}

std::vector<HeldScan> sensed_scans(const Lent& lent) {
  return {lent.sensed().scans.begin(), lent.sensed().scans.end()};
}

void send(Lent& lent, const std::string& topic, const py::bytes& payload, VehicleId to) {
  (void)lent.sensed();
  const std::string_view bytes = payload;
  Message& message = lent.outbox->add(to);
  message.topic = topic;
  message.version = 1;
  message.sent = lent.observation->t;
  message.payload.resize(bytes.size());
  std::ranges::transform(bytes, message.payload.begin(), [](char c) { return static_cast<std::byte>(c); });
}

py::array occupied_within(const Lent& lent, const py::object& center, double radius_m) {
  auto centers = std::make_shared<std::vector<Vector3>>();
  lent.mapped().occupied_within(finite(vector_from(center, "center_local_m"), "center_local_m"),
                                finite(radius_m, "radius_m"), kEver, *centers);
  return view_of(reinterpret_cast<const double*>(centers->data()), {static_cast<py::ssize_t>(centers->size()), 3},
                 centers);
}

void bind_clouds(py::module_& module) {
  py::class_<HeldCloud>(module, "Cloud",
                        "One sweep in the vehicle's local frame, every beam placed by the pose at its own firing.")
      .def_property_readonly(
          "points_local_m",
          [](const HeldCloud& h) {
            return view_of(reinterpret_cast<const float*>(h.cloud->points_local_m.data()),
                           {static_cast<py::ssize_t>(h.cloud->size()), 3}, h.cloud);
          },
          "(n, 3) float32, [m] the returns, local frame; without the own body.")
      .def_property_readonly(
          "beam",
          [](const HeldCloud& h) {
            return view_of(h.cloud->beam.data(), {static_cast<py::ssize_t>(h.cloud->size())}, h.cloud);
          },
          "(n,) uint32, beam of each point: index into the flat arrays of the scan.")
      .def_property_readonly("scan", [](const HeldCloud& h) { return HeldScan(h.cloud->scan); })
      .def_property_readonly(
          "t_ns", [](const HeldCloud& h) { return h.cloud->stamp(); }, "[ns] start of the sweep.")
      .def("__len__", [](const HeldCloud& h) { return h.cloud->size(); });
}

using InputClass = py::class_<Lent, std::shared_ptr<Lent>>;

void bind_estimate(InputClass& input) {
  input
      .def_property_readonly(
          "estimate", [](const Lent& l) { return Table::row(l.known()); }, "The vehicle's estimate of its own state.")
      .def_property_readonly(
          "p_world_m", [](const Lent& l) { return vector_array(l.known().T_world_body().translation()); },
          "(3,) [m] estimated position in the world.")
      .def_property_readonly(
          "v_world_mps", [](const Lent& l) { return vector_array(l.known().v_world_mps()); },
          "(3,) [m/s] estimated velocity, in world axes.")
      .def_property_readonly(
          "yaw_world_rad", [](const Lent& l) { return yaw_of(l.known().T_world_body().linear()); },
          "[rad] estimated heading, counter-clockwise from east.")
      .def_property_readonly(
          "p_local_m", [](const Lent& l) { return vector_array(l.known().T_local_body.translation()); },
          "(3,) [m] estimated position in its local frame.");
}

/// What sensors and other stages delivered.
void bind_perception(InputClass& input) {
  input.def_property_readonly("detections", [](const Lent& l) { return table_of(l, &Lent::detections); })
      .def_property_readonly("tracks", [](const Lent& l) { return table_of(l, &Lent::tracks); })
      .def_property_readonly("relatives", [](const Lent& l) { return table_of(l, &Lent::relatives); })
      .def_property_readonly("clouds",
                             [](const Lent& l) {
                               (void)l.sensed();
                               std::vector<HeldCloud> clouds;
                               for (const auto& cloud : l.clouds) clouds.push_back({cloud});
                               return clouds;
                             })
      .def_property_readonly("scans", &sensed_scans, "Scans that were completed in this tick, without truth.")
      .def_property_readonly(
          "messages", [](const Lent& l) { return Table::copy_of(std::span<const Message>(l.sensed().messages)); },
          "Messages that the radio received in this tick.")
      .def(
          "samples", [](const Lent& l, const std::string& kind) { return samples_named(l.sensed(), kind); },
          py::arg("kind"), "Samples of this tick: imu, gnss, altimeter, compass, pose ...")
      .def("send", &send, py::arg("topic"), py::arg("payload"), py::arg("to") = kNoVehicle,
           "Sends a message by radio; `to` is the number of a vehicle, -1: broadcast.");
}

void bind_map(InputClass& input) {
  input
      .def(
          "map_distance_m",
          [](const Lent& l, const py::object& at, double max_m) {
            return l.mapped().distance_m(finite(vector_from(at, "p_local_m"), "p_local_m"), finite(max_m, "max_m"));
          },
          py::arg("p_local_m"), py::arg("max_m") = 5.0, "[m] distance to the nearest occupied cell; at most max_m.")
      .def(
          "map_state",
          [](const Lent& l, const py::object& at) {
            constexpr const char* kWords[] = {"unknown", "free", "occupied"};
            const Vector3 p_local_m = finite(vector_from(at, "p_local_m"), "p_local_m");
            return kWords[static_cast<std::size_t>(l.mapped().state(p_local_m))];
          },
          py::arg("p_local_m"), "unknown, free or occupied.")
      .def("map_occupied_within", &occupied_within, py::arg("center_local_m"), py::arg("radius_m"),
           "(n, 3) [m] centers of occupied cells in a ball.");
}

void bind_input(py::module_& module) {
  InputClass input(module, "StepInput",
                   "Inputs of a module in one tick, valid until `step` returns. Positions are in "
                   "the vehicle's local frame, unless their name says world.");
  input
      .def_property_readonly(
          "t_s", [](const Lent& l) { return to_seconds(l.sensed().t); }, "[s] now.")
      .def_property_readonly(
          "t_ns", [](const Lent& l) { return l.sensed().t; }, "[ns] now.")
      .def_property_readonly(
          "dt_s", [](const Lent& l) { return l.dt_s; }, "[s] since the last tick.")
      .def_property_readonly(
          "id", [](const Lent& l) { return l.sensed().self; }, "Number of the vehicle.");
  bind_estimate(input);
  bind_perception(input);
  bind_map(input);
}

void bind_outputs(py::module_& module) {
  py::class_<Goal>(module, "Goal", "Goal of guidance. The reference governor makes it feasible.")
      .def(
          py::init([](const py::object& position_m, const py::object& velocity_mps, const py::object& acceleration_mps2,
                      double yaw_rad, double yaw_rate_radps, const std::string& frame, bool feasible,
                      double speed_limit_mps, bool motors_on, const std::string& mission, std::string note) {
            if (frame != "world" && frame != "local")
              throw py::value_error("frame: expected world or local, found \"" + frame + "\"");
            return Goal{.reference = {vector_from(position_m, "position_m"), vector_from(velocity_mps, "velocity_mps"),
                                      vector_from(acceleration_mps2, "acceleration_mps2"), yaw_rad, yaw_rate_radps},
                        .in_world = frame == "world",
                        .is_feasible = feasible,
                        .speed_limit_mps = speed_limit_mps,
                        .motors_on = motors_on,
                        .mission = mission_from(mission),
                        .note = std::move(note)};
          }),
          py::arg("position_m"), py::kw_only(), py::arg("velocity_mps") = py::make_tuple(0.0, 0.0, 0.0),
          py::arg("acceleration_mps2") = py::make_tuple(0.0, 0.0, 0.0), py::arg("yaw_rad") = 0.0,
          py::arg("yaw_rate_radps") = 0.0, py::arg("frame") = "world", py::arg("feasible") = false,
          py::arg("speed_limit_mps") = std::numeric_limits<double>::infinity(), py::arg("motors_on") = true,
          py::arg("mission") = "running", py::arg("note") = "");
  py::class_<Detection>(module, "Detection", "A flying object found in a scan, in the vehicle's local frame.")
      .def(py::init([](const py::object& position_m, double sigma_m, const py::object& extent_m, int num_points,
                       double confidence, TimeNs t_ns) {
             Detection detection;
             detection.t = t_ns;
             detection.position_m = vector_from(position_m, "position_m");
             detection.covariance = sigma_m * sigma_m * Matrix3::Identity();
             detection.extent_m = vector_from(extent_m, "extent_m");
             detection.num_points = num_points;
             detection.confidence = confidence;
             return detection;
           }),
           py::arg("position_m"), py::kw_only(), py::arg("sigma_m") = 0.2,
           py::arg("extent_m") = py::make_tuple(0.0, 0.0, 0.0), py::arg("num_points") = 1, py::arg("confidence") = 1.0,
           py::arg("t_ns") = 0, "t_ns 0: the middle of the newest sweep.");
  py::class_<Command>(module, "Command", "Output of an agent: rotor commands and estimates.")
      .def(py::init([](const py::object& rotors, const py::object& T_world_body, const py::object& v_world_mps,
                       const py::object& reference_m, const std::string& mission) {
             Command command;
             const Numbers<double> numbers(numbers_from(rotors, "rotors"));
             command.rotors.assign(numbers.data(), numbers.data() + numbers.size());
             if (!T_world_body.is_none()) command.T_world_body = pose_from(T_world_body, "T_world_body");
             command.v_world_mps = vector_from(v_world_mps, "v_world_mps");
             command.reference.position_m = vector_from(reference_m, "reference_m");
             command.mission = mission_from(mission);
             return command;
           }),
           py::arg("rotors"), py::kw_only(), py::arg("T_world_body") = py::none(),
           py::arg("v_world_mps") = py::make_tuple(0.0, 0.0, 0.0),
           py::arg("reference_m") = py::make_tuple(0.0, 0.0, 0.0), py::arg("mission") = "endless");
}

}  // namespace

void add_row(const std::string& kind, const ModuleType& module) {
  if (kind == "guidance") {
    guidance_registry().add({module, make_python_guidance, add_needs});
  } else if (kind == "detector") {
    detector_registry().add({module, make_python_detector, add_needs_of_detector});
  } else {
    agent_registry().add({module, make_python_agent, needs_of_agent});
  }
}

void bind_stages(py::module_& module) {
  bind_clouds(module);
  bind_input(module);
  bind_outputs(module);
}

}  // namespace swiftlet::python
