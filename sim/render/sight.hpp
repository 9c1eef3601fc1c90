// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "sim/render/cameras.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"

namespace swiftlet::sim {

/// Test of the line of sight from a follow camera to its vehicle. Every surface blocks except leaves, which the
/// renderer omits where they would hide the vehicle. Returns an empty function if there is no world.
BlocksSight sight_in(std::shared_ptr<const StaticScene> world);

}  // namespace swiftlet::sim
