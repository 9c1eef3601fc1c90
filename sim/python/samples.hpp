// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "sim/python/fields.hpp"
#include "swiftlet/core/base/observation.hpp"

namespace swiftlet::python {

/// A copy of the samples of that kind, with or without a name in Observation. Throws KeyError with the existing kinds.
Table samples_named(const Observation& observation, const std::string& kind);

/// Throws KeyError with the existing kinds and the nearest match.
[[noreturn]] void reject_kind(const Observation& observation, const std::string& kind);

}  // namespace swiftlet::python
