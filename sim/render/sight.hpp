// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "sim/render/cameras.hpp"
#include "swiftlet/sim/raycast/ray_scene.hpp"

namespace swiftlet::sim {

/// What blocks the sight of a follow camera: every surface but leaves, which its pictures leave out where they are in
/// the way. Empty without a world.
BlocksSight sight_in(std::shared_ptr<const StaticScene> world);

}  // namespace swiftlet::sim
