// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/sim/scenario/document.hpp"

namespace swiftlet::sim {

/// The message of a scenario that does not take the changes of a batch: instead of "--set KEY: ..." it says where the
/// batch file sets, varies or sweeps that key. What it does not find there stays as it is.
/// @param batch  the batch file, merged with its bases
std::string with_places_of_changes(const std::string& message, const Node& batch);

}  // namespace swiftlet::sim
