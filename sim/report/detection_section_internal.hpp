// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace swiftlet::sim {

/// Recall and error of each detecting vehicle over the target's distance: plots, with their numbers in a collapsed
/// table.
/// @param over_distance  `detection_over_distance` of summary.json: bins by vehicle and stage
/// @return HTML, empty without counted targets. Throws nlohmann::json::exception on other content.
std::string detection_section(const nlohmann::ordered_json& over_distance);

}  // namespace swiftlet::sim
