// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/sim/scenario/yaml_reader.hpp"

namespace swiftlet::sim {

/// The complete YAML of a configuration with all defaults. Reading it gives the same bits; numbers are the shortest
/// texts with this property.
std::string write_config(const ConfigVisit& visit);

}  // namespace swiftlet::sim
