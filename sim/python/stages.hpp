// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::python {

/// Adds a Python class to the registry of its kind: "guidance", "detector" or "agent". Throws when its name is taken.
void add_row(const std::string& kind, const ModuleType& module);

void bind_stages(pybind11::module_& module);

}  // namespace swiftlet::python
