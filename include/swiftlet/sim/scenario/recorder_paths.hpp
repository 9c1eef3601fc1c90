// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// True for a valid name of an output file or folder: letters, digits, '_', '-' and '.', at most 64, not hidden.
bool is_file_name(std::string_view name);

/// Checks that outputs lie in the run directory, that no two recorders write the same file, and that named vehicles
/// exist.
/// @param vehicles  names of the team; null: unknown
void check_recorders(ConfigVisitor& v, const std::vector<Module>& recorders, const std::vector<std::string>* vehicles);

}  // namespace swiftlet::sim
