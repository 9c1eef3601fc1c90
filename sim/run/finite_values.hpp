// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/observation.hpp"

namespace swiftlet::sim {

/// What goes into an agent and what comes out of it is finite. Throws a ContractViolation that names the first value
/// that is not.
void ensure_finite(const Observation& observation);
void ensure_finite(const Action& action);

}  // namespace swiftlet::sim
