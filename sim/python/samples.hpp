// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "sim/python/fields.hpp"
#include "swiftlet/core/observation.hpp"

namespace swiftlet::python {

/// A copy of the samples of that kind, whether it has a name in Observation or not. Throws KeyError with what there is.
Table samples_named(const Observation& observation, const std::string& kind);

/// KeyError: which kinds of samples there are, and which was meant.
[[noreturn]] void reject_kind(const Observation& observation, const std::string& kind);

}  // namespace swiftlet::python
