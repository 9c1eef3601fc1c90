// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "sim/replay/block.hpp"
#include "swiftlet/sim/world/scene.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"
#include "swiftlet/sim/world/vehicle_state.hpp"

namespace swiftlet::sim {

/// Appends the world as meshes and their poses, thinned to about `most_triangles`.
void append_world(const Scene& whole, std::size_t most_triangles, ReplayBlock& block);
/// Appends the meshes of a vehicle, rotors separately.
void append_vehicle(const VehicleShape& shape, VehicleId vehicle, ReplayBlock& block);

}  // namespace swiftlet::sim
