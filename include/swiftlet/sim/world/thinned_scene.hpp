// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Simplifies a scene for display to about `most_triangles` triangles, counted over all instances. Plants are thinned:
/// part of their leaves and branches is removed, and the remaining leaves are enlarged to cover the same area. All
/// other meshes are coarsened. Meshes and instances keep their indices.
Scene thinned_scene(const Scene& scene, std::size_t most_triangles);

/// True for a mesh of leaves or branches, which consists of many small pieces.
bool is_plant(const Mesh& mesh);

}  // namespace swiftlet::sim
