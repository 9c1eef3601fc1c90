// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "sim/render/cameras.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"

namespace swiftlet::sim {

/// Occlusion test of a follow camera: every surface blocks except leaves, which its pictures omit where they would hide
/// the vehicle. Empty without a world.
BlocksSight sight_in(std::shared_ptr<const StaticScene> world);

}  // namespace swiftlet::sim
