// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/sim/scenario/yaml_reader.hpp"

namespace swiftlet::sim {

/// Every key of a scenario and of every module available in it, as Markdown: docs/reference.md.
std::string write_reference();

/// Tables of any configuration: its own keys first, then each module type that can be chosen below it.
std::string reference_tables(const ConfigVisit& visit, const std::string& title);

}  // namespace swiftlet::sim
