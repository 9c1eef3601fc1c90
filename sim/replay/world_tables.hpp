// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "sim/replay/block.hpp"
#include "swiftlet/sim/world/scene.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// The world as meshes and the places where they stand, thinned to about so many triangles.
void append_world(const Scene& whole, std::size_t most_triangles, ReplayBlock& block);
/// The meshes of a vehicle, its rotors apart.
void append_vehicle(const VehicleShape& shape, VehicleId vehicle, ReplayBlock& block);

}  // namespace swiftlet::sim
