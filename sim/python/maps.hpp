// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

#include "swiftlet/core/agent.hpp"

namespace swiftlet::python {

/// Copies of the maps that an agent keeps, by stage; numpy looks into the copies.
pybind11::dict maps_of(const Agent& agent);

}  // namespace swiftlet::python
