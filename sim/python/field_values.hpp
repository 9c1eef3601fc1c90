// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "sim/python/fields.hpp"
#include "sim/python/values.hpp"
#include "swiftlet/sim/scenario/suggest.hpp"

namespace swiftlet::python {

/// Visitor that fills a sample from values by column name; all columns must be given.
class FieldValues {
 public:
  FieldValues(const std::string& kind, const py::dict& values, int num_vehicles)
      : kind_(kind), values_(values), num_vehicles_(num_vehicles) {}

  void time(const char* name, TimeNs& t, const char*) { t = cast<TimeNs>(name_of_time(name), "an integer"); }
  void field(const char* name, double& value, const char*) {
    value = finite(cast<double>(name, "a number"), place(name));
    require_spread(name, value);
  }
  void field(const char* pattern, Vector3& value, const char*) {
    const std::string name = array_name(pattern, "value");
    value = finite(vector_from(find(name), place(name)), place(name));
    require_spread(name, value.minCoeff());
  }
  void field(const char* pattern, Pose& value, const char*) {
    const std::string name = array_name(pattern, "pose");
    value = rigid(pose_from(find(name), place(name)), place(name));
  }
  void vehicle(const char* name, VehicleId& id, const char*) {
    id = cast<VehicleId>(name, "an integer");
    if (id >= kNoVehicle && id < num_vehicles_) return;
    throw py::value_error(place(name) + ": expected a vehicle from 0 to " + std::to_string(num_vehicles_ - 1) +
                          ", or -1 where it is not known, found " + std::to_string(id));
  }
  void covariance(const char* pattern, Matrix3& matrix, const char*) {
    const std::string name = array_name(pattern, "covariance");
    matrix = python::covariance(matrix3_from(find(name), place(name)), place(name));
  }

 private:
  std::string place(const std::string& name) const { return kind_ + ": " + name; }

  py::object find(const std::string& name) const {
    if (values_.contains(name)) return values_[py::str(name)];
    throw py::type_error(place(name) + ": expected a value, found none");
  }
  template <class Value>
  Value cast(const std::string& name, const char* expected) const {
    const py::object given = find(name);
    try {
      return given.cast<Value>();
    } catch (const py::cast_error&) {
      throw py::type_error(place(name) + ": expected " + expected + ", found " + shown(given));
    }
  }
  void require_spread(const std::string& name, double least) const {
    if (name.starts_with("sigma_") && least < 0.0)
      throw py::value_error(place(name) + ": expected no negative standard deviation, found " + shown(find(name)));
  }

  const std::string& kind_;
  const py::dict& values_;
  int num_vehicles_;
};

/// Throws TypeError on an unknown value, and on a missing one.
template <class Kind>
Kind filled(const std::string& name_of_kind, const py::dict& values, int num_vehicles) {
  std::vector<std::string> names;
  for (const Field& field : fields_of<Kind>()) names.push_back(field.name);
  for (const auto& [key, value] : values) {
    const auto name = key.template cast<std::string>();
    if (!sim::contains(names, name))
      throw py::type_error(name_of_kind + ": expected " + sim::one_of(names) + ", found \"" + name + "\"" +
                           sim::did_you_mean(name, names));
  }
  FieldValues visitor(name_of_kind, values, num_vehicles);
  Kind kind;
  Kind::visit(kind, visitor);
  return kind;
}

}  // namespace swiftlet::python
