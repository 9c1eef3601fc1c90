// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/sim/scenario/document.hpp"

namespace swiftlet::sim {

/// Error message for a scenario that rejects the changes of a batch: replaces "--set KEY: ..." by the location in the
/// batch file that sets, varies or sweeps the key. Keys without such a location are left unchanged.
/// @param batch  the batch file, merged with its bases
std::string with_places_of_changes(const std::string& message, const Node& batch);

}  // namespace swiftlet::sim
