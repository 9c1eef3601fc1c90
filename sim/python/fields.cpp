// SPDX-License-Identifier: BSD-3-Clause
#include "sim/python/fields.hpp"

#include <pybind11/stl.h>

#include <algorithm>

#include "swiftlet/sim/scenario/suggest.hpp"

namespace swiftlet::python {
namespace {

std::vector<std::string> names_of(const std::vector<Field>& fields) {
  std::vector<std::string> names(fields.size());
  std::ranges::transform(fields, names.begin(), [](const Field& field) { return field.name; });
  return names;
}

std::string unknown(const std::vector<Field>& fields, const std::string& name) {
  const std::vector<std::string> names = names_of(fields);
  return "expected " + sim::one_of(names) + ", found \"" + name + "\"" + sim::did_you_mean(name, names);
}

std::string shape_text(const Table& table, const Field& field) {
  if (field.format == nullptr) return table.single() ? "text" : "list of texts";
  std::string text = table.single() ? "" : "n";
  for (const py::ssize_t size : field.shape) text += (text.empty() ? "" : ", ") + std::to_string(size);
  return text.empty() ? "number" : "(" + text + (text.find(',') == std::string::npos ? ",)" : ")");
}

std::string describe(const Table& table) {
  std::string text = table.single() ? "one row\n" : std::to_string(table.size()) + " rows\n";
  for (const Field& field : table.fields())
    text += "  " + field.name + "  " + shape_text(table, field) + "  " + field.doc + "\n";
  return text;
}

// Columns first: Python's own search would raise and drop an exception before the look-up of columns.
PyObject* attribute_of(PyObject* self, PyObject* name) try {
  auto& table = py::cast<Table&>(py::handle(self));
  const char* text = PyUnicode_AsUTF8(name);
  if (text == nullptr) return nullptr;
  if (auto found = table.find(text)) return found->release().ptr();
  PyObject* other = PyObject_GenericGetAttr(self, name);
  if (other == nullptr && PyErr_ExceptionMatches(PyExc_AttributeError) && text[0] != '_')
    PyErr_SetString(PyExc_AttributeError, unknown(table.fields(), text).c_str());
  return other;
} catch (py::error_already_set& error) {
  error.restore();
  return nullptr;
}

}  // namespace

std::string array_name(const std::string& pattern, const char* whole) {
  std::string name = pattern;
  const std::size_t star = name.find('*');
  if (star == std::string::npos) return name;
  if (name == "*") return whole;
  if (star == 0) return "position" + name.substr(1);
  if (star + 1 == name.size()) return name.substr(0, star) + whole;
  const bool between_words = name[star - 1] == '_' && name[star + 1] == '_';
  return name.erase(star, between_words ? 2 : 1);
}

py::array view_of(const char* format, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides,
                  const void* data, const std::shared_ptr<const void>& owner) {
  auto* kept = new std::shared_ptr<const void>(owner);
  const py::capsule base(kept, [](void* pointer) { delete static_cast<std::shared_ptr<const void>*>(pointer); });
  py::array array(py::dtype(format), std::move(shape), std::move(strides), data, base);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

py::object Table::make(const Field& field) const {
  if (field.format != nullptr) {
    std::vector<py::ssize_t> shape = field.shape, strides = field.strides;
    if (!single_) {
      shape.insert(shape.begin(), count_);
      strides.insert(strides.begin(), stride_);
    }
    py::array array = view_of(field.format, std::move(shape), std::move(strides),
                              count_ == 0 ? nullptr : data_ + field.offset, owner_);
    return single_ && field.shape.empty() ? array[py::tuple()] : py::object(std::move(array));
  }
  if (single_) return field.read(data_ + field.offset);
  py::list values(count_);
  for (py::ssize_t i = 0; i < count_; ++i) values[i] = field.read(data_ + i * stride_ + field.offset);
  return values;
}

std::optional<py::object> Table::find(std::string_view name) {
  for (std::size_t i = 0; i < fields_->size(); ++i) {
    const Field& field = (*fields_)[i];
    if (field.name != name) continue;
    if (field.format == nullptr) return make(field);  // texts change with their rows
    if (!arrays_[i]) arrays_[i] = make(field);
    return arrays_[i];
  }
  return std::nullopt;
}

py::object Table::column(std::string_view name) {
  if (auto found = find(name)) return *found;
  throw py::key_error(unknown(*fields_, std::string(name)));
}

void bind_table(py::module_& module) {
  py::class_<Table> tables(module, "Table",
                           "Rows of one kind of data. Columns are read-only arrays by name, as item or attribute; "
                           "`print` shows their shapes and units.");
  tables.def("__len__", &Table::size)
      .def("__getitem__", &Table::column, py::arg("name"))
      .def("__dir__", [](const Table& table) { return py::cast(names_of(table.fields())); })
      .def(
          "keys", [](const Table& table) { return py::cast(names_of(table.fields())); }, "Names of the columns.")
      .def("__repr__", &describe);
  auto* type = reinterpret_cast<PyTypeObject*>(tables.ptr());
  type->tp_getattro = attribute_of;
  PyType_Modified(type);
}

}  // namespace swiftlet::python
