// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/sim/scenario/document.hpp"

namespace swiftlet::sim {

/// Describes the first difference between two versions of a document, in the order of the earlier one (`then`), such as
/// `set.duration_s: "20" then, "30" now`. Empty if they are equal.
/// @param path  key path of both nodes, with which the description begins
std::string first_difference(const Node& then, const Node& now, const std::string& path = "");

}  // namespace swiftlet::sim
