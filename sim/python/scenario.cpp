// SPDX-License-Identifier: BSD-3-Clause
#include "sim/python/scenario.hpp"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "sim/python/bindings.hpp"
#include "swiftlet/sim/plugin/plugin.hpp"
#include "swiftlet/sim/scenario/yaml_reader.hpp"

namespace swiftlet::python {
namespace {

ReadScenario load(const std::filesystem::path& file, const ConfigChanges& changes) {
  return {file, changes, sim::load_scenario(file, changes), std::nullopt};
}

/// A text instead of a file; `name` replaces the file in messages.
ReadScenario load_text(const std::string& text, const std::string& name, const ConfigChanges& changes) {
  ReadScenario read{name, changes, {}, text};
  sim::read_config_text(
      text, name, [&](ConfigVisitor& v) { read.scenario.visit(v); }, changes);
  return read;
}

ReadScenario changed(const ReadScenario& before, const ConfigChanges& further) {
  ConfigChanges changes = before.changes;
  changes.insert(changes.end(), further.begin(), further.end());
  return before.text ? load_text(*before.text, before.file.string(), changes) : load(before.file, changes);
}

std::vector<std::string> names_of(const sim::Scenario& scenario) {
  std::vector<std::string> names;
  for (const sim::VehicleConfig& vehicle : scenario.vehicles) names.push_back(vehicle.name);
  return names;
}

}  // namespace

void bind_scenario(py::module_& module) {
  py::class_<ReadScenario>(module, "Scenario", "The complete scenario of one run, read and checked by `load`.")
      .def_property_readonly("name", [](const ReadScenario& s) { return s.scenario.name; })
      .def_property_readonly("description", [](const ReadScenario& s) { return s.scenario.description; })
      .def_property_readonly("seed", [](const ReadScenario& s) { return s.scenario.seed; })
      .def_property_readonly(
          "duration_s", [](const ReadScenario& s) { return s.scenario.duration_s; },
          "[s] simulated time at which the run ends at the latest.")
      .def_property_readonly(
          "tick_s", [](const ReadScenario& s) { return s.scenario.tick_s; }, "[s] period of sensing and deciding.")
      .def_property_readonly("vehicle_names", [](const ReadScenario& s) { return names_of(s.scenario); })
      .def_property_readonly(
          "yaml", [](const ReadScenario& s) { return sim::write_scenario(s.scenario); },
          "The complete scenario with every default, as a run writes it to scenario.yaml.")
      .def("_changed", &changed, py::arg("changes"));
  module.def("_load", &load, py::arg("file"), py::arg("changes"));
  module.def(
      "allow_plugins", [] { sim::allow_plugins(std::string(sim::version()) + " (" + sim::git_revision() + ")"); },
      "From now on the shared libraries that scenarios name by `plugins` are loaded: they run code of their own.");
  module.def("_load_text", &load_text, py::arg("text"), py::arg("name"), py::arg("changes"));
}

}  // namespace swiftlet::python
