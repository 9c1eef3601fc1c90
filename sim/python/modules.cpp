// SPDX-License-Identifier: BSD-3-Clause
#include "sim/python/modules.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <array>
#include <type_traits>
#include <utility>

#include "sim/python/bindings.hpp"
#include "sim/python/stages.hpp"
#include "sim/python/values.hpp"

namespace swiftlet::python {
namespace {

// Registries accept functions without context, so each class uses a slot with a function of its own.
constexpr std::size_t kMaxClasses = 64;
std::array<const PythonClass*, kMaxClasses> g_classes{};  // NOLINT: written with the GIL held
std::size_t g_num_classes = 0;                            // NOLINT

template <std::size_t Slot>
std::unique_ptr<ModuleConfig> make_config() {
  return std::make_unique<PythonConfig>(*g_classes[Slot]);
}

using MakeConfig = std::unique_ptr<ModuleConfig> (*)();
template <std::size_t... Slots>
constexpr std::array<MakeConfig, kMaxClasses> makers(std::index_sequence<Slots...>) {
  return {&make_config<Slots>...};
}
constexpr auto kMakers = makers(std::make_index_sequence<kMaxClasses>());

KeyValue value_from(py::handle value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::int_>(value)) return value.cast<int>();
  if (py::isinstance<py::float_>(value)) return value.cast<double>();
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::isinstance<py::tuple>(value)) return vector_from(value, "a key");
  return value.cast<std::vector<double>>();
}

py::object value_of(const KeyValue& value) {
  return std::visit(
      [](const auto& held) -> py::object {
        if constexpr (std::is_same_v<std::decay_t<decltype(held)>, Vector3>) {
          return py::array_t<double>(3, held.data());
        } else {
          return py::cast(held);
        }
      },
      value);
}

Key key_from(const py::tuple& definition) {
  Key key{definition[0].cast<std::string>(), definition[1].cast<std::string>(), value_from(definition[2]), Range::any(),
          definition[5].cast<std::vector<std::string>>()};
  if (!definition[3].is_none()) key.range.min = definition[3].cast<double>();
  if (!definition[4].is_none()) key.range.max = definition[4].cast<double>();
  return key;
}

AgentNeeds needs_from(const py::dict& needs) {
  AgentNeeds out;
  out.true_pose = needs["true_pose"].cast<bool>();
  out.true_neighbors = needs["true_neighbors"].cast<bool>();
  out.detects = needs["detects"].cast<bool>();
  return out;
}

/// @return whether the name is new: a class defined again replaces the earlier one
void add_class(const std::string& kind, const std::string& name, const std::string& doc, const py::object& type,
               const py::list& keys, const py::dict& needs) {
  auto* definition = new PythonClass{name, doc, type.inc_ref().ptr(), {}, needs_from(needs)};
  for (const py::handle key : keys) definition->keys.push_back(key_from(py::cast<py::tuple>(key)));
  definition->needs_clouds = needs["clouds"].cast<bool>();
  definition->needs_map = needs["map"].cast<bool>();
  definition->needs_relatives = needs["relatives"].cast<bool>();
  definition->needs_world = needs["world"].cast<bool>();
  static std::vector<std::string> kinds;  // indexed by slot
  for (std::size_t i = 0; i < g_num_classes; ++i) {
    if (kinds[i] != kind || g_classes[i]->name != name) continue;
    g_classes[i] = definition;  // redefinition, as in a notebook
    return;
  }
  if (g_num_classes == kMaxClasses) throw std::runtime_error("there are 64 modules of Python already");
  const ModuleType module{definition->name.c_str(), definition->doc.c_str(), kMakers[g_num_classes]};
  add_row(kind, module);  // throws when the name is taken
  kinds.push_back(kind);
  g_classes[g_num_classes++] = definition;
}

py::dict airframe_dict(const Airframe& airframe) {
  py::dict dict;
  dict["mass_kg"] = airframe.mass_kg;
  dict["inertia_diagonal_kgm2"] = py::array_t<double>(3, airframe.inertia_diagonal_kgm2.data());
  dict["thrust_constant_N_per_radps2"] = airframe.thrust_constant_N_per_radps2;
  dict["torque_to_thrust_m"] = airframe.torque_to_thrust_m;
  dict["rotor_speed_min_radps"] = airframe.rotor_speed_min_radps;
  dict["rotor_speed_max_radps"] = airframe.rotor_speed_max_radps;
  py::list positions, directions;
  for (const Rotor& rotor : airframe.rotors) {
    positions.append(py::array_t<double>(3, rotor.position_m.data()));
    directions.append(rotor.direction());
  }
  dict["rotor_positions_body_m"] = positions;
  dict["rotor_directions"] = directions;
  dict["radius_m"] = airframe.circumscribed_radius_m();
  return dict;
}

py::dict setup_dict(const AgentSetup& setup) {
  py::dict dict;
  dict["id"] = setup.self;
  dict["name"] = setup.vehicle_names.empty() ? "" : setup.vehicle_names[setup.self];
  dict["vehicle_names"] = setup.vehicle_names;
  dict["tick_s"] = setup.tick_s;
  py::array_t<double> start({4, 4});
  for (int row = 0; row < 4; ++row) {
    for (int col = 0; col < 4; ++col) start.mutable_at(row, col) = setup.T_local_body_start.matrix()(row, col);
  }
  dict["T_local_body_start"] = start;
  dict["airframe"] = airframe_dict(setup.airframe);
  return dict;
}

}  // namespace

PythonConfig::PythonConfig(const PythonClass& its_class) : of(&its_class) {
  for (const Key& key : of->keys) values.push_back(key.standard);
}

void PythonConfig::visit(ConfigVisitor& v) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Key& key = of->keys[i];
    const char* name = key.name.c_str();
    const char* doc = key.doc.c_str();
    std::visit(
        [&](auto& value) {
          using Type = std::decay_t<decltype(value)>;
          if constexpr (std::is_same_v<Type, bool>) {
            v.field(name, value, doc);
          } else if constexpr (std::is_same_v<Type, std::string>) {
            std::vector<const char*> words;
            for (const std::string& word : key.words) words.push_back(word.c_str());
            if (words.empty()) {
              v.field(name, value, doc);
            } else {
              v.choice(name, value, std::span<const char* const>(words), doc);
            }
          } else {
            v.field(name, value, doc, key.range);
          }
        },
        values[i]);
  }
}

OwnedObject::~OwnedObject() {
  if (!Py_IsInitialized()) return;
  const py::gil_scoped_acquire python;
  object_.dec_ref();
}

std::unique_ptr<OwnedObject> make_object(const PythonConfig& config, const AgentSetup& setup) {
  const py::gil_scoped_acquire python;
  py::dict values;
  for (std::size_t i = 0; i < config.values.size(); ++i)
    values[py::str(config.of->keys[i].name)] = value_of(config.values[i]);
  const py::object make = py::module_::import("swiftlet.modules").attr("_make");
  return std::make_unique<OwnedObject>(make(py::handle(config.of->type), values, setup_dict(setup)));
}

void bind_modules(py::module_& module) {
  module.def("_add_class", &add_class);
  bind_stages(module);
}

}  // namespace swiftlet::python
