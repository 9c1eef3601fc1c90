// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/sim/scenario/yaml_reader.hpp"

namespace swiftlet::sim {

/// The complete YAML of a configuration, every default written out. Reading it gives the same bits again; numbers are
/// the shortest texts for which that holds.
std::string write_config(const ConfigVisit& visit);

}  // namespace swiftlet::sim
