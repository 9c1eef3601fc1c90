// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "swiftlet/core/action.hpp"
#include "swiftlet/core/observation.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// Hash of everything that one vehicle was given to know in one tick (XXH3, 64 bits). Covers every sensor output.
std::uint64_t hash_of(const Observation& observation);

/// Hash of everything that one vehicle did in one tick, but for its overlays.
std::uint64_t hash_of(const Action& action);

/// Hash of one vehicle's true state.
std::uint64_t hash_of(const VehicleState& state);

/// The next value of a running hash; the order of calls matters.
std::uint64_t combine(std::uint64_t hash, std::uint64_t value);

}  // namespace swiftlet::sim
