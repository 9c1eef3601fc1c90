// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "swiftlet/core/agent.hpp"
#include "swiftlet/core/config.hpp"

/// Modules written in Python: a class becomes a row of a registry, its keys those of a configuration.
namespace swiftlet::python {

namespace py = pybind11;

using KeyValue = std::variant<bool, int, double, std::string, Vector3, std::vector<double>>;

/// A key that scenarios may set. Its type is that of its default.
struct Key {
  std::string name;
  std::string doc;  ///< unit in brackets, meaning
  KeyValue standard;
  Range range;
  std::vector<std::string> words;  ///< of a text: one of these; none: any
};

/// What Python has told of a class. Is never freed: registries and configurations point to it.
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
  std::vector<KeyValue> values;  ///< by key

  explicit PythonConfig(const PythonClass& its_class);
  void visit(ConfigVisitor& v) override;
};

/// An object of Python that C++ owns: let go with Python's lock held, whoever does so.
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

/// Calls the class with the values of its keys and what a vehicle's software is told before the start. Takes the lock.
std::unique_ptr<OwnedObject> make_object(const PythonConfig& config, const AgentSetup& setup);

}  // namespace swiftlet::python
