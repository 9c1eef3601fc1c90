// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

/// The module `swiftlet._core`: one function per file.
namespace swiftlet::python {

namespace py = pybind11;

void bind_errors(py::module_& module);
void bind_functions(py::module_& module);
void bind_make_scan(py::module_& module);
void bind_onboard(py::module_& module);
void bind_scenario(py::module_& module);
void bind_scan(py::module_& module);
void bind_modules(py::module_& module);
void bind_simulator(py::module_& module);

}  // namespace swiftlet::python
