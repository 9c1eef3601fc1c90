// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "sim/python/fields.hpp"
#include "sim/python/modules.hpp"

namespace swiftlet::python {

/// The visitor that fills a kind of data from values by the names of its arrays.
class FieldValues {
 public:
  explicit FieldValues(const py::dict& values) : values_(values) {}

  void time(const char* name, TimeNs& t, const char*) { take(name_of_time(name), t); }
  void field(const char* name, bool& value, const char*) { take(name, value); }
  void field(const char* name, double& value, const char*) { take(name, value); }
  void field(const char* name, Vector3& value, const char*) {
    const std::string key = array_name(name, "value");
    if (const py::object told = find(key); !told.is_none()) value = vector_from(told, key.c_str());
  }
  void field(const char* name, Pose& value, const char*) {
    if (const py::object told = find(array_name(name, "pose")); !told.is_none()) value = pose_from(told);
  }
  void valid(const char* name, bool& value, const char*) { take(name, value); }
  void vehicle(const char* name, VehicleId& id, const char*) { take(name, id); }
  void covariance(const char* name, Matrix3& matrix, const char*) {
    const std::string key = array_name(name, "covariance");
    if (const py::object told = find(key); !told.is_none()) matrix = matrix3_from(told, key.c_str());
  }

 private:
  py::object find(const std::string& name) const {
    return values_.contains(name) ? py::object(values_[py::str(name)]) : py::object(py::none());
  }
  template <class Value>
  void take(const std::string& name, Value& value) {
    if (const py::object told = find(name); !told.is_none()) value = told.template cast<Value>();
  }

  const py::dict& values_;
};

/// Throws KeyError on a value that the kind does not have.
template <class Kind>
Kind filled(const py::dict& values) {
  Kind kind;
  Table names = Table::row(kind);
  for (const auto& [name, value] : values) (void)names.column(name.template cast<std::string>());
  FieldValues visitor(values);
  Kind::visit(kind, visitor);
  return kind;
}

}  // namespace swiftlet::python
