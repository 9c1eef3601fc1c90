// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/sim/scenario/document.hpp"

namespace swiftlet::sim {

/// The first differing value, in the order of `then`: "set.duration_s: "20" then, "30" now". Empty without difference.
std::string first_difference(const Node& then, const Node& now, const std::string& path = "");

}  // namespace swiftlet::sim
