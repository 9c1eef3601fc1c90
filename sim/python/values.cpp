// SPDX-License-Identifier: BSD-3-Clause
#include "sim/python/values.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <vector>

namespace swiftlet::python {
namespace {

bool holds_numbers(const py::array& array) {
  constexpr std::string_view kKinds = "iuf";  // numpy: integers, unsigned integers, floating point
  return array && kKinds.find(array.dtype().kind()) != std::string_view::npos;
}

// Converts in numpy's order, row by row.
std::vector<double> numbers_of_shape(py::handle value, const std::string& what, std::span<const py::ssize_t> shape) {
  const py::array array = py::array::ensure(value);
  if (!holds_numbers(array) || !std::equal(shape.begin(), shape.end(), array.shape(), array.shape() + array.ndim())) {
    std::string size;
    for (const py::ssize_t rows : shape) size += (size.empty() ? "" : " x ") + std::to_string(rows);
    throw py::type_error(what + ": expected " + size + " numbers, found " + shown(value));
  }
  const Numbers<double> numbers(array);
  return {numbers.data(), numbers.data() + numbers.size()};
}

// Formats row by row, like numpy.
template <class Matrix>
std::string text_of(const Matrix& matrix) {
  std::string text;
  contract::append_value(text, Matrix(matrix.transpose()));
  return text;
}

}  // namespace

std::string shown(py::handle value) {
  // [characters] Longest text of a value in a message.
  constexpr std::size_t kLongest = 100;
  const py::str text = py::repr(value).attr("replace")("\n", " ");
  if (py::len(text) <= kLongest) return text;
  return py::str(text[py::slice(0, kLongest, 1)]).cast<std::string>() + " ...";
}

py::array numbers_from(py::handle value, const std::string& what) {
  py::array array = py::array::ensure(value);
  if (!holds_numbers(array)) throw py::type_error(what + ": expected numbers, found " + shown(value));
  return array;
}

Vector3 vector_from(py::handle value, const std::string& what) {
  return Vector3(numbers_of_shape(value, what, std::array<py::ssize_t, 1>{3}).data());
}

Matrix3 matrix3_from(py::handle value, const std::string& what) {
  return Matrix3(numbers_of_shape(value, what, std::array<py::ssize_t, 2>{3, 3}).data()).transpose();
}

Pose pose_from(py::handle value, const std::string& what) {
  Pose pose = Pose::Identity();
  pose.matrix() = Eigen::Matrix4d(numbers_of_shape(value, what, std::array<py::ssize_t, 2>{4, 4}).data()).transpose();
  return pose;
}

double within(double value, double low, double high, const std::string& what) {
  if (value >= low && value <= high) return value;
  std::string text = what + ": expected a number from ";
  contract::append(text, low);
  text += " to ";
  contract::append(text, high);
  text += ", found ";
  contract::append(text, value);
  throw py::value_error(text);
}

Pose rigid(const Pose& pose, const std::string& what) {
  constexpr double kTolerance = 1e-3;  // relative; above the rounding of float32 and of printed digits
  const Matrix3 R = pose.linear();
  const bool is_rotation = R.determinant() > 0.0 && (R * R.transpose()).isApprox(Matrix3::Identity(), kTolerance);
  if (is_finite(pose) && is_rotation && pose.matrix().row(3) == Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)) return pose;
  throw py::value_error(what + ": expected a rotation and a translation, found " +
                        text_of(Eigen::Matrix4d(pose.matrix())));
}

Matrix3 covariance(const Matrix3& matrix, const std::string& what) {
  constexpr double kTolerance = 1e-6;  // relative; above the rounding of float32
  if (is_finite(matrix)) {
    const double scale = matrix.cwiseAbs().maxCoeff();
    const bool is_symmetric = (matrix - matrix.transpose()).cwiseAbs().maxCoeff() <= kTolerance * scale;
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(matrix, Eigen::EigenvaluesOnly);
    if (is_symmetric && solver.eigenvalues().minCoeff() >= -kTolerance * scale) return matrix;
  }
  throw py::value_error(what + ": expected a symmetric matrix without negative eigenvalues, found " + text_of(matrix));
}

}  // namespace swiftlet::python
