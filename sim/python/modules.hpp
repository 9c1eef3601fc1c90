// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/config.hpp"

/// Modules written in Python: a class becomes a row of a registry, its keys a configuration.
namespace swiftlet::python {

namespace py = pybind11;

using KeyValue = std::variant<bool, int, double, std::string, Vector3, std::vector<double>>;

/// A key for scenarios. Its type is that of the default.
struct Key {
  std::string name;
  std::string doc;  ///< unit in brackets, description
  KeyValue standard;
  Range range;
  std::vector<std::string> words;  ///< allowed words of a text; empty: any
};

/// Definition of a class by Python. Never freed: registries and configurations point to it.
struct PythonClass {
  std::string name;
  std::string doc;
  PyObject* type = nullptr;
  std::vector<Key> keys;
  AgentNeeds needs;
  bool needs_clouds = false;
  bool needs_map = false;
  bool needs_relatives = false;
  bool needs_world = true;
};

struct PythonConfig : ModuleConfigOf<PythonConfig> {
  const PythonClass* of = nullptr;
  std::vector<KeyValue> values;  ///< indexed by key

  explicit PythonConfig(const PythonClass& its_class);
  void visit(ConfigVisitor& v) override;
};

/// A Python object owned by C++; releases it with the GIL held, on any thread.
class OwnedObject {
 public:
  explicit OwnedObject(py::object object) : object_(object.release()) {}
  ~OwnedObject();
  OwnedObject(const OwnedObject&) = delete;
  OwnedObject& operator=(const OwnedObject&) = delete;
  py::handle get() const { return object_; }

 private:
  py::handle object_;
};

/// Constructs an object from the values of its keys and the agent's setup. Acquires the GIL.
std::unique_ptr<OwnedObject> make_object(const PythonConfig& config, const AgentSetup& setup);

}  // namespace swiftlet::python
