// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "swiftlet/core/base/action.hpp"
#include "swiftlet/core/base/observation.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// Hash of one vehicle's observation in one tick (XXH3, 64 bits). Covers every sensor output.
std::uint64_t hash_of(const Observation& observation);

/// Hash of one vehicle's action in one tick, without overlays.
std::uint64_t hash_of(const Action& action);

/// Hash of one vehicle's true state.
std::uint64_t hash_of(const VehicleState& state);

/// Next value of a running hash; the order of calls matters.
std::uint64_t combine(std::uint64_t hash, std::uint64_t value);

}  // namespace swiftlet::sim
