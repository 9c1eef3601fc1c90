// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "swiftlet/core/config.hpp"
#include "swiftlet/sim/scenario/document.hpp"

namespace swiftlet::sim {

/// A map of keys as single changes, leaf by leaf: {a: {b: 1}, "c[0]": {d: x}} -> ("a.b", "1"), ("c[0].d", "x"). A
/// `type` goes first, since it replaces what was there. Laid on a configuration in this order, they do what the map
/// does.
ConfigChanges changes_of(const Node& map);

/// A value on one line, so that parsing it gives the same value.
std::string flow_text(const Node& value);

}  // namespace swiftlet::sim
