// SPDX-License-Identifier: BSD-3-Clause
#include "sim/python/simulator.hpp"

#include <pthread.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/python/bindings.hpp"
#include "sim/python/maps.hpp"
#include "sim/python/samples.hpp"
#include "sim/python/scan.hpp"
#include "sim/python/values.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/io/text.hpp"
#include "swiftlet/sim/run/summary.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"
#include "swiftlet/sim/scenario/yaml_writer.hpp"

namespace swiftlet::python {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// A fork copies only the calling thread. The threads of OpenMP, TBB and the renderer are missing in the new process, so
// that waiting for them would block for ever.
std::atomic<bool> g_made_a_simulator = false, g_was_forked = false;  // NOLINT: read by the handler of forks

void note_fork() { g_was_forked = g_made_a_simulator.load(); }

void require_own_threads() {
  if (!g_was_forked) return;
  throw std::runtime_error(
      "this process was forked from one that had made a simulator, and threads of it are missing here: start it by "
      "\"spawn\", such as multiprocessing.get_context(\"spawn\"), or before the first Simulator, fly or check");
}

/// The given world if it matches the scenario, otherwise a new one.
BuiltWorld world_of(const sim::Scenario& scenario, const BuiltWorld* given) {
  require_own_threads();
  g_made_a_simulator = true;
  Module config = scenario.world;
  const std::string text =
      "type: " + config.type + "\n" + sim::write_config([&](ConfigVisitor& v) { config.config->visit(v); });
  const std::uint64_t seed = scenario.seed_of_world();
  if (given == nullptr) return {sim::build_world(config, seed), text, seed};
  if (given->config != text)
    throw sim::InputError("world: expected that of the scenario, of type " + config.type +
                          ", found one with another type or other settings");
  if (given->seed != seed)
    throw sim::InputError("world: expected one of seed " + std::to_string(seed) +
                          " (world_seed, or else seed), found " + "one of seed " + std::to_string(given->seed));
  return *given;
}

Table states_of(const std::shared_ptr<sim::Simulation>& simulation) {
  const auto states = simulation->view().states;
  return Table::of(states.data(), states.size(), simulation);
}

sim::Scenario connected(sim::Scenario scenario, const std::shared_ptr<Commands>& commands) {
  connect_commands(scenario, commands);
  return scenario;
}

// (vehicles, numbers per row), writable by Python.
py::array commands_of(const Simulator& simulator) {
  const auto& commands = simulator.commands();
  auto* kept = new std::shared_ptr<Commands>(commands);
  const py::capsule base(kept, [](void* pointer) { delete static_cast<std::shared_ptr<Commands>*>(pointer); });
  const py::ssize_t num_columns = num_commands(simulator.simulation()->scenario());
  return py::array_t<double>({static_cast<py::ssize_t>(commands->size()), num_columns},
                             {sizeof(Commands::value_type), sizeof(double)},
                             commands->empty() ? nullptr : commands->front().data(), base);
}

/// One vehicle of a run: its observations and actions in the last tick.
struct Vehicle {
  std::shared_ptr<sim::Simulation> simulation;
  std::shared_ptr<std::atomic<bool>> in_use;
  VehicleId id = 0;

  /// View of the last tick; throws RuntimeError during a call that flies.
  const sim::TickView& view() const {
    const Use use(*in_use, "simulator");
    return simulation->view();
  }
  const Observation& observation() const { return view().observations[id]; }
  const Action& action() const { return *view().actions[id]; }
  const std::string& name() const { return simulation->info().vehicle_names[id]; }
};

VehicleId id_of(const sim::Simulation& simulation, const std::string& name) {
  const std::vector<std::string>& names = simulation.info().vehicle_names;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return static_cast<VehicleId>(i);
  }
  throw py::key_error("expected " + sim::one_of(names) + ", found \"" + name + "\"" + sim::did_you_mean(name, names));
}

std::vector<HeldScan> scans_of(const Vehicle& vehicle) {
  const auto& scans = vehicle.view().scans[vehicle.id];
  return {scans.begin(), scans.end()};
}

template <class Row>
Table copy_of(const std::vector<Row>& rows) {
  return Table::copy_of(std::span<const Row>(rows));
}

void bind_vehicle(py::module_& module) {
  py::class_<Vehicle>(
      module, "Vehicle",
      "One vehicle of a run: inputs, estimates and outputs of its software in the last tick. Positions are in "
      "the world as the vehicle knows it. Tables are copies, which stay as they are.")
      .def_property_readonly("id", [](const Vehicle& v) { return v.id; })
      .def_property_readonly("name", [](const Vehicle& v) { return v.name(); })
      .def_property_readonly(
          "estimate", [](const Vehicle& v) { return Table::row(v.action().estimate); },
          "The vehicle's estimate of its own state.")
      .def_property_readonly(
          "reference", [](const Vehicle& v) { return Table::row(v.action().reference); },
          "The reference of the controller, after the reference governor.")
      .def_property_readonly(
          "detections",
          [](const Vehicle& v) -> std::optional<Table> {
            if (!v.action().has_detections) return std::nullopt;
            return copy_of(v.action().detections);
          },
          "Detections of its detector; None in a tick without a finished scan.")
      .def_property_readonly(
          "has_tracks", [](const Vehicle& v) { return v.action().has_tracks; },
          "True if the tracker updated its tracks in this tick.")
      .def_property_readonly(
          "tracks", [](const Vehicle& v) { return copy_of(v.action().tracks); },
          "Tracks of its tracker, as of the last update.")
      .def_property_readonly(
          "relatives", [](const Vehicle& v) { return copy_of(v.action().relatives); },
          "Its estimates of its teammates' states.")
      .def_property_readonly(
          "messages", [](const Vehicle& v) { return copy_of(v.observation().messages); },
          "Messages that its radio received in this tick.")
      .def_property_readonly("scans", &scans_of, "Scans that its LiDARs completed in this tick, with their truth.")
      .def(
          "samples", [](const Vehicle& v, const std::string& kind) { return samples_named(v.observation(), kind); },
          py::arg("kind"), "Samples of this tick: imu, odometry, gnss, altimeter, compass, pose, neighbors.")
      .def(
          "maps",
          [](const Vehicle& v) {
            const Use use(*v.in_use, "simulator");
            return maps_of(*v.simulation->view().agents[v.id]);
          },
          "The maps of its software by stage, as of now: edge_m, states, centers_local_m (n, 3), state (n,), value "
          "(n,).")
      .def_property_readonly(
          "rotor_command",
          [](const Vehicle& v) {
            return py::array_t<double>(static_cast<py::ssize_t>(kMaxRotors), v.action().rotor_command.data());
          },
          "(8,), 0 to 1 between least and greatest rotor speed.")
      .def_property_readonly(
          "mission", [](const Vehicle& v) { return kMissionStatusWords[static_cast<std::size_t>(v.action().mission)]; },
          "running, endless, done or failed.")
      .def_property_readonly("mission_note", [](const Vehicle& v) { return v.action().mission_note; })
      .def("__repr__", [](const Vehicle& v) { return "<Vehicle " + v.name() + ">"; });
}

}  // namespace

/// A call that flies: one at a time, and not after an error.
class Simulator::Flight {
 public:
  explicit Flight(const Simulator& simulator) : use_(*simulator.in_use_, "simulator") {
    if (simulator.broken_) throw std::runtime_error("this run ended with an error");
  }

 private:
  Use use_;
};

bool DeleteUnlessForked::was_forked() { return g_was_forked; }

Simulator::Simulator(const ReadScenario& scenario, int threads, const BuiltWorld* world,
                     const std::optional<std::filesystem::path>& out)
    : world_(world_of(scenario.scenario, world)),
      commands_(std::make_shared<Commands>(scenario.scenario.vehicles.size())),
      simulation_(new sim::Simulation(connected(scenario.scenario, commands_), threads, world_.world),
                  DeleteUnlessForked()),
      directory_(out ? new sim::RunDirectory(*out, sim::named_files(scenario.scenario)) : nullptr),
      states_(states_of(simulation_)) {
  if (directory_) simulation_->attach_recorders(directory_->path());
  setup_wall_s_ = seconds_since(start_);
}

void Simulator::advance() try {
  simulation_->tick();
  const auto events = simulation_->view().events;
  events_.insert(events_.end(), events.begin(), events.end());
} catch (...) {
  broken_ = true;
  directory_.reset();  // an incomplete run directory must not appear under its final name
  throw;
}

int Simulator::tick(int count) {
  require_own_threads();
  if (count < 0) throw py::value_error("count: expected 0 or more, found " + std::to_string(count));
  const Flight flight(*this);
  const py::gil_scoped_release parallel;
  int done = 0;
  for (; done < count && !simulation_->finished(); ++done) advance();
  return done;
}

void Simulator::run(double until_s) {
  require_own_threads();
  if (std::isnan(until_s)) throw py::value_error("until_s: expected a number, found nan");
  const Flight flight(*this);
  const TimeNs until = until_s < 1e9 ? from_seconds(until_s) : std::numeric_limits<TimeNs>::max();
  const auto start = Clock::now();
  auto looked = start;
  const py::gil_scoped_release parallel;
  while (!simulation_->finished() && simulation_->now() < until) {
    advance();
    if (Clock::now() - looked < std::chrono::milliseconds(50)) continue;
    looked = Clock::now();
    const py::gil_scoped_acquire python;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
  wall_s_ += seconds_since(start);
}

void Simulator::finish() {
  require_own_threads();
  const Flight flight(*this);
  const py::gil_scoped_release parallel;
  simulation_->finish();
  if (!directory_) return;
  sim::write_file(directory_->path() / "scenario.yaml", sim::write_scenario(simulation_->scenario()));
  sim::write_file(directory_->path() / "summary.json", timed_summary());
  directory_->commit();
  directory_.reset();
}

Table Simulator::events() const {
  const Use use(*in_use_, "simulator");
  return Table::copy_of(std::span<const sim::Event>(events_));
}

std::string Simulator::summary_json() const {
  const Use use(*in_use_, "simulator");
  return timed_summary();
}

std::string Simulator::timed_summary() const {
  sim::RunSummary summary = simulation_->summary();
  summary.setup_wall_s = setup_wall_s_;
  summary.wall_s = wall_s_;
  return sim::to_json(summary);
}

namespace {

/// The vehicle of that name or number.
Vehicle vehicle_of(const Simulator& simulator, const py::object& which) {
  const auto& names = simulator.simulation()->info().vehicle_names;
  if (!py::isinstance<py::str>(which) && !PyIndex_Check(which.ptr()))
    throw py::type_error("which: expected a name or a number, found " + shown(which));
  const VehicleId id =
      py::isinstance<py::str>(which) ? id_of(*simulator.simulation(), which.cast<std::string>()) : which.cast<int>();
  if (id < 0 || id >= static_cast<VehicleId>(names.size()))
    throw py::index_error("expected a vehicle from 0 to " + std::to_string(names.size() - 1) + ", found " +
                          std::to_string(id));
  return Vehicle{simulator.simulation(), simulator.in_use(), id};
}

using SimulatorClass = py::class_<Simulator>;

/// Calls that fly.
void bind_flight(SimulatorClass& simulator) {
  simulator
      .def("tick", &Simulator::tick, py::arg("count") = 1,
           "Runs `count` ticks, at most until the run is over; returns the number of ticks.")
      .def(
          "run",
          [](Simulator& s, std::optional<double> until_s) {
            s.run(until_s.value_or(std::numeric_limits<double>::infinity()));
          },
          py::arg("until_s") = py::none(), "Runs until the simulated time `until_s`, or until the run is over.")
      .def("finish", &Simulator::finish, "Ends recording; the run directory appears under its name.");
}

/// State of the run.
void bind_state(SimulatorClass& simulator) {
  simulator.def_property_readonly("finished", &Simulator::finished, "True when the run is over.")
      .def_property_readonly(
          "t_s", [](const Simulator& s) { return to_seconds(s.simulation()->now()); }, "[s] simulated time.")
      .def_property_readonly(
          "t_ns", [](const Simulator& s) { return s.simulation()->now(); }, "[ns] simulated time.")
      .def_property_readonly(
          "state_hash", [](const Simulator& s) { return sim::hex64(s.simulation()->state_hash()); },
          "Hash of all states, measurements and actions so far, as in summary.json.")
      .def_property_readonly(
          "states", [](Simulator& s) -> Table& { return s.states(); }, py::return_value_policy::reference_internal,
          "True state of every vehicle (n rows): position_m, q_xyzw, v_mps, omega_radps, rotor_radps, crashed ... The "
          "arrays "
          "look into the simulator and always show the present; copy what is to stay.")
      .def_property_readonly("commands", &commands_of,
                             "(n, 4), commands of vehicles with `guidance: {type: commanded}`; more columns where an "
                             "`agent: {type: rotors}` "
                             "has more rotors. They hold until they are written again.")
      .def_property_readonly("events", &Simulator::events, "Events so far, such as crashes and ends of missions.")
      .def_property_readonly("world", [](const Simulator& s) { return s.world(); })
      .def_property_readonly(
          "vehicle_names", [](const Simulator& s) { return s.simulation()->info().vehicle_names; },
          "In the order of their numbers.")
      .def("vehicle", &vehicle_of, py::arg("which"), "One vehicle, by name or number.")
      .def("_summary_json", &Simulator::summary_json);
}

}  // namespace

void bind_simulator(py::module_& module) {
  add_commanded_modules();
  if (pthread_atfork(nullptr, nullptr, note_fork) != 0) throw std::runtime_error("cannot register a fork handler");
  py::class_<BuiltWorld>(module, "World", "The static part of a run, ready to trace; runs may share it.");
  bind_vehicle(module);
  using Out = std::optional<std::filesystem::path>;
  SimulatorClass simulator(
      module, "Simulator",
      "One run in lockstep. The same scenario gives the same bits as the program `swiftlet run`, for any "
      "number of threads.");
  simulator.def(
      py::init([](const ReadScenario& scenario, int threads, const BuiltWorld* world, const Out& out) {
        if (threads < 0) throw py::value_error("threads: expected 0 or more, found " + std::to_string(threads));
        const py::gil_scoped_release parallel;
        return std::make_unique<Simulator>(scenario, threads, world, out);
      }),
      py::arg("scenario"), py::arg("threads") = 0, py::arg("world") = py::none(), py::arg("out") = py::none(),
      "threads: 0 takes all processors, and changes no result. world: of an earlier simulator with the same world "
      "and seed. out: run directory, which appears at `finish`.");
  bind_flight(simulator);
  bind_state(simulator);
}

}  // namespace swiftlet::python
