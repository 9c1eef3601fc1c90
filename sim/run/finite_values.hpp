// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/base/observation.hpp"

namespace swiftlet::sim {

/// Check inputs and outputs of an agent. Throw a ContractViolation that names the first value that is not finite.
void ensure_finite(const Observation& observation);
void ensure_finite(const Action& action);

}  // namespace swiftlet::sim
