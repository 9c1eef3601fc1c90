// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

#include "swiftlet/core/base/agent.hpp"

namespace swiftlet::python {

/// Copies of an agent's maps, by stage, as numpy views.
pybind11::dict maps_of(const Agent& agent);

}  // namespace swiftlet::python
