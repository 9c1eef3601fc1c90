// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "swiftlet/core/config.hpp"

namespace swiftlet::sim {

/// Can it be the name of a file or folder of ours? Letters, digits, '_', '-' and '.', at most 64, no hidden file.
bool is_file_name(std::string_view name);

/// What recorders write lies in the run directory, no two write the same, and the vehicles that they name are there.
/// @param vehicles  names of the team; null: not known yet
void check_recorders(ConfigVisitor& v, const std::vector<Module>& recorders, const std::vector<std::string>* vehicles);

}  // namespace swiftlet::sim
