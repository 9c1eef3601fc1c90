// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/scenario/document.hpp"

namespace swiftlet::sim {

/// Converts a map of keys into single changes, leaf by leaf: {a: {b: 1}, "c[0]": {d: x}} -> ("a.b", "1"), ("c[0].d",
/// "x"). A `type` comes first, since it replaces the module. Applied in this order, they are equivalent to the map.
ConfigChanges changes_of(const Node& map);

/// A value on one line; parsing it gives the same value.
std::string flow_text(const Node& value);

}  // namespace swiftlet::sim
