// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/core/base/fields.hpp"

/// Data types with fields (swiftlet/core/base/fields.hpp) as numpy arrays that are views of the structs. The type's
/// `visit` provides names, offsets and descriptions.
namespace swiftlet::python {

namespace py = pybind11;

/// One field of a data type, and its offset in the struct.
struct Field {
  std::string name;
  std::string doc;
  std::ptrdiff_t offset = 0;
  const char* format = nullptr;  ///< numpy format; null: not numeric, `read` creates an object
  std::vector<py::ssize_t> shape;
  std::vector<py::ssize_t> strides;
  std::function<py::object(const std::byte* field)> read;
};

/// Array name of a pattern of fields.hpp: "v*_mps" -> "v_mps", "*_m" -> "position_m", "t_s" -> "t_ns".
std::string array_name(const std::string& pattern, const char* whole);

/// Times are in nanoseconds: "seen_s" -> "seen_ns".
inline std::string name_of_time(std::string name) {
  if (name.ends_with("_s")) name.replace(name.size() - 2, 2, "_ns");
  return name;
}

/// Visitor that records the fields of a struct.
class FieldNotes {
 public:
  explicit FieldNotes(const void* base) : base_(static_cast<const std::byte*>(base)) {}
  std::vector<Field> take() { return std::move(fields_); }

  void time(const char* name, const TimeNs& t, const char* doc) {
    numbers(name_of_time(name), &t, "q", {}, {}, "[ns]" + std::string(doc).substr(std::string(doc).find(']') + 1));
  }
  void field(const char* name, const bool& value, const char* doc) { numbers(name, &value, "?", {}, {}, doc); }
  void field(const char* name, const int& value, const char* doc) { numbers(name, &value, "i", {}, {}, doc); }
  void field(const char* name, const std::uint16_t& value, const char* doc) { numbers(name, &value, "H", {}, {}, doc); }
  void field(const char* name, const std::uint32_t& value, const char* doc) { numbers(name, &value, "I", {}, {}, doc); }
  void field(const char* name, const double& value, const char* doc) { numbers(name, &value, "d", {}, {}, doc); }
  void field(const char* name, const Vector3& value, const char* doc) {
    numbers(array_name(name, "value"), value.data(), "d", {3}, {8}, doc);
  }
  void field(const char* name, const Eigen::Quaterniond& value, const char* doc) {
    numbers(array_name(name, "q_xyzw"), value.coeffs().data(), "d", {4}, {8}, doc);
  }
  void field(const char* name, const Pose& value, const char* doc) {
    numbers(array_name(name, "pose"), value.matrix().data(), "d", {4, 4}, {8, 32}, doc);
  }
  void field(const char* name, const std::string& value, const char* doc) {
    object(name, &value, doc, [](const std::byte* at) { return py::str(*reinterpret_cast<const std::string*>(at)); });
  }
  void field(const char* name, const std::vector<std::byte>& value, const char* doc) {
    object(name, &value, doc, [](const std::byte* at) {
      const auto& bytes = *reinterpret_cast<const std::vector<std::byte>*>(at);
      return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    });
  }
  void valid(const char* name, const bool& value, const char* doc) { field(name, value, doc); }
  void vehicle(const char* name, const VehicleId& id, const char* doc) { field(name, id, doc); }
  template <class Enum>
  void choice(const char* name, const Enum& value, std::span<const char* const> words, const char* doc) {
    object(name, &value, doc, [words](const std::byte* at) {
      return py::str(words[static_cast<std::size_t>(*reinterpret_cast<const Enum*>(at))]);
    });
  }
  template <class Matrix>
  void covariance(const char* name, const Matrix& matrix, const char* doc) {
    const auto rows = static_cast<py::ssize_t>(Matrix::RowsAtCompileTime);
    numbers(array_name(name, "covariance"), matrix.data(), "d", {rows, rows}, {8, 8 * rows}, doc);
  }
  template <std::size_t N>
  void array(const char* name, const std::array<double, N>& values, const char* doc) {
    numbers(array_name(name, "values"), values.data(), "d", {static_cast<py::ssize_t>(N)}, {8}, doc);
  }

 private:
  void numbers(std::string name, const void* at, const char* format, std::vector<py::ssize_t> shape,
               std::vector<py::ssize_t> strides, std::string doc) {
    fields_.push_back({std::move(name), std::move(doc), static_cast<const std::byte*>(at) - base_, format,
                       std::move(shape), std::move(strides), nullptr});
  }
  void object(const char* name, const void* at, const char* doc, std::function<py::object(const std::byte*)> read) {
    fields_.push_back({name, doc, static_cast<const std::byte*>(at) - base_, nullptr, {}, {}, std::move(read)});
  }

  const std::byte* base_;
  std::vector<Field> fields_;
};

template <class Kind>
const std::vector<Field>& fields_of() {
  static const std::vector<Field> fields = [] {
    const Kind example;
    FieldNotes notes(&example);
    Kind::visit(example, notes);
    return notes.take();
  }();
  return fields;
}

/// A read-only numpy array that keeps `owner` alive.
py::array view_of(const char* format, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides,
                  const void* data, const std::shared_ptr<const void>& owner);

/// A C-contiguous view of `values`, as (rows, cols, ...) of `Scalar`.
template <class Scalar>
py::array view_of(const Scalar* data, std::vector<py::ssize_t> shape, const std::shared_ptr<const void>& owner) {
  std::vector<py::ssize_t> strides(shape.size());
  py::ssize_t stride = sizeof(Scalar);
  for (std::size_t i = shape.size(); i-- > 0; stride *= shape[i]) strides[i] = stride;
  return view_of(py::format_descriptor<Scalar>::value, std::move(shape), std::move(strides), data, owner);
}

/// Rows of one data type, as one array per column.
class Table {
 public:
  template <class Kind>
  static Table of(const Kind* rows, std::size_t count, std::shared_ptr<const void> owner) {
    return Table(fields_of<Kind>(), reinterpret_cast<const std::byte*>(rows), static_cast<py::ssize_t>(count),
                 sizeof(Kind), std::move(owner));
  }
  /// A copy, owned by the table.
  template <class Kind>
  static Table copy_of(std::span<const Kind> rows) {
    auto copy = std::make_shared<const std::vector<Kind>>(rows.begin(), rows.end());
    return of(copy->data(), copy->size(), copy);
  }
  /// A copy of one row, whose arrays have no leading dimension.
  template <class Kind>
  static Table row(const Kind& value) {
    auto copy = std::make_shared<const Kind>(value);
    Table table = of(copy.get(), 1, copy);
    table.single_ = true;
    return table;
  }

  /// Rows whose fields are cells of eight bytes; `owner` owns cells and texts.
  static Table of_cells(const std::vector<Field>& fields, std::span<const std::uint64_t> cells,
                        std::shared_ptr<const void> owner) {
    const auto width = static_cast<py::ssize_t>(fields.size());
    return Table(fields, reinterpret_cast<const std::byte*>(cells.data()),
                 static_cast<py::ssize_t>(cells.size()) / width, 8 * width, std::move(owner));
  }

  std::size_t size() const { return single_ ? 1 : static_cast<std::size_t>(count_); }
  /// Throws KeyError that lists the existing names.
  py::object column(std::string_view name);
  std::optional<py::object> find(std::string_view name);
  const std::vector<Field>& fields() const { return *fields_; }
  bool single() const { return single_; }

 private:
  Table(const std::vector<Field>& fields, const std::byte* data, py::ssize_t count, py::ssize_t stride,
        std::shared_ptr<const void> owner)
      : fields_(&fields),
        data_(data),
        count_(count),
        stride_(stride),
        owner_(std::move(owner)),
        arrays_(fields.size()) {}
  py::object make(const Field& field) const;

  const std::vector<Field>* fields_;
  const std::byte* data_;
  py::ssize_t count_;
  py::ssize_t stride_;
  std::shared_ptr<const void> owner_;
  bool single_ = false;
  std::vector<py::object> arrays_;  // created on first access
};

void bind_table(py::module_& module);

}  // namespace swiftlet::python
