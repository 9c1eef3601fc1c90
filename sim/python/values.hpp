// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>

#include <string>

#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/base/finite.hpp"
#include "swiftlet/core/base/frames.hpp"

/// Conversion of Python arguments to C++ values. `what` names the argument in messages.
namespace swiftlet::python {

namespace py = pybind11;

template <class Scalar>
using Numbers = py::array_t<Scalar, py::array::c_style | py::array::forcecast>;

/// Representation of a value in an error message: its repr, shortened to one line.
std::string shown(py::handle value);

/// An array of real numbers. Throws TypeError on texts, complex numbers, rows of unequal length and the like.
py::array numbers_from(py::handle value, const std::string& what);

/// Convert anything that numpy accepts. Throw TypeError. Any frame, the same for all arguments.
Vector3 vector_from(py::handle value, const std::string& what);
Matrix3 matrix3_from(py::handle value, const std::string& what);
Pose pose_from(py::handle value, const std::string& what);

/// Returns the value; throws ValueError if a number in it is not finite.
template <class Value>
Value finite(const Value& value, const std::string& what) {
  if (is_finite(value)) return value;
  std::string found;
  contract::append_value(found, value);
  throw py::value_error(what + ": expected finite numbers, found " + found);
}

/// Returns the value; throws ValueError unless it is within [low, high].
double within(double value, double low, double high, const std::string& what);

/// Returns the pose; throws ValueError unless it is a rotation and translation.
Pose rigid(const Pose& pose, const std::string& what);

/// Returns the matrix; throws ValueError if it is not symmetric or has a negative eigenvalue.
Matrix3 covariance(const Matrix3& matrix, const std::string& what);

}  // namespace swiftlet::python
