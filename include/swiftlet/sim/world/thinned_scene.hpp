// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// A scene for looking at, with about so many triangles, instancing unrolled. Where it has more, plants lose leaves,
/// the others growing instead, and all else gets coarser. Meshes and instances keep their numbers.
Scene thinned_scene(const Scene& scene, std::size_t most_triangles);

/// Leaves and branches: a mesh of many small pieces.
bool is_plant(const Mesh& mesh);

}  // namespace swiftlet::sim
